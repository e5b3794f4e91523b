"""The theorems' hypotheses on recordings made by hand, one violated at a time."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.guarantee import HYPOTHESES, verdict, with_guarantee
from slipctl.recording import Columns
from tests.guarantee.recordings import (
    ALPHA,
    FLOOR,
    LAYER,
    ROWS,
    SPEED,
    TICK,
    changed,
    hypotheses,
    sound,
)

BOUNDS = [("paper", 2), ("independent", 2), ("slip_ratio", 2), ("paper", 3), ("proportional", 3)]


def held(columns: Columns, uncertainty: str = "independent", order: int = 2, **fields) -> np.ndarray:
    wanted = hypotheses(uncertainty, order, **fields)
    return with_guarantee(columns, wanted, TICK)["guarantee.held"][0, :-1]


@pytest.mark.parametrize(("uncertainty", "order"), BOUNDS)
def test_slip_at_its_bound_holds_as_in_the_papers_own_simulation(uncertainty, order):
    assert held(sound(order=order), uncertainty, order).all()


@pytest.mark.parametrize(("order", "rate"), [(2, "velocity"), (3, "acceleration")])
def test_uncertainty_is_what_the_flat_input_does_not_explain(order, rate):
    columns = sound(order=order)
    assert np.abs(with_guarantee(columns, None, TICK)["guarantee.uncertainty"]).max() < 1e-12
    columns[f"motion.{rate}.x"] = columns[f"motion.{rate}.x"] * 2.0
    columns[f"motion.{rate}.y"] = columns[f"motion.{rate}.y"] + 0.3 * np.arange(ROWS) * TICK
    uncertainty = with_guarantee(columns, None, TICK)["guarantee.uncertainty"][0, :-1]
    assert uncertainty == pytest.approx(np.hypot(0.2, 0.3), rel=1e-9)


def slowed(columns: Columns) -> Columns:
    """Return slip in proportion to a speed below the floor, so that only the speed is at fault."""
    for name in ("slip.longitudinal", "slip.lateral", "slip.yaw"):
        columns = changed(columns, name, 7, 0.0)
    return changed(columns, "motion.forward_speed", 7, 0.8 * FLOOR)


PLANTED = {
    "longitudinal slip": (
        "slip_bounded",
        0.1,
        lambda c: changed(c, "slip.longitudinal", 7, 1.1 * ALPHA * SPEED),
    ),
    "lateral slip": ("slip_bounded", 0.1, lambda c: changed(c, "slip.lateral", 7, -1.1 * ALPHA * SPEED)),
    "yaw slip": ("yaw_slip_bounded", 0.25, lambda c: changed(c, "slip.yaw", 7, -1.25 * ALPHA * SPEED)),
    "low speed": ("speed_above_floor", 0.2, slowed),
    "small gain": ("uncertainty_covered", None, lambda c: changed(c, "decision.robust_gain", 7, -1.0)),
    "wrong feedback": (
        "feedback_exact",
        0.5,
        lambda c: changed(c, "decision.weighted_error.y", 7, 0.5 * LAYER),
    ),
}


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("planted", PLANTED)
def test_each_violation_shows_in_its_own_tick_under_its_own_name(planted, order):
    name, excess, plant = PLANTED[planted]
    wanted = hypotheses(order=order)
    columns = with_guarantee(plant(sound(order=order)), wanted, TICK)
    expected = np.arange(ROWS - 1) != 7
    for other in HYPOTHESES:
        assert (columns[f"guarantee.{other}"][0, :-1] == (expected if other == name else True)).all(), other
    assert (columns["guarantee.held"][0, :-1] == expected).all()
    told = verdict(columns, wanted, 0, ROWS - 1, TICK)
    assert told["first_violation"] == name
    assert told["first_violation_time"] == pytest.approx(0.07)
    if excess is not None:
        assert told["first_violation_excess"] == pytest.approx(excess, rel=1e-6)


@pytest.mark.parametrize(("order", "rate"), [(2, "velocity"), (3, "acceleration")])
def test_an_uncertainty_above_rho_is_a_violation(order, rate):
    columns = sound(order=order)
    columns[f"motion.{rate}.x"][0, 20:] += 0.11 * TICK  # one tick with η = 0.11 > ρ = 0.1
    columns[f"reference.{rate}.x"][0, 20:] += 0.11 * TICK  # and planned, so that there is no error
    wanted = hypotheses(order=order)
    columns = with_guarantee(columns, wanted, TICK)
    assert not columns["guarantee.held"][0, 19]
    assert columns["guarantee.held"].sum() == ROWS - 1  # of 50 rows, the last with η = 0
    told = verdict(columns, wanted, 0, ROWS - 1, TICK)
    assert told["first_violation"] == "uncertainty_covered"
    assert told["first_violation_time"] == pytest.approx(0.19)
    assert told["first_violation_excess"] == pytest.approx(0.1, rel=1e-6)


def test_the_cause_is_named_where_several_hypotheses_fail_at_once():
    columns = changed(sound(), "decision.robust_gain", 7, 0.0)
    columns = changed(columns, "slip.lateral", 7, 2.0 * ALPHA * SPEED)
    columns = changed(columns, "motion.velocity.y", slice(8, None), 0.5)
    wanted = hypotheses()
    told = verdict(with_guarantee(columns, wanted, TICK), wanted, 0, ROWS - 1, TICK)
    assert (told["first_violation"], told["first_violation_excess"]) == ("slip_bounded", pytest.approx(1.0))


def test_the_papers_bound_is_on_the_sum_the_slip_ratios_on_the_length():
    columns = changed(sound(), "slip.longitudinal", slice(None), 1.9 * ALPHA * SPEED)
    columns = changed(columns, "slip.lateral", slice(None), 0.1 * ALPHA * SPEED)
    assert held(columns, "paper").all()
    assert not held(changed(columns, "slip.lateral", slice(None), 0.101 * ALPHA * SPEED), "paper").any()
    assert not held(columns, "independent").any()
    assert not held(columns, "slip_ratio").any()
    columns = changed(columns, "slip.longitudinal", slice(None), 1.4 * ALPHA * SPEED)
    assert held(columns, "slip_ratio").all()
    # Assumption 4.5 is on v_t alone
    assert not held(
        changed(sound(order=3), "slip.longitudinal", slice(None), 1.1 * ALPHA * SPEED), "paper", 3
    ).any()


def test_numbers_of_assumption_4_6_stand_for_the_share_of_the_speed():
    limits = {"yaw_slip_bound": np.array([0.9]), "lateral_slip_bound": np.array([0.02])}
    columns = changed(
        changed(sound(order=3), "slip.lateral", slice(None), 0.02), "slip.yaw", slice(None), -0.9
    )
    assert held(columns, "general", 3, **limits).all()
    assert not held(changed(columns, "slip.lateral", slice(None), 0.021), "general", 3, **limits).any()
    assert not held(changed(columns, "slip.yaw", slice(None), 0.91), "general", 3, **limits).any()
    assert not held(columns, "proportional", 3).any()


def test_without_a_theorem_there_is_nothing_to_hold():
    columns = with_guarantee(sound(), None, TICK)
    assert [name for name in columns if name.startswith("guarantee.")] == ["guarantee.uncertainty"]
    assert set(verdict(columns, None, 0, ROWS - 1, TICK).values()) == {None}
