"""Finding files, and files that are none."""

import re
import tomllib
from pathlib import Path

import pytest

from slipctl import shipped
from slipctl.scenario import ScenarioError, dump, load, read, worlds
from tests.scenario.documents import PAPER

SHARED = Path(__file__).resolve().parents[3] / "shared" / "scenarios"


def message(source):
    with pytest.raises(ScenarioError) as caught:
        load(source)
    return str(caught.value)


@pytest.mark.parametrize("name", shipped.scenario_names())
def test_every_shipped_scenario_loads_under_its_own_name(name):
    scenario = load(name)
    assert scenario.name == name
    assert scenario.description
    assert worlds(scenario)
    assert load(shipped.scenario_path(name)) == load(str(shipped.scenario_path(name))) == scenario


@pytest.mark.parametrize("name", shipped.scenario_names())
def test_shipped_copies_are_the_contract_s_own(name):
    original = SHARED / f"{name}.toml"
    if not original.exists():
        pytest.skip("ours alone, or the originals are not here")
    ours, theirs = shipped.scenario_path(name).read_bytes(), original.read_bytes()
    assert ours.startswith(theirs)
    # what is added says only what the runs show
    assert set(tomllib.loads(ours.decode())) - set(tomllib.loads(theirs.decode())) <= {"expect"}


def test_a_shipped_name_needs_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("friction-sweep").mkdir()
    assert len(worlds(load("friction-sweep"))) == 14


def test_a_file_without_a_name_is_called_by_its_own(tmp_path):
    text = shipped.scenario_path("belt").read_text().replace('name = "belt"', "")
    path = tmp_path / "my-belt.toml"
    path.write_text(text)
    assert load(path).name == "my-belt"


def test_windows_line_ends_and_a_byte_order_mark_are_read(tmp_path):
    path = tmp_path / "belt.toml"
    path.write_bytes(b"\xef\xbb\xbf" + shipped.scenario_path("belt").read_bytes().replace(b"\n", b"\r\n"))
    assert load(path) == load("belt")


def test_a_missing_name_lists_the_shipped_ones_and_the_nearest():
    text = message("friction-sweeep")
    assert 'did you mean "friction-sweep"?' in text
    assert all(name in text for name in shipped.scenario_names())


@pytest.mark.parametrize("source", ["nowhere/wet-slop.toml", Path("wet-slop.toml"), Path("wet-slope")])
def test_a_missing_file(source):
    text = message(source)
    assert text.startswith(f"{source}: there is no such file")
    assert 'did you mean "wet-slope"?' in text


@pytest.mark.parametrize("source", ["x" * 5000 + ".toml", "a\0b", "a\0b.toml"])
def test_a_path_that_cannot_be(source):
    assert "there is" in message(source) or "cannot be read" in message(source)


def test_a_folder(tmp_path):
    assert "this is a folder" in message(tmp_path)
    assert "this is a folder" in message("")


def test_no_toml_tells_line_and_column(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text("tick = 0.01\nseed : 3\n")
    assert re.search(r"bad.toml: this is not a TOML file: .*line 2, column", message(path))


@pytest.mark.parametrize("content", ["[" * 100_000, "x = " + "9" * 5000, "x = " + "[" * 50_000])
def test_toml_that_breaks_the_reader(tmp_path, content):
    path = tmp_path / "bad.toml"
    path.write_text(content)
    assert "this is not a TOML file" in message(path)


def test_bytes_that_are_no_text(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_bytes(b'tick = 0.01\nname = "caf\xe9"\n')
    assert "this is not UTF-8 text (byte 23, line 2)" in message(path)


def test_an_empty_file_lists_everything_it_lacks(tmp_path):
    path = tmp_path / "empty.toml"
    path.write_text("")
    with pytest.raises(ScenarioError) as caught:
        load(path)
    assert {problem.key for problem in caught.value.problems} == {
        "tick",
        "robot",
        "plant",
        "reference",
        "controller",
    }
    assert str(caught.value).count(f"{path}: ") == 5


def test_toml_dates_are_no_numbers():
    tables = tomllib.loads("tick = 2020-01-01")
    with pytest.raises(ScenarioError, match="tick: found 2020-01-01; allowed: a number > 0"):
        read({**PAPER, **tables})


def test_errors_can_be_pickled():
    import pickle

    with pytest.raises(ScenarioError) as caught:
        read({**PAPER, "tick": -1.0})
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


def test_reading_changes_nothing():
    before = repr(PAPER)
    read({**PAPER, "sweep": {"slip.yaw": [0.1, 0.2]}})
    assert repr(PAPER) == before


def test_a_scenario_is_frozen():
    scenario = read(PAPER)
    with pytest.raises(ValueError, match="frozen"):
        scenario.tick = 1.0
    with pytest.raises(ValueError, match="frozen"):
        scenario.robot.speed_limit = 1.0
    assert hash(scenario) == hash(read(dump(scenario)))
