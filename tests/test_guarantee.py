"""The theorem's hypotheses on recordings made by hand, one violated at a time."""

from __future__ import annotations

import numpy as np
import pytest

from slipctl.guarantee import Hypotheses, with_guarantee
from slipctl.recording import Columns

ROWS, TICK, ALPHA, SPEED = 50, 0.01, 0.3, 0.5


def sound() -> Columns:
    """Return a robot that accelerates exactly as its flat input says, with slip at its bound."""
    acceleration = 0.2
    time = np.arange(ROWS) * TICK
    row = np.ones((1, ROWS))
    return {
        "motion.velocity.x": acceleration * time[None, :],
        "motion.velocity.y": 0.0 * row,
        "motion.forward_speed": SPEED * row,
        "slip.longitudinal": ALPHA * SPEED * row,
        "slip.lateral": -ALPHA * SPEED * row,
        "slip.yaw": ALPHA * SPEED * row,
        "decision.nominal_input.x": 0.15 * row,
        "decision.nominal_input.y": 0.0 * row,
        "decision.robust_input.x": 0.05 * row,
        "decision.robust_input.y": 0.0 * row,
        "decision.robust_gain": 0.1 * row,
    }


def held(columns: Columns, uncertainty: str = "independent") -> np.ndarray:
    hypotheses = Hypotheses(np.array([ALPHA]), np.array([0.05]), uncertainty)
    return with_guarantee(columns, hypotheses, TICK)["guarantee.held"][0, :-1]


@pytest.mark.parametrize("uncertainty", ["paper", "independent", "slip_ratio"])
def test_slip_at_its_bound_holds_as_in_the_papers_own_simulation(uncertainty):
    assert held(sound(), uncertainty).all()


def test_uncertainty_is_what_the_flat_input_does_not_explain():
    columns = sound()
    assert np.abs(with_guarantee(columns, None, TICK)["guarantee.uncertainty"]).max() < 1e-12
    columns["motion.velocity.x"] = columns["motion.velocity.x"] * 2.0
    columns["motion.velocity.y"] = columns["motion.velocity.y"] + 0.3 * np.arange(ROWS) * TICK
    uncertainty = with_guarantee(columns, None, TICK)["guarantee.uncertainty"][0, :-1]
    assert uncertainty == pytest.approx(np.hypot(0.2, 0.3), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("slip.longitudinal", ALPHA * SPEED * 1.001),
        ("slip.lateral", -ALPHA * SPEED * 1.001),
        ("slip.yaw", -ALPHA * SPEED * 1.001),
        ("motion.forward_speed", 0.049),
        ("decision.robust_gain", -1.0),
    ],
)
def test_each_violation_shows_in_its_own_tick(name, value):
    columns = sound()
    columns[name] = columns[name].copy()
    columns[name][0, 7] = value
    if name == "motion.forward_speed":  # slip in proportion, so that only the speed is at fault
        for slip in ("slip.longitudinal", "slip.lateral", "slip.yaw"):
            columns[slip] = columns[slip].copy()
            columns[slip][0, 7] = 0.0
    expected = np.ones(ROWS - 1, dtype=bool)
    expected[7] = False
    assert (held(columns) == expected).all()


def test_an_uncertainty_above_rho_is_a_violation():
    columns = sound()
    velocity = columns["motion.velocity.x"].copy()
    velocity[0, 20:] += 0.11 * TICK  # one tick with η = 0.11 > ρ = 0.1
    columns["motion.velocity.x"] = velocity
    result = held(columns)
    assert not result[19]
    assert result.sum() == ROWS - 2


def test_the_papers_bound_is_on_the_sum_the_slip_ratios_on_the_length():
    columns = sound()
    columns["slip.longitudinal"] = np.full((1, ROWS), 1.9 * ALPHA * SPEED)
    columns["slip.lateral"] = np.full((1, ROWS), 0.1 * ALPHA * SPEED)
    assert held(columns, "paper").all()
    assert not held(columns, "independent").any()
    assert not held(columns, "slip_ratio").any()
    columns["slip.longitudinal"] = np.full((1, ROWS), 1.4 * ALPHA * SPEED)
    assert held(columns, "slip_ratio").all()


def test_without_a_theorem_there_is_nothing_to_hold():
    assert "guarantee.held" not in with_guarantee(sound(), None, TICK)
