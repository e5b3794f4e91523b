"""Certificates: where they lie, what they are for, and what is said of two."""

import json
from pathlib import Path

import pytest

from slipctl.certify import certificate, examine
from slipctl.certify.certificate import CertificateError, State, cache_folder, key_of, read, standing, store
from slipctl.plants.model import find_model

SHIPPED = find_model("magellan_pro")


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPCTL_CACHE", str(tmp_path / "cache"))


def content(**changed):
    checks = [
        {"name": "mass", "measured": 18.2, "error": 0.0, "tolerance": 1e-6, "unit": "kg", "passed": True},
        {
            "name": "creep",
            "measured": 0.005,
            "error": 0.005,
            "tolerance": 0.01,
            "unit": "mm/s",
            "passed": True,
        },
    ]
    for name, parts in changed.items():
        next(check for check in checks if check["name"] == name).update(parts)
    versions = {"slipctl": "0.1.0", "mujoco": "4.0.0"}
    return {
        "model": "m",
        "model_id": "sha256:a",
        "timestep": 0.001,
        "contacts": "c",
        "versions": versions,
        "checks": checks,
    }


def test_without_a_certificate_a_model_is_not_certified():
    assert standing("magellan_pro", 0.001).state is State.MISSING


def test_a_certificate_is_for_one_timestep():
    store(key_of("magellan_pro", 0.001), content())
    assert standing("magellan_pro", 0.001).state is State.PASSED
    assert standing("magellan_pro", 0.0005).state is State.MISSING


def test_a_failed_certificate_names_what_failed():
    store(key_of("magellan_pro", 0.001), content(creep={"passed": False}))
    found = standing(SHIPPED, 0.001)
    assert found.state is State.FAILED
    assert found.json() == {"against": "closed forms", "state": "failed", "failed": ["creep"]}


@pytest.mark.parametrize(
    ("old", "new"), [('impratio="1e6"', 'impratio="2e6"'), ('kv="20"', 'kv="21"'), ("-83.167957", "-83.2")]
)
def test_another_model_needs_another_certificate(tmp_path, old, new):
    store(key_of(SHIPPED, 0.001), content())
    text = SHIPPED.read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "edited.xml"
    path.write_text(text, encoding="utf-8")
    assert standing(path, 0.001).state is State.PASSED
    path.write_text(text.replace(old, new), encoding="utf-8")
    assert standing(path, 0.001).state is State.MISSING


def test_contacts_are_told_apart_but_not_by_friction(tmp_path):
    def contacts(old, new):
        path = tmp_path / "edited.xml"
        path.write_text(SHIPPED.read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
        return key_of(path, 0.001).contacts

    same = key_of(SHIPPED, 0.001).contacts
    assert contacts('friction="0.8 0.8', 'friction="0.5 0.5') == same
    assert contacts('kv="20"', 'kv="21"') == same
    assert contacts("-83.167957", "-83.2") != same
    assert contacts('impratio="1e6"', 'impratio="1e5"') != same


def test_another_engine_and_other_questions_need_another_certificate(monkeypatch):
    store(key_of("magellan_pro", 0.001), content())
    certificate._key.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(certificate, "version", lambda name: "9.9.9")
        assert standing("magellan_pro", 0.001).state is State.MISSING
    certificate._key.cache_clear()
    with monkeypatch.context() as patch:
        patch.setattr(certificate, "FIXTURES", certificate.FIXTURES[:-1])
        assert standing("magellan_pro", 0.001).state is State.MISSING
    certificate._key.cache_clear()
    assert standing("magellan_pro", 0.001).state is State.PASSED


@pytest.mark.parametrize(
    "text", ["", "[]", '{"checks": 3}', '{"checks": [{"name": "mass"}]}', '{"checks": []}']
)
def test_a_broken_certificate_certifies_nothing(text):
    key = key_of("magellan_pro", 0.001)
    key.file.parent.mkdir(parents=True)
    key.file.write_text(text)
    assert standing("magellan_pro", 0.001).state is not State.PASSED


def test_the_cache_folder_is_the_platform_s(monkeypatch):
    monkeypatch.delenv("SLIPCTL_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/somewhere")
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    home = Path.home()
    for platform, folder in (
        ("linux", Path("/somewhere/slipctl")),
        ("darwin", home / "Library" / "Caches" / "slipctl"),
        ("win32", Path("/local/slipctl/Cache")),
    ):
        monkeypatch.setattr(certificate.sys, "platform", platform)
        assert cache_folder() == folder
    monkeypatch.setattr(certificate.sys, "platform", "linux")
    for relative in ("", "not/absolute"):
        monkeypatch.setenv("XDG_CACHE_HOME", relative)
        assert cache_folder() == home / ".cache" / "slipctl"


def test_storing_leaves_nothing_unfinished():
    key = key_of("magellan_pro", 0.001)
    store(key, content())
    store(key, content())
    assert [path.name for path in key.file.parent.iterdir()] == [key.file.name]
    with pytest.raises(ValueError, match="JSON"):
        store(key, content() | {"bad": float("nan")})
    assert read(key.file) == content()
    assert len(list(key.file.parent.iterdir())) == 1


def test_unreadable_files_are_refused(tmp_path):
    with pytest.raises(CertificateError, match="no certificate at"):
        read(tmp_path / "none.json")
    (tmp_path / "text.json").write_text("hello")
    with pytest.raises(CertificateError, match="not a certificate"):
        read(tmp_path / "text.json")


def test_nothing_changed_is_nothing_said():
    assert examine.changes(content(), content()) == []
    # rounding is no change
    assert examine.changes(content(), content(mass={"measured": 18.2 * (1 + 1e-12)})) == []


def test_what_moved_is_said_with_both_numbers():
    then, now = content(), content(creep={"measured": 0.012, "passed": False})
    now["versions"] = {"slipctl": "0.1.0", "mujoco": "4.1.0"}
    assert examine.changes(then, now) == [
        "mujoco 4.0.0 then, 4.1.0 now",
        "creep: 0.005 mm/s then, 0.012 mm/s now; passed then, failed now",
    ]


def test_checks_that_come_and_go_are_said():
    then, now = content(), content(mass={"measured": None, "passed": False})
    then["checks"][1] = then["checks"][1] | {"name": "old"}
    said = examine.changes(then, now)
    assert "mass: 18.2 kg then, not measured now; passed then, failed now" in said
    assert "creep: not asked then" in said
    assert "old: not asked now" in said


def test_an_examination_can_be_read_back_and_compared(monkeypatch):
    few = tuple(f for f in certificate.FIXTURES if f.name in ("mass", "rolling_radius"))
    monkeypatch.setattr(examine, "FIXTURES", few)
    told = []
    made = examine.certify("magellan_pro", progress=lambda *args: told.append(args))
    assert told == [(0, 2, "mass"), (1, 2, "rolling radius")]
    assert made["passed"] is True
    assert set(made["versions"]) == {"slipctl", "mujoco", "numpy"}
    kept = read(key_of("magellan_pro", 0.001).file)
    assert kept == json.loads(json.dumps(made))
    assert examine.changes(kept, made) == []
