"""`[robot] model = "path"`: where the file is looked for, which keys it brings, what identifies it."""

from __future__ import annotations

from pathlib import Path

import pytest

from slipctl.scenario import canonical, dump, is_path, load, read, scenario_id
from tests.scenario.documents import EIGHT, PAPER, changed, only, refused

ROBOT = "<mujoco><worldbody><body/></worldbody></mujoco>"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "robot.xml").write_text(ROBOT)
    return tmp_path


def own(folder: Path, **keys: object):
    given = {f"robot.{key}": value for key, value in keys.items()}
    return read(changed(PAPER, {"robot.model": "robot.xml", **given}), folder=folder)


def test_a_path_counts_from_the_folder_of_the_scenario(folder):
    assert own(folder).robot.model == str(folder / "robot.xml")
    assert read(dump(own(folder)), folder="/").robot.model == str(folder / "robot.xml")


def test_the_keys_of_a_robot_of_ones_own_arrive(folder):
    robot = own(folder, left_wheel="l", right_wheel="r", caster_friction=0.0).robot
    assert (robot.left_wheel, robot.right_wheel, robot.caster_friction) == ("l", "r", 0.0)
    assert own(folder, keep_contacts=True).robot.keep_contacts


@pytest.mark.parametrize(
    ("key", "value"),
    [("left_wheel", "l"), ("right_wheel", "r"), ("keep_contacts", True), ("caster_friction", 0.0)],
)
def test_a_shipped_model_is_told_none_of_them(key, value):
    problem = only(changed(PAPER, {f"robot.{key}": value}))
    assert problem.key == f"robot.{key}"
    assert "ignored" in problem.allowed


def test_kept_contacts_are_kept_for_the_casters_too(folder):
    given = {
        "robot.model": str(folder / "robot.xml"),
        "robot.keep_contacts": True,
        "robot.caster_friction": 0.1,
    }
    assert only(changed(PAPER, given)).key == "robot.caster_friction"


@pytest.mark.parametrize("key", ["film", "creep_stiffness"])
def test_a_film_needs_the_calibrated_contacts(folder, key):
    given = {"robot.model": str(folder / "robot.xml"), "robot.keep_contacts": True, "ground": {key: 100.0}}
    problem = only(changed(EIGHT, given))
    assert problem.key == f"ground.{key}"
    read(changed(EIGHT, given | {"robot.keep_contacts": False}))


def test_the_identity_is_that_of_the_file_s_content_wherever_it_lies(folder):
    before = scenario_id(own(folder))
    elsewhere = folder / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "robot.xml").write_text(ROBOT)
    assert scenario_id(own(elsewhere)) == before
    assert scenario_id(own(folder, left_wheel="l")) != before
    (folder / "robot.xml").write_text(ROBOT.replace("body/", "body name='b'/"))
    assert scenario_id(own(folder)) != before


def test_shipped_scenarios_say_nothing_of_it():
    scenario = load("friction-sweep")
    assert not is_path(scenario.robot.model)
    assert not {"left_wheel", "right_wheel", "keep_contacts", "caster_friction"} & set(
        dump(scenario)["robot"]
    )
    assert "wheel" not in canonical(scenario).replace("wheel_speed", "")


@pytest.mark.parametrize(
    ("table", "entry"),
    [
        ("patch", {"kind": "disc", "x": 0.0, "y": 0.0, "radius": 0.2, "friction": 0.3, "film": 5.0}),
        ("change", {"time": 0.5, "film": 5.0}),
    ],
)
def test_film_on_kept_contacts_is_refused_wherever_it_stands(tmp_path, table, entry):
    """It once ran silently where it came by a patch or a change."""
    robot = tmp_path / "robot.xml"
    robot.write_text("<mujoco/>", encoding="utf-8")
    document = {
        **changed(EIGHT, {"sweep": None, "ground": {table: [entry]}}),
        "robot": {"model": str(robot), "drive": "wheel_speed", "keep_contacts": True},
    }
    assert f"ground.{table}[0].film" in {problem.key for problem in refused(document)}
