"""Recordings made by hand on which the theorem holds, for one world."""

from __future__ import annotations

import numpy as np

from slipctl.guarantee import Hypotheses
from slipctl.recording import Columns
from slipctl.theory.robust import chain_gains, lyapunov_matrix

ROWS, TICK, ALPHA, SPEED, FLOOR, LAYER = 50, 0.01, 0.3, 0.5, 0.05, 0.02
PUSH = 0.2


def hypotheses(uncertainty: str = "independent", order: int = 2, pole: float = -0.5, **changed) -> Hypotheses:
    gains = chain_gains(np.array([pole]), order)
    fields = {
        "slip_bound": np.array([ALPHA]),
        "speed_floor": np.array([FLOOR]),
        "uncertainty": uncertainty,
        "boundary_layer": np.array([LAYER]),
        "gains": gains,
        "weights": np.stack([lyapunov_matrix(row) for row in gains]),
    }
    return Hypotheses(**(fields | changed))


def sound(rows: int = ROWS, order: int = 2) -> Columns:
    """Return a robot that follows its reference and its flat input exactly, with slip at its bound."""
    time = np.arange(rows)[None, :] * TICK
    row = np.ones((1, rows))
    columns = {
        "motion.forward_speed": SPEED * row,
        "slip.longitudinal": ALPHA * SPEED * row,
        "slip.lateral": -ALPHA * SPEED * row,
        "slip.yaw": ALPHA * SPEED * row,
        "decision.nominal_input.x": 0.75 * PUSH * row,
        "decision.robust_input.x": 0.25 * PUSH * row,
        "decision.nominal_input.y": 0.0 * row,
        "decision.robust_input.y": 0.0 * row,
        "decision.robust_gain": 0.1 * row,
        "decision.weighted_error.x": 0.0 * row,
        "decision.weighted_error.y": 0.0 * row,
        "error.position": 0.0 * row,
    }
    if order == 3:
        columns["decision.acceleration"] = 0.0 * row
    factorial = (1.0, 2.0, 6.0)
    for power, name in enumerate(("acceleration", "velocity", "position")[3 - order :]):
        course = np.asarray(PUSH * time ** (power + 1) / factorial[power], dtype=np.float64)
        for seen in ("motion", "reference"):
            columns[f"{seen}.{name}.x"] = course.copy()
            columns[f"{seen}.{name}.y"] = 0.0 * row
    return columns


def changed(columns: Columns, name: str, rows: int | slice, value: float) -> Columns:
    """Return the columns with `value` in some rows of one of them."""
    columns = {key: values.copy() for key, values in columns.items()}
    columns[name][0, rows] = value
    return columns
