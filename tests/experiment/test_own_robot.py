"""The paper's laws on robots beside the Magellan Pro."""

from __future__ import annotations

import pytest

from slipctl import scenario as files
from slipctl.experiment import run
from tests.plants.robots import mjcf, written


@pytest.fixture(scope="module")
def burger() -> dict[str, dict]:
    return {row["controller"]: row for row in run("burger").metrics.to_pylist()}


def test_the_burger_follows_the_path_of_table_one(burger):
    """0.12 and 0.04 mm RMS; the intervals leave room for another version of MuJoCo."""
    nominal, robust = burger["nominal_kinematic"], burger["robust_kinematic"]
    assert {nominal["status"], robust["status"]} == {"completed"}
    assert 0.05e-3 < nominal["rms_position_error"] < 0.2e-3
    assert robust["rms_position_error"] < 0.5 * nominal["rms_position_error"]
    assert robust["guarantee_fraction"] == 1.0
    assert max(nominal["median_slip_ratio"], robust["median_slip_ratio"]) < 1e-3


def test_the_burger_drives_slower_than_it_is_sold_for():
    scenario = files.load("burger")
    assert (scenario.robot.speed_limit, scenario.robot.yaw_rate_limit) == (0.22, 2.84)
    speed = run(scenario).signals.column("motion.forward_speed").to_numpy()
    assert 0.1 < speed.max() < 0.22


def test_a_robot_of_ones_own_follows_it_as_well(tmp_path):
    written(tmp_path, mjcf())
    raw = files.dump(files.load("burger"))
    raw["robot"] = {"model": "robot.xml", "drive": "wheel_speed", "torque_limit": 1.0}
    raw["controller"] = raw["controller"][:1]
    del raw["expect"]  # its claims are about both laws
    (row,) = run(files.read(raw, folder=tmp_path)).metrics.to_pylist()
    assert row["status"] == "completed"
    assert row["rms_position_error"] < 0.3e-3


def test_its_motors_take_torques_too(tmp_path):
    written(tmp_path, mjcf())
    raw = files.dump(files.load("torque-grip"))
    raw["robot"] = {"model": "robot.xml", "drive": "wheel_torque", "torque_limit": 1.0}
    raw["duration"] = 2.0
    result = run(files.read(raw, folder=tmp_path))
    for row in result.metrics.to_pylist():
        assert row["status"] == "completed"
        assert row["max_position_error"] < 0.02
