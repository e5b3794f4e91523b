"""Which differences of engine and machine call for the tolerances for elsewhere, and that all are said."""

import pytest

from slipctl.regression.judging.origin import Origin, differences, is_elsewhere
from tests.fakes import MACHINE

HERE = Origin("sha256:m", {"slipctl": "1", "mujoco": "4.0.0", "numpy": "2.4.6"}, MACHINE)


def other(model_id="sha256:m", machine=None, **versions):
    return Origin(model_id, {**HERE.versions, **versions}, MACHINE | (machine or {}))


DIFFERENT = [
    (other(mujoco="4.1.0"), True, "mujoco 4.0.0 then, 4.1.0 now"),
    (other("sha256:n"), True, "model sha256:m then, sha256:n now"),
    (
        other(machine={"family": "aarch64 0x41 8"}),
        True,
        "processor family x86_64 AVendor 1 then, aarch64 0x41 8 now",
    ),
    (other(machine={"system": "Windows"}), True, "operating system Linux then, Windows now"),
    (other(numpy="2.5.0"), False, "numpy 2.4.6 then, 2.5.0 now"),
    (other(slipctl="2"), False, "slipctl 1 then, 2 now"),
    (other(scipy="1.17"), False, "scipy absent then, 1.17 now"),
]


@pytest.mark.parametrize(("now", "elsewhere", "said"), DIFFERENT)
def test_every_difference_is_said_and_some_widen_the_tolerances(now, elsewhere, said):
    assert is_elsewhere(HERE, now) is is_elsewhere(now, HERE) is elsewhere
    how = ", with the tolerances for elsewhere" if elsewhere else ""
    assert differences(HERE, now) == [f"{said}: judged all the same{how}"]


def test_nothing_is_said_of_the_same_origin():
    assert differences(HERE, other()) == []
    assert not is_elsewhere(HERE, other())


def test_another_processor_of_the_same_family_is_the_same_origin():
    assert differences(HERE, other(machine={"processor": "a faster one"})) == []


def test_all_differences_share_one_sentence():
    (sentence,) = differences(HERE, other("sha256:n", {"system": "Darwin"}, mujoco="4.1.0"))
    assert sentence == (
        "model sha256:m then, sha256:n now; mujoco 4.0.0 then, 4.1.0 now; "
        "operating system Linux then, Darwin now: judged all the same, with the tolerances for elsewhere"
    )


def test_what_is_not_known_is_said_to_be_absent_or_unknown():
    nowhere = Origin("sha256:m", {"slipctl": "1", "mujoco": "4.0.0"}, {})
    (sentence,) = differences(HERE, nowhere)
    assert sentence.startswith("numpy 2.4.6 then, absent now; operating system Linux then, unknown now; ")
    (sentence,) = differences(nowhere, HERE)
    assert sentence.startswith("numpy absent then, 2.4.6 now; operating system unknown then, Linux now; ")


def test_a_manifest_tells_the_origin():
    manifest = {"model_id": "sha256:m", "versions": HERE.versions, "machine": MACHINE | {"cores": 2}}
    assert Origin.of_manifest(manifest) == HERE


def test_a_manifest_of_an_older_slipctl_names_no_family_and_is_elsewhere():
    machine = {name: value for name, value in MACHINE.items() if name != "family"}
    old = Origin.of_manifest({"model_id": "sha256:m", "versions": HERE.versions, "machine": machine})
    assert old.machine["family"] == "unknown"
    assert is_elsewhere(HERE, old)
