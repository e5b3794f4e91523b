"""``slipctl scenario``."""

import json

from slipctl import shipped
from slipctl.cli import main
from slipctl.scenario import load, scenario_id


def test_list_names_every_shipped_scenario(capsys):
    assert main(["scenario", "list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == list(shipped.scenario_names())
    assert all(len(line.split()) > 1 for line in lines)


def test_list_as_json(capsys):
    assert main(["scenario", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["scenarios"]
    assert [entry["name"] for entry in listed] == list(shipped.scenario_names())


def test_a_new_scenario_means_what_it_was_made_from(tmp_path, capsys):
    assert main(["scenario", "new", str(tmp_path / "mine"), "--like", "wet-slope"]) == 0
    assert "mine.toml" in capsys.readouterr().out
    assert scenario_id(load(tmp_path / "mine.toml")) == scenario_id(load("wet-slope"))


def test_a_new_scenario_never_overwrites(tmp_path, capsys):
    file = tmp_path / "mine.toml"
    file.write_text("mine")
    assert main(["scenario", "new", str(file)]) == 2
    assert file.read_text() == "mine"
    assert "exists" in capsys.readouterr().err


def test_a_new_scenario_where_nothing_can_be_written_is_exit_2(tmp_path, capsys):
    assert main(["scenario", "new", str(tmp_path / "absent" / "mine.toml")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_a_new_scenario_like_none_that_is_shipped_is_exit_2(tmp_path, capsys):
    assert main(["scenario", "new", str(tmp_path / "mine.toml"), "--like", "wet-slop"]) == 2
    assert "wet-slope" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_schema_is_json(capsys):
    assert main(["scenario", "schema"]) == 0
    assert "controller" in json.loads(capsys.readouterr().out)["properties"]
