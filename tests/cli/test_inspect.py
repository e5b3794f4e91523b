"""``slipctl inspect``, and runs of robots that slipctl did not write."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from slipctl.cli import main
from tests.plants.robots import BRAKING_CASTER, mjcf, urdf, written

SCENARIO = """
tick = 0.01
duration = 0.5
[robot]
model = "ROBOT"
drive = "wheel_speed"
torque_limit = 2.0
[plant]
kind = "mujoco"
[reference]
kind = "circle"
speed = 0.2
radius = 0.5
[[controller]]
kind = "nominal_kinematic"
pole = -1.0
"""


def test_a_usable_robot_ends_well(tmp_path, capsys):
    path = str(written(tmp_path, mjcf()))
    assert main(["inspect", path]) == 0
    table = capsys.readouterr().out
    assert "wheel radius  " in table
    assert table.splitlines()[-1] == "usable"
    assert main(["inspect", path, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["usable"] is True


def test_an_unusable_robot_ends_with_1_and_the_reason(tmp_path, capsys):
    path = str(written(tmp_path, mjcf(caster="")))
    assert main(["inspect", path, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["usable"] is False
    assert main(["inspect", path]) == 1
    assert "does not stand still" in capsys.readouterr().out


@pytest.mark.parametrize("model", ["no-such.xml", "no_such_robot"])
def test_an_unreadable_robot_ends_with_2(tmp_path, model, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["inspect", model, "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert model in err
    assert "Traceback" not in err


def test_wheels_may_be_named(tmp_path, capsys):
    text = mjcf(actuators="").replace("wheel_left", "a").replace("wheel_right", "b")
    path = str(written(tmp_path, text))
    assert main(["inspect", path]) == 1
    assert main(["inspect", path, "--left-wheel", "a", "--right-wheel", "b"]) == 0
    assert "positive drives ahead" in capsys.readouterr().out


def scenario(folder: Path, robot: str, keys: str = "") -> str:
    path = folder / "mine.toml"
    path.write_text(SCENARIO.replace('"ROBOT"', f'"{robot}"\n{keys}'), encoding="utf-8")
    return str(path)


def run(folder: Path, file: str) -> int:
    return main(["run", file, "--out", str(folder / "runs"), "--record", "none", "--json"])


def test_a_robot_of_ones_own_runs_and_what_was_done_to_it_is_said(tmp_path, capsys):
    written(tmp_path, urdf(), "robot.urdf")
    assert run(tmp_path, scenario(tmp_path, "robot.urdf", "caster_friction = 0.0")) == 0
    out, err = capsys.readouterr()
    (entry,) = json.loads(out)["runs"]
    assert entry["status"] == "completed"
    assert entry["metrics"]["max_position_error"] < 1e-3
    assert "welded to the world" in err
    manifest = json.loads((tmp_path / "runs" / "mine" / "manifest.json").read_text())
    assert any("welded to the world" in note for note in manifest["robot_notes"])


@pytest.mark.parametrize(
    ("caster", "reason"),
    [
        ("", "does not stand still"),
        (BRAKING_CASTER.replace('friction="0"', 'friction="30"'), "'ball' brakes"),
    ],
)
def test_what_cannot_be_used_is_not_run(tmp_path, caster, reason, capsys):
    written(tmp_path, mjcf(caster=caster))
    assert run(tmp_path, scenario(tmp_path, "robot.xml")) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert reason in err
    assert "Traceback" not in err
    assert not list((tmp_path / "runs").glob("*"))
