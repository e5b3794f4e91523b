"""Where the boundary layer of the dynamic law starts to chatter, in closed form and in the loop."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from slipctl.theory.reference import Line
from slipctl.theory.robust import largest_calm_tick
from slipctl.theory.robust_dynamic import DynamicState, largest_calm_dynamic_tick
from slipctl.theory.slip import ProportionalSlip
from slipctl.tick import Array
from tests.builders import PAPER_POLE, at_origin, full, planned_start, rows_of, track
from tests.dynamic import dynamic_plant, robust_dynamic

LAYER, GAIN, CORNER = 0.1, 1.0, 6.875
SLIPS = [0.3 - 0.3j, -0.3 - 0.3j, -0.3 + 0.0j, 0.0 - 0.3j, -0.3 + 0.3j, 0.3 + 0.3j]


def constant_gain(state: DynamicState) -> Array:
    return np.full(len(state.forward_speed), GAIN)


def threshold(sigma: complex) -> float:
    arguments = full(1, LAYER), full(1, GAIN), full(1, CORNER), np.array([sigma])
    return float(largest_calm_dynamic_tick(*arguments)[0])


def reached(sigma: complex, tick: float) -> float:
    """Return the largest ‖JᵀPe‖ at the end of 800 ticks along a line, started 1e-6 beside it."""
    references = rows_of(Line(full(1, 1.0), at_origin(1)), tick, 800 * tick)
    law = robust_dynamic(full(1, PAPER_POLE), full(1, LAYER), constant_gain)
    slip = ProportionalSlip(full(1, sigma.real), full(1, -sigma.imag), np.zeros(1))
    start = replace(  # Ḟ(0) = Ḟ_d(0) but for the disturbance
        planned_start(references),
        forward_speed=full(1, (1.0 + 1e-6) / abs(1.0 + sigma)),
        heading=full(1, 1e-6 - np.angle(1.0 + sigma)),
    )
    run = track(dynamic_plant(slip, 1, arena=1e9), law, references, tick, start)
    weighted = run.stack("decision", "trace", "weighted_error")[-50:, 0]
    return float(np.hypot(*weighted.T).max())


@pytest.mark.parametrize("sigma", SLIPS)
def test_loop_is_calm_just_below_and_chatters_just_above(sigma):
    assert reached(sigma, 0.95 * threshold(sigma)) < 1e-9
    assert reached(sigma, 1.05 * threshold(sigma)) > LAYER


def test_backward_slip_chatters_along_the_heading_sooner_than_the_kinematic_threshold_says():
    """There |1+σ|²/Re(1+σ) < 1, and the forward direction, which slip does not touch, decides."""
    sigma = -0.3 - 0.3j
    slip: Any = np.array([sigma])
    kinematic = largest_calm_tick(full(1, LAYER), full(1, GAIN), full(1, CORNER), slip)[0]
    assert kinematic == pytest.approx(1.2069 * threshold(sigma), rel=1e-4)
    assert threshold(sigma) == pytest.approx(2.0 * LAYER / (CORNER * GAIN), rel=1e-13)
    assert reached(sigma, 0.95 * kinematic) > LAYER


def test_threshold_without_gain_is_infinite():
    tick = largest_calm_dynamic_tick(full(1, LAYER), np.zeros(1), full(1, CORNER), np.array([0.3 + 0.1j]))
    assert tick[0] == np.inf
