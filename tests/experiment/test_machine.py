"""The processor's family, from what each system tells of it."""

import pytest

from slipctl.experiment import machine as module
from slipctl.experiment.machine import family, machine, source


@pytest.mark.parametrize(
    ("architecture", "described", "processor", "named"),
    [
        ("x86_64", {"vendor_id": "GenuineIntel", "cpu family": "6"}, "x86_64", "x86_64 GenuineIntel 6"),
        ("x86_64", {"vendor_id": "AuthenticAMD", "cpu family": "25"}, "", "x86_64 AuthenticAMD 25"),
        ("aarch64", {"CPU implementer": "0x41", "CPU architecture": "8"}, "", "aarch64 0x41 8"),
        ("AMD64", {}, "Intel64 Family 6 Model 85 Stepping 7, GenuineIntel", "x86_64 GenuineIntel 6"),
        ("AMD64", {}, "AMD64 Family 25 Model 33 Stepping 0, AuthenticAMD", "x86_64 AuthenticAMD 25"),
        ("arm64", {}, "arm", "aarch64 arm"),
        ("x86_64", {}, "x86_64", "x86_64"),
        ("", {}, "", "unknown"),
    ],
)
def test_a_family_has_one_name_on_every_system(architecture, described, processor, named):
    assert family(architecture, described, processor) == named


def test_what_linux_tells_is_read(tmp_path, monkeypatch):
    told = (
        "processor\t: 0\nvendor_id\t: GenuineIntel\ncpu family\t: 6\nmodel name\t: A: B\n\nprocessor\t: 1\n"
    )
    (tmp_path / "cpuinfo").write_text(told, encoding="utf-8")
    monkeypatch.setattr(module, "CPU_INFO", tmp_path / "cpuinfo")
    found = machine()
    assert found["processor"] == "A: B"
    assert found["family"].endswith("GenuineIntel 6")


def test_without_it_a_machine_still_has_a_family(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "CPU_INFO", tmp_path / "none")
    found = machine()
    assert found["family"]
    assert found.keys() == {"system", "architecture", "processor", "family", "cores", "python"}


def test_the_hash_of_the_source_is_of_names_and_text_but_not_of_line_ends(tmp_path, monkeypatch):
    def hashed(files):
        package = tmp_path / str(len(list(tmp_path.iterdir())))
        for name, content in files.items():
            (package / name).parent.mkdir(parents=True, exist_ok=True)
            (package / name).write_bytes(content)
        monkeypatch.setattr(module, "__file__", str(package / "inner" / "machine.py"))
        return source.__wrapped__()

    first = hashed({"a.py": b"1\n2\n", "inner/b.py": b"3"})
    assert hashed({"a.py": b"1\r\n2\r\n", "inner/b.py": b"3", "note.txt": b"4"}) == first
    others = (
        {"a.py": b"1\n3\n", "inner/b.py": b"3"},
        {"c.py": b"1\n2\n", "inner/b.py": b"3"},
        {"a.py": b"1\n2\n"},
    )
    assert len({first, *map(hashed, others)}) == 4
