"""Lyapunov function, chatter threshold and bounds on recordings made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.guarantee import verdict, with_guarantee
from slipctl.recording import Columns
from slipctl.theory import ultimate
from tests.guarantee.recordings import ALPHA, LAYER, ROWS, SPEED, TICK, changed, hypotheses, sound

CORNERS = {2: 2.5, 3: 6.875}


def displaced(position: float, velocity: float, rows: int = ROWS, order: int = 2) -> Columns:
    """Return a recording with errors along y, and a law that sees them."""
    columns = sound(rows, order)
    weights = hypotheses(order=order).weights[0, -1]
    columns["motion.position.y"] = columns["motion.position.y"] + position
    columns["motion.velocity.y"] = columns["motion.velocity.y"] + velocity
    columns["decision.weighted_error.y"] = np.full((1, rows), weights[0] * position + weights[1] * velocity)
    columns["error.position"] = np.full((1, rows), abs(position))
    return columns


@pytest.mark.parametrize("order", [2, 3])
def test_v_and_w_are_those_of_the_true_error(order):
    wanted = hypotheses(order=order)
    columns = with_guarantee(displaced(0.03, -0.02, order=order), wanted, TICK)
    error = np.array([0.03, -0.02, 0.0])[:order]
    weights = wanted.weights[0]
    assert columns["guarantee.lyapunov"] == pytest.approx(np.full((1, ROWS), error @ weights @ error))
    assert columns["guarantee.weighted_error"] == pytest.approx(np.full((1, ROWS), abs(weights[-1] @ error)))
    assert columns["guarantee.feedback_exact"].all()


def test_v_must_fall_outside_the_layer_and_only_there():
    wanted = hypotheses()
    outside = displaced(0.015, 0.0)  # ‖w‖ = 0.03, one layer and a half
    columns = with_guarantee(outside, wanted, TICK)
    assert not columns["guarantee.lyapunov_falls"][0, :-1].any()  # V stands still
    assert verdict(columns, wanted, 0, ROWS - 1, TICK)["lyapunov_fraction"] == 0.0
    outside["motion.position.y"] = 0.015 * np.exp(-0.5 * np.arange(ROWS) * TICK)[None, :]
    columns = with_guarantee(outside, wanted, TICK)
    assert columns["guarantee.lyapunov_falls"][0, :-1].all()
    grown = changed(outside, "motion.position.y", 20, 0.016)
    columns = with_guarantee(grown, wanted, TICK)
    assert np.flatnonzero(~columns["guarantee.lyapunov_falls"][0, :-1]).tolist() == [19]
    assert verdict(columns, wanted, 0, ROWS - 1, TICK)["lyapunov_fraction"] == pytest.approx(
        1 - 1 / (ROWS - 1)
    )
    inside = displaced(0.005, 0.0)
    inside["motion.position.y"] = 0.005 * np.exp(np.arange(ROWS) * TICK)[None, :]
    columns = with_guarantee(inside, wanted, TICK)
    assert columns["guarantee.lyapunov_falls"].all()
    assert verdict(columns, wanted, 0, ROWS - 1, TICK)["lyapunov_fraction"] is None


def test_v_need_not_fall_where_the_time_of_the_path_does_not_pass():
    """An error that grows outside the layer counts against V only while rates per path time can be told."""
    columns = sound(rows=6)
    columns["motion.position.x"] = columns["reference.position.x"] + np.linspace(0.1, 0.6, 6)
    assert not with_guarantee(columns, hypotheses(), TICK)["guarantee.lyapunov_falls"].any()
    columns["reference.path_rate"] = np.array([[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]])
    columns["reference.path_time"] = np.array([[0.0, 1.0, 2.0, 2.5, 2.5, 2.5]]) * TICK
    columns["decision.path_speed"] = np.full((1, 6), SPEED)
    for axis in "xy":
        columns[f"decision.path_velocity.{axis}"] = columns[f"motion.velocity.{axis}"]
        columns[f"reference.path_velocity.{axis}"] = columns[f"reference.velocity.{axis}"]
        columns[f"reference.path_acceleration.{axis}"] = np.zeros((1, 6))
    falls = with_guarantee(columns, hypotheses(), TICK)["guarantee.lyapunov_falls"]
    assert falls.tolist() == [[False, False, True, True, True, False]]


@pytest.mark.parametrize("order", [2, 3])
def test_chatter_threshold_knows_the_corner_of_p_and_the_slip(order):
    wanted = hypotheses(order=order)
    columns = with_guarantee(sound(order=order), wanted, TICK)
    gain = 1.0 + ALPHA + 1j * ALPHA
    expected = 2.0 * gain.real / abs(gain) ** 2 * LAYER / (CORNERS[order] * 0.1)
    assert columns["guarantee.calm_tick"] == pytest.approx(np.full((1, ROWS), expected))
    assert columns["guarantee.calm"][0, :-1].all()
    long = with_guarantee(sound(order=order), wanted, 1.01 * expected)
    assert not long["guarantee.calm"][0, :-1].any()
    told = verdict(long, wanted, 0, ROWS - 1, 1.01 * expected)
    assert told["calm_fraction"] == 0.0
    assert told["calm_tick"] == pytest.approx(expected)
    # slip that turns the input around leaves no tick
    backwards = changed(sound(order=order), "slip.longitudinal", 5, -1.2 * 0.5)
    assert with_guarantee(backwards, wanted, TICK)["guarantee.calm_tick"][0, 5] == 0.0
    # nor does rest, with slip or without
    still = changed(sound(order=order), "motion.forward_speed", slice(5, 7), 0.0)
    for name in ("slip.longitudinal", "slip.lateral"):
        still = changed(still, name, 6, 0.0)
    assert with_guarantee(still, wanted, TICK)["guarantee.calm_tick"][0, 5:7].tolist() == [0.0, 0.0]


def test_rates_of_the_slip_are_told_apart_from_the_hypotheses():
    columns = sound()
    columns["motion.forward_speed"] = 0.5 + 0.01 * np.arange(ROWS)[None, :]
    for name, sign in (("longitudinal", 1), ("lateral", -1), ("yaw", 1)):
        columns[f"slip.{name}"] = sign * ALPHA * columns["motion.forward_speed"]
    told = with_guarantee(columns, hypotheses(), TICK)
    assert told["guarantee.slip_rates_bounded"][0, :-1].all()
    jump = with_guarantee(changed(columns, "slip.lateral", 7, 0.0), hypotheses(), TICK)
    assert np.flatnonzero(~jump["guarantee.slip_rates_bounded"][0, :-1]).tolist() == [6, 7]
    assert jump["guarantee.held"].all()
    assert "guarantee.slip_rates_bounded" not in with_guarantee(columns, hypotheses("slip_ratio"), TICK)


LONG = 2001  # 20 s


def bounds_of(columns: Columns) -> dict[str, float | str | None]:
    wanted = hypotheses()
    return verdict(with_guarantee(columns, wanted, TICK), wanted, 0, len(columns["slip.yaw"][0]) - 1, TICK)


def test_bounds_are_the_closed_forms_with_the_largest_gain_after_the_transient():
    columns = changed(sound(LONG), "decision.robust_gain", slice(0, 500), 50.0)  # until 5 s
    told = bounds_of(changed(columns, "decision.robust_gain", 900, 0.7))
    weights = hypotheses().weights[0]
    assert told["settling_time"] == pytest.approx(5.0)
    assert told["lyapunov_level"] == ultimate.tight_level_set(weights, LAYER, 0.7)
    for name, level in (
        ("level_set", ultimate.level_set(weights, LAYER, 0.7)),
        ("tight_level_set", ultimate.tight_level_set(weights, LAYER, 0.7)),
    ):
        assert told[f"error_bound_{name}"] == ultimate.position_bound(weights, level)
    assert told["error_bound"] == told["error_bound_small_gain"] == pytest.approx(LAYER / 2.0)
    assert (told["settled_error"], told["error_bound_share"]) == (0.0, 0.0)


def test_the_transient_lasts_until_v_is_within_its_level():
    columns = displaced(0.05, 0.0, LONG)
    course = np.where(np.arange(LONG) < 700, 0.05, 0.001)[None, :]  # until 7 s
    columns["motion.position.y"], columns["error.position"] = course, np.abs(course)
    columns["decision.weighted_error.y"] = 2.0 * course
    told = bounds_of(columns)
    assert told["settling_time"] == pytest.approx(7.5)  # the sixth time constant of 1.25 s
    assert told["settled_error"] == 0.001
    assert bounds_of(displaced(0.05, 0.0, LONG))["settling_time"] is None
    assert bounds_of(displaced(0.05, 0.0, LONG))["settled_error"] is None


def test_nothing_is_promised_after_a_late_violation_and_after_a_short_run():
    early = bounds_of(changed(sound(LONG), "decision.robust_gain", 100, -1.0))
    assert early["error_bound"] is not None
    assert early["settled_guarantee_fraction"] == 1.0
    late = bounds_of(changed(sound(LONG), "slip.yaw", 1000, 1.0))
    assert late["error_bound"] is None
    assert late["error_bound_share"] is None
    assert late["error_bound_small_gain"] == pytest.approx(LAYER / 2.0)
    assert late["settled_guarantee_fraction"] == pytest.approx(1.0 - 1.0 / 1500)
    assert bounds_of(sound(ROWS))["settling_time"] is None
