"""The baseline file: written whole, read strictly."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from slipctl import shipped
from slipctl.metrics import UNITS
from slipctl.regression import CannotJudge, read, write
from slipctl.regression.baseline.file import run_key
from slipctl.regression.baseline.gated import GATED, NOTEWORTHY
from tests.fakes import baseline_of, payload, run_entry


@pytest.fixture
def baseline():
    return baseline_of(
        payload([run_entry("a", 0.1), run_entry("b", 0.1, None, status="diverged"), run_entry("a", 0.8)])
    )


def test_what_is_written_is_read_back(baseline, tmp_path):
    path = tmp_path / "new" / "and deep" / "x.json"
    write(baseline, path)
    assert read(path) == baseline
    assert [entry.name for entry in path.parent.iterdir()] == ["x.json"]


def test_every_number_has_a_line_of_its_own(baseline, tmp_path):
    write(baseline, tmp_path / "x.json")
    lines = (tmp_path / "x.json").read_text(encoding="utf-8").splitlines()
    assert sum('"tolerance"' in line for line in lines) == 3 * len(GATED)
    assert all(line.count('"tolerance"') <= 1 for line in lines)


def test_a_file_is_laid_out_for_reading_a_diff(baseline, tmp_path):
    """UTF-8 as it is said, one space deeper per level, and line ends that every system writes alike."""
    run = baseline.runs[0].model_copy(update={"controller": "größer"})
    write(baseline.model_copy(update={"reason": "glättere Straße", "runs": [run]}), tmp_path / "x.json")
    content = (tmp_path / "x.json").read_bytes()
    for said in ('\n "format": 2,\n', '\n "reason": "glättere Straße",\n', '\n  {"controller": "größer", '):
        assert said.encode() in content
    assert b"\r" not in content
    assert content.endswith(b"}\n  }}\n ]\n}\n")


def test_a_failed_write_leaves_the_old_file(baseline, tmp_path, monkeypatch):
    path = tmp_path / "x.json"
    path.write_text("old")
    monkeypatch.setattr("slipctl.regression.baseline.file._text", lambda _: "\ud800")  # cannot be encoded
    with pytest.raises(UnicodeEncodeError):
        write(baseline, path)
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


def test_a_missing_baseline_says_how_to_record_one(tmp_path):
    with pytest.raises(CannotJudge, match="slipctl check ice --record"):
        read(tmp_path / "ice.json")


def test_the_gated_metrics_are_metrics():
    assert set(GATED) < set(UNITS)
    assert list(GATED) == [name for name in UNITS if name in GATED]


def damage(change):
    def apply(text):
        content = json.loads(text)
        change(content)
        return json.dumps(content)

    return apply


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda text: text[: len(text) // 2], "damaged"),
        (lambda text: "", "damaged"),
        (lambda text: "[]", "damaged"),
        (damage(lambda c: c.pop("scenario_id")), "scenario_id"),
        (
            damage(lambda c: c.update(format=1)),
            "format 1, whose tolerances were not measured; record it again",
        ),
        (damage(lambda c: c.update(format=3)), "format 3, newer than this slipctl, which reads format 2"),
        (damage(lambda c: c.update(format="two")), "format"),
        (damage(lambda c: c.update(format=2.0)), "the format is a whole number, not 2.0"),
        (damage(lambda c: c.pop("versions")), "versions"),
        (damage(lambda c: c["runs"][0].pop("ticks")), "ticks"),
        (damage(lambda c: c.update(extra=1)), "extra"),
        (damage(lambda c: c["runs"][0]["metrics"]["rms_position_error"].update(tolerance="x")), "tolerance"),
        (damage(lambda c: c.update(runs=[])), "no runs"),
        (damage(lambda c: c["runs"].append(c["runs"][0])), "the same run twice"),
    ],
)
def test_a_damaged_baseline_is_named_in_one_line(baseline, tmp_path, spoil, said):
    path = tmp_path / "x.json"
    write(baseline, path)
    path.write_text(spoil(path.read_text(encoding="utf-8")), encoding="utf-8")
    with pytest.raises(CannotJudge, match=said) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_damaged_place_is_said_as_people_say_it(baseline, tmp_path):
    """Each message whole, so that nothing creeps into it."""
    path = tmp_path / "x.json"
    write(baseline, path)
    text = path.read_text(encoding="utf-8")
    once_more = "record it again: slipctl check x --update --reason '…'"
    changes = [
        (
            damage(lambda c: c["runs"][1]["metrics"]["rms_heading_error"].update(tolerance=-1.0)),
            "damaged at runs.1.metrics.rms_heading_error.tolerance: "
            "Input should be greater than or equal to 0",
        ),
        (
            damage(lambda c: c["runs"][0].update(metrics={})),
            f"damaged at runs.0.metrics: it must hold {', '.join(GATED)}, and no other metric",
        ),
        (damage(lambda c: c.update(runs=[])), "damaged: no runs"),
        (damage(lambda c: c["runs"].append(c["runs"][0])), "damaged: the same run twice"),
    ]
    for spoil, said in changes:
        path.write_text(spoil(text), encoding="utf-8")
        with pytest.raises(CannotJudge) as caught:
            read(path)
        assert str(caught.value) == f"baseline {path} is {said}; {once_more}"
    path.write_text("[]", encoding="utf-8")
    with pytest.raises(CannotJudge, match="is damaged at the file: Input should be an object; record"):
        read(path)


def test_runs_that_differ_in_the_seed_only_are_two(tmp_path):
    two = baseline_of(payload([run_entry("a", seed=1), run_entry("a", seed=2)]))
    write(two, tmp_path / "x.json")
    assert [run.seed for run in read(tmp_path / "x.json").runs] == [1, 2]


def test_a_folder_in_its_place_is_no_baseline(tmp_path):
    path = tmp_path / "ice.json"
    path.mkdir()
    with pytest.raises(CannotJudge) as caught:
        read(path)
    assert str(caught.value) == (
        f"a folder is in place of the baseline {path}; "
        "move it away and record one: slipctl check ice --record"
    )


def test_bytes_that_are_no_text_cannot_be_judged(tmp_path):
    (tmp_path / "x.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(CannotJudge, match="it is not UTF-8 text; record it again: "):
        read(tmp_path / "x.json")


@pytest.mark.parametrize(
    ("planted", "where"),
    [
        (lambda metrics: metrics.clear(), "metrics"),
        (lambda metrics: metrics.pop("max_position_error"), "metrics"),
        (lambda metrics: metrics["rms_position_error"].update(tolerance=float("inf")), "tolerance"),
        (lambda metrics: metrics["rms_position_error"].update(tolerance=-1e-3), "tolerance"),
        (lambda metrics: metrics["rms_position_error"].update(value=float("nan")), "value"),
        (lambda metrics: metrics["rms_position_error"].update(spread=1e-3), "spread"),
        (lambda metrics: metrics["rms_position_error"].update(halving=1e-2), "half the timestep"),
        (lambda metrics: metrics["rms_position_error"].update(tolerance_elsewhere=0.0), "elsewhere"),
        (
            lambda metrics: metrics["rms_position_error"].update(tolerance=1e-2, tolerance_elsewhere=1e-2),
            "the tolerance of rms_position_error is 0.01, but what was measured allows",
        ),
        (
            lambda metrics: metrics["rms_position_error"].update(tolerance_elsewhere=1e-2),
            "the tolerance elsewhere of rms_position_error is 0.01, but what was measured allows",
        ),
        (
            lambda metrics: metrics["guarantee_fraction"].update(tolerance=0.5, tolerance_elsewhere=0.5),
            "the tolerance of guarantee_fraction is 0.5",
        ),
        (lambda metrics: metrics["rms_position_error"].update(spread=None), "no spread"),
        (
            lambda metrics: metrics["rms_position_error"].update(
                value=None, tolerance=0.0, tolerance_elsewhere=0.0, spread=None, halving=None
            ),
            "has no value though the run completed",
        ),
        (lambda metrics: metrics["rms_position_error"].update(gate="verdict"), "it hardly moved"),
        (lambda metrics: metrics["rms_position_error"].update(gate="verdict", spread=None), "hardly moved"),
        (
            lambda metrics: metrics["rms_position_error"].update(
                value=0.1, spread=0.03, tolerance=0.3, tolerance_elsewhere=0.3
            ),
            "cannot be gated on its number",
        ),
        (lambda metrics: metrics["rms_position_error"].update(gate="none"), "gate"),
    ],
)
def test_a_baseline_that_could_never_fail_is_damaged(tmp_path, planted, where):
    """Each of these would have let any result pass."""
    shipped_one = json.loads((shipped.baseline_folder() / "wet-slope.json").read_text(encoding="utf-8"))
    (robust,) = (run for run in shipped_one["runs"] if run["controller"] == "robust_kinematic")
    planted(robust["metrics"])
    path = tmp_path / "planted.json"
    path.write_text(json.dumps(shipped_one), encoding="utf-8")
    with pytest.raises(CannotJudge, match=where) as caught:
        read(path)
    assert "\n" not in str(caught.value)
    assert "record it again: slipctl check planted --update --reason" in str(caught.value)


@pytest.mark.parametrize(
    ("metric", "planted", "said"),
    [
        (
            "rms_position_error",
            {"tolerance": 1.5e-4, "tolerance_elsewhere": 1.5e-4},
            "the tolerance of rms_position_error is 0.00015, but what was measured allows 0.0001",
        ),
        (
            "rms_position_error",
            {"tolerance_elsewhere": 1.5e-4},
            "the tolerance elsewhere of rms_position_error is 0.00015, but what was measured allows 0.0001",
        ),
        (
            "guarantee_fraction",
            {"value": None, "spread": None, "tolerance": 1e-9, "tolerance_elsewhere": 1e-9},
            "the tolerance of guarantee_fraction is 1e-09, but what was measured allows 0",
        ),
    ],
)
def test_a_tolerance_wider_than_what_was_measured_is_damaged(tmp_path, metric, planted, said):
    """Of a spread of 1e-5 ten times that, and no more elsewhere where no timestep was halved."""
    path = tmp_path / "x.json"
    write(baseline_of(payload([run_entry("a")])), path)
    content = json.loads(path.read_text(encoding="utf-8"))
    number = content["runs"][0]["metrics"][metric]
    number |= {"halving": None, "tolerance_elsewhere": number["tolerance"]}
    path.write_text(json.dumps(content), encoding="utf-8")
    assert read(path).runs[0].metrics[metric].tolerance == 1e-4
    number |= planted
    path.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(CannotJudge, match=said):
        read(path)


def test_a_run_is_the_same_in_whatever_order_its_keys_are_given():
    assert run_key("a", {"x": 1, "y": [2.0]}, 3) == run_key("a", {"y": [2.0], "x": 1}, 3)
    assert run_key("a", {"x": 1, "y": 2}, 3) != run_key("a", {"x": 2, "y": 1}, 3)


def test_a_chaotic_number_may_have_moved_further_than_any_tolerance(tmp_path):
    shipped_one = json.loads((shipped.baseline_folder() / "wet-slope.json").read_text(encoding="utf-8"))
    shipped_one["runs"][0]["metrics"]["rms_position_error"].update(gate="verdict", value=0.1, spread=0.5)
    path = tmp_path / "chaotic.json"
    path.write_text(json.dumps(shipped_one), encoding="utf-8")
    assert read(path).runs[0].metrics["rms_position_error"].gate == "verdict"


def test_a_run_that_may_end_otherwise_has_no_gated_number(tmp_path):
    shipped_one = json.loads((shipped.baseline_folder() / "wet-slope.json").read_text(encoding="utf-8"))
    shipped_one["runs"][0]["statuses_seen"] = ["tipped"]
    path = tmp_path / "planted.json"
    path.write_text(json.dumps(shipped_one), encoding="utf-8")
    with pytest.raises(CannotJudge, match="moved so far that it cannot be gated on its number"):
        read(path)
    for number in shipped_one["runs"][0]["metrics"].values():
        number.update(gate="verdict", spread=None)
    path.write_text(json.dumps(shipped_one), encoding="utf-8")
    assert read(path).runs[0].statuses_seen == ["tipped"]


@pytest.mark.parametrize("name", [path.stem for path in shipped.baseline_folder().glob("*.json")])
def test_what_is_shipped_allows_no_more_than_a_fifth_of_a_number(name):
    for run in read(shipped.baseline_folder() / f"{name}.json").runs:
        for metric, number in run.metrics.items():
            if number.value is not None and number.gate == "number":
                assert number.tolerance <= max(0.2 * abs(number.value), NOTEWORTHY[metric])


@settings(max_examples=50, deadline=None)
@given(st.integers(min_value=0, max_value=10**6))
def test_a_baseline_cut_off_anywhere_cannot_be_judged(tmp_path_factory, length):
    text = (shipped.baseline_folder() / "wet-slope.json").read_text(encoding="utf-8")
    path = tmp_path_factory.mktemp("cut") / "x.json"
    path.write_text(text[: length % (len(text) - 2)], encoding="utf-8")
    with pytest.raises(CannotJudge) as caught:
        read(path)
    assert "\n" not in str(caught.value)
