"""Numbers that a mistake must move: errors of short closed loops, and violations of identities."""

from __future__ import annotations

from typing import Any

import numpy as np

import slipctl.theory.flatness as flatness
import slipctl.theory.slip as slip_theory
from slipctl.control.drive import DriveLimits
from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.theory.reference import FigureEight
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.tick import Array, Motion
from tests.builders import (
    PAPER_LAYER,
    PAPER_POLE,
    PAPER_SLIP,
    at_origin,
    full,
    nominal_law,
    ode_plant,
    paper_slip,
    robust_law,
    rows_of,
    table_one,
    track,
)


def _errors(run: Any) -> list[float]:
    """Return maximum, RMS and final error, as far as the world came."""
    error = run.position_error[: run.ending.last_row[0] + 1, 0]
    return [error.max(), np.sqrt(np.mean(error**2)), error[-1]]


def section_five_a() -> Array:
    """Errors of both laws on the paper's path with the paper's slip, tick 10 ms [m]."""
    references = rows_of(table_one(), 0.01, 20.0)
    pole = full(1, PAPER_POLE)
    laws = (nominal_law(pole), robust_law(pole, full(1, PAPER_SLIP), full(1, PAPER_LAYER)))
    return np.ravel([_errors(track(ode_plant(paper_slip(), 1), law, references, 0.01)) for law in laws])


def figure_eight_on_grip() -> Array:
    """Errors of the nominal law on MuJoCo's dry floor for 3 s [m]: there the wheels drive the robot."""
    references = rows_of(FigureEight(full(1, 2.0), full(1, 1.0), at_origin(1)), 0.01, 3.0)
    drive = DriveLimits(MAGELLAN_PRO, full(1, 2.5), full(1, 6.0), full(1, 0.05))
    plant = MujocoPlant.build(ground=Ground.flat(0.8))
    return np.array(_errors(track(plant, nominal_law(full(1, -2.0), drive), references, 0.01)))


def wheels() -> float:
    """Violation of right − left = 2 b w/r, right + left = 2 v/r, and of the way back."""
    v, w = np.array([0.7]), np.array([-1.3])
    rates = MAGELLAN_PRO.wheel_rates(v, w)
    left, right = rates[0]
    back_v, back_w = MAGELLAN_PRO.body_rates(rates)
    difference = right - left - 2.0 * 0.1624 * w[0] / 0.0825
    total = right + left - 2.0 * v[0] / 0.0825
    return max(abs(difference), abs(total), abs(back_v[0] - v[0]), abs(back_w[0] - w[0]))


def measured_slip() -> float:
    """Difference between the measured slip and the slip of a motion written out by (28)."""
    v, w, v_t, v_s, w_s, heading = 0.6, 0.4, -0.1, 0.2, 0.3, 2.2
    c, s = np.cos(heading), np.sin(heading)
    one = full(1, 1.0)
    velocity = np.array([[(v + v_t) * c + v_s * s, (v + v_t) * s - v_s * c]])
    still = np.zeros((1, 2))
    motion = Motion(
        still, velocity, np.array([[c, s]]), (w + w_s) * one, still, still, v * one, w * one, still
    )
    slip = slip_theory.measure_slip(motion)
    return max(abs(slip.longitudinal[0] - v_t), abs(slip.lateral[0] - v_s), abs(slip.yaw[0] - w_s))


def flat_round_trip() -> float:
    """Error of going to the flat output and back in quadrant II."""
    state = np.array([[0.6], [2.2], [0.3], [-0.4]])
    back = flatness.flat_to_state(*flatness.state_to_flat(*state))
    return float(np.abs(np.array(back) - state).max())
