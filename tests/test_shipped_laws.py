"""What the shipped scenarios of the torque drive, of rest to rest and of wrong beliefs show."""

from __future__ import annotations

import pytest

from slipctl import scenario as files
from tests.test_shipped_scenarios import metric, result_of

RMS = "rms_position_error"


@pytest.mark.parametrize("controller", ["nominal_dynamic", "robust_dynamic"])
def test_torques_follow_within_a_millimetre_where_nothing_slips(controller):
    assert metric("torque-grip", controller, "max_position_error") < 1e-3


def test_wheels_taken_to_weigh_nothing_are_felt():
    """They are 12 % of the mass, so the law without a robust term is off by more than ten times as much."""
    known = metric("torque-grip", "nominal_dynamic", RMS)
    assert metric("torque-grip-bare", "nominal_dynamic", RMS) > 10 * known
    assert metric("torque-grip-bare", "robust_dynamic", RMS) < 1e-3


@pytest.mark.parametrize(("controller", "most"), [("nominal_dynamic", 0.06), ("robust_dynamic", 0.01)])
def test_a_climb_needs_the_measured_acceleration(controller, most):
    assert metric("slope-torque", controller, RMS) < most
    assert metric("slope-torque", controller, "final_position_error") < 1e-3
    # reckoned, the robot rolls back down
    assert metric("slope-torque-model", controller, RMS) > 1.0
    assert metric("slope-torque-model", controller, "min_forward_speed") < -0.3


def test_the_slope_scenarios_differ_in_what_is_measured_only():
    measured, reckoned = (files.dump(files.load(name)) for name in ("slope-torque", "slope-torque-model"))
    del measured["expect"]  # what is claimed of the runs is another matter
    assert {key for key in measured if measured[key] != reckoned[key]} == {"name", "description", "sensing"}


def test_from_rest_to_rest_in_the_path_s_own_time():
    assert metric("rest-to-rest", "robust_scaled", "max_position_error") < 8e-3
    assert metric("rest-to-rest", "robust_scaled", "guarantee_fraction") == 1.0
    for index, stops in enumerate([True, True, False]):
        signals = result_of("rest-to-rest").run_signals(index)
        final = signals["motion.forward_speed"][-1].as_py()
        assert final == pytest.approx(0.0 if stops else 0.05, abs=1e-12)
    # the floor saturates the command, winds up the error, and costs the guarantee
    assert metric("rest-to-rest", "robust_floor", RMS) > 10 * metric("rest-to-rest", "robust_scaled", RMS)
    assert metric("rest-to-rest", "robust_floor", "guarantee_fraction") < 0.9


BELIEFS = {
    # scenario: law's model, swept key, a belief 20 % off either way, RMS in mm that a nominal law exceeds
    "wrong-beliefs": ("kinematic", "wheel_radius", (0.066, 0.099), 10.0),
    "wrong-beliefs-track": ("kinematic", "half_track", (0.12992, 0.19488), 5.0),
    "wrong-beliefs-torque": ("dynamic", "mass", (14.56, 21.84), 1.0),
    "wrong-beliefs-inertia": ("dynamic", "yaw_inertia", (0.315, 0.4725), 3.0),
}


@pytest.mark.parametrize("name", BELIEFS)
def test_the_robust_term_takes_wrong_beliefs_for_slip(name):
    model, key, values, least = BELIEFS[name]
    for value in values:
        nominal = metric(name, f"nominal_{model}", RMS, **{key: value})
        assert nominal > least * 1e-3
        assert metric(name, f"robust_{model}", RMS, **{key: value}) < nominal / 10


@pytest.mark.parametrize("name", BELIEFS)
def test_errors_grow_with_the_error_of_the_belief(name):
    model, key, _, _ = BELIEFS[name]
    (axis,) = files.load(name).sweep
    values = list(axis)
    truth = values[3]
    for law in (f"nominal_{model}", f"robust_{model}"):
        errors = [metric(name, law, RMS, **{key: value}) for value in values]
        assert errors[:4] == sorted(errors[:4], reverse=True)
        assert errors[3:] == sorted(errors[3:])
        assert metric(name, law, RMS, **{key: truth}) < 0.2e-3
