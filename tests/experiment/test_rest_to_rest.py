"""The shipped scenario from rest to rest: time scaling against the paper's floor."""

import tomllib

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl import shipped
from slipctl.experiment import run
from slipctl.experiment.result import Result


def rest_to_rest(plant="kinematic_ode", slip=0.4) -> Result:
    raw = tomllib.loads(shipped.scenario_path("rest-to-rest").read_text(encoding="utf-8"))
    raw["plant"]["kind"] = plant
    raw["slip"] |= {"longitudinal": slip, "lateral": slip, "yaw": slip}
    return run(files.read(raw))


def last(result: Result, index: int, name: str) -> float:
    signals = result.signals.to_pydict()
    return np.array(signals[name])[np.array(signals["run"]) == index][-1]


@pytest.mark.parametrize("plant", ["kinematic_ode", "mujoco"])
def test_time_scaling_stops_at_the_goal_where_the_floor_does_not(plant):
    result = rest_to_rest(plant)
    nominal, robust, floor = result.metrics.to_pylist()
    for run_of in (nominal, robust):
        assert run_of["saturation_fraction"] == 0.0
    assert 1e3 * nominal["max_position_error"] == pytest.approx(26.8, rel=0.02)
    assert 1e3 * robust["max_position_error"] == pytest.approx(5.2, rel=0.02)
    assert robust["max_position_error"] < 8e-3
    assert floor["max_position_error"] > 80e-3
    assert abs(last(result, 1, "motion.forward_speed")) < (1e-15 if plant == "kinematic_ode" else 1e-6)
    assert last(result, 2, "motion.forward_speed") == pytest.approx(0.05, rel=1e-2)
    assert last(result, 1, "decision.path_speed") > 0.06 * 0.1 / 0.15
    # a robot at rest has a direction to compare with: that of its path
    for run_of in (nominal, robust, floor):
        assert run_of["rms_cross_track_error"] is not None
        assert run_of["rms_heading_error"] is not None


def test_the_theorem_holds_all_the_way_in_the_path_s_own_time():
    """At rest v is 0, but ṽ is not; the floor's run starts below its floor."""
    _, robust, floor = rest_to_rest().metrics.to_pylist()
    assert robust["guarantee_fraction"] == 1.0
    assert robust["first_violation"] is None
    assert floor["first_violation"] == "speed_above_floor"
    assert floor["guarantee_fraction"] < 0.7


def test_more_slip_than_the_law_expects_is_told_in_path_time_too():
    """Half as much slip again: the slip hypothesis fails as soon as rates per path time can be told."""
    robust = rest_to_rest(slip=0.6).metrics.to_pylist()[1]
    assert robust["first_violation"] == "slip_bounded"
    assert 0.4 < robust["first_violation_time"] < 0.7
    assert robust["first_violation_excess"] == pytest.approx(0.5, rel=1e-6)
    assert robust["guarantee_fraction"] < 0.1


def test_without_slip_the_floor_alone_misses_the_goal():
    _, robust, floor = rest_to_rest(slip=0.0).metrics.to_pylist()
    assert robust["max_position_error"] < 1e-3
    assert 1e3 * floor["rms_position_error"] == pytest.approx(64.2, rel=0.02)
    assert 1e3 * floor["final_position_error"] == pytest.approx(74.3, rel=0.02)
