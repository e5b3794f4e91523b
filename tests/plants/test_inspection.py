from __future__ import annotations

import json

import pytest

from slipctl.plants.errors import ModelError
from slipctl.plants.inspection import LEAST_YAW, inspect
from slipctl.plants.own import OwnModel
from tests.plants.robots import BRAKING_CASTER, FREE_CASTER, MASS, RADIUS, SWIVEL_CASTER, mjcf, urdf, written


def test_a_good_robot_is_told_to_be_one(tmp_path):
    seen = inspect(written(tmp_path, mjcf()))
    assert seen.usable
    assert seen.warnings == ()
    assert seen.wheel_radius == pytest.approx(RADIUS, rel=1e-4)
    assert seen.half_track == pytest.approx(0.12)
    assert (seen.mass, seen.mass_in_file) == (pytest.approx(MASS), pytest.approx(MASS))
    assert seen.weight_share == pytest.approx(1.0 - 0.135 / MASS / 0.15, rel=5e-3)
    assert seen.yaw_realised == pytest.approx(1.0, abs=2e-3)
    assert seen.servo_droop is not None
    assert abs(seen.servo_droop) < 0.005
    assert seen.saturation == 0.0
    assert [(w.joint, w.sign, w.contacts) for w in seen.wheels] == [
        ("wheel_left", 1, 2),
        ("wheel_right", 1, 2),
    ]
    (caster,) = seen.casters
    assert (caster.geom, caster.condim, caster.friction, caster.brakes) == ("ball", 1, 0.0, False)


def test_a_caster_without_a_priority_brakes_and_is_named(tmp_path):
    """Friction 0 and condim 1 of a geom lose against the floor's defaults, which are 1 and 3."""
    path = written(tmp_path, mjcf(caster=BRAKING_CASTER))
    seen = inspect(path)
    (caster,) = seen.casters
    assert (caster.condim, caster.friction, caster.brakes) == (3, 1.0, True)
    assert any("'ball' brakes" in warning for warning in seen.warnings)
    free = inspect(OwnModel(path, caster_friction=0.0))
    assert free.warnings == ()
    assert free.casters[0].brakes is False


def test_a_robot_that_its_caster_holds_is_not_usable(tmp_path):
    dragged = BRAKING_CASTER.replace('friction="0"', 'friction="30"')
    seen = inspect(written(tmp_path, mjcf(caster=dragged)))
    assert not seen.usable
    assert seen.yaw_realised is not None
    assert seen.yaw_realised < LEAST_YAW
    assert any("something beside the wheels holds it" in warning for warning in seen.warnings)


def test_a_caster_that_swivels_is_not_said_to_brake(tmp_path):
    seen = inspect(written(tmp_path, mjcf(caster=SWIVEL_CASTER)))
    (caster,) = seen.casters
    assert (caster.moves, caster.brakes) == (True, False)


def test_wheels_that_carry_little_are_told(tmp_path):
    ahead = FREE_CASTER.replace("-0.15 0", "-0.04 0")
    seen = inspect(written(tmp_path, mjcf(caster=ahead)))
    assert seen.weight_share is not None
    assert seen.weight_share < 0.5
    assert any("carry only" in warning for warning in seen.warnings)


def test_a_welded_urdf_is_named_as_one(tmp_path):
    seen = inspect(OwnModel(written(tmp_path, urdf(), "robot.urdf"), caster_friction=0.0))
    assert seen.usable
    assert seen.free_joint == "added"
    assert any("welded to the world" in note for note in seen.notes)


def test_a_robot_that_cannot_be_used_is_told_and_not_raised(tmp_path):
    seen = inspect(written(tmp_path, mjcf(caster="")))
    assert not seen.usable
    assert seen.yaw_realised is None
    (reason,) = seen.warnings
    assert reason.startswith("the robot does not stand still")


def test_what_cannot_be_read_is_raised(tmp_path):
    with pytest.raises(ModelError, match=r"robot\.xml"):
        inspect(written(tmp_path, "<mujoco>"))


@pytest.mark.parametrize(("name", "mass"), [("magellan_pro", 18.2), ("turtlebot3_burger", 1.0)])
def test_shipped_robots_are_good_ones(name, mass):
    seen = inspect(name)
    assert seen.usable
    assert seen.warnings == ()
    assert seen.written_for_slipctl
    assert seen.mass == pytest.approx(mass, rel=1e-6)
    assert seen.yaw_realised == pytest.approx(1.0, abs=1e-3)


def test_the_burger_has_its_published_lengths():
    seen = inspect("turtlebot3_burger")
    assert (seen.wheel_radius, seen.half_track) == (pytest.approx(0.033, abs=1e-8), pytest.approx(0.08))
    assert seen.weight_share == pytest.approx(1.0 - 0.016 / 0.081, abs=1e-4)


def test_it_can_be_written_as_json(tmp_path):
    seen = json.loads(json.dumps(inspect(written(tmp_path, mjcf())).json(), allow_nan=False))
    contract = "wheel_radius half_track mass yaw_inertia weight_share yaw_realised warnings usable"
    assert set(contract.split()) <= set(seen)
    assert seen["casters"][0]["geom"] == "ball"
