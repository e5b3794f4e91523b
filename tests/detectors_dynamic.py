"""Numbers that a mistake in the dynamic model must move, as in `detectors`."""

from __future__ import annotations

import math

import numpy as np

import slipctl.theory.dynamic as dynamic
from slipctl.control.torque import TorqueDrive
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import ProportionalSlip
from slipctl.tick import Array, Slip
from tests.builders import PAPER_POLE, full, rows_of, track
from tests.dynamic import (
    BOUNDS,
    DYNAMIC_SLIP,
    dynamic_plant,
    nominal_dynamic,
    quintic_table_one,
    robust_dynamic,
)


def section_five_b_begins() -> Array:
    """Errors of both laws over the first 8 s of the paper's path, tick 10 ms, with a layer that shows [m]."""
    tick = 0.01
    references = rows_of(quintic_table_one(), tick, 8.0)
    slip = ProportionalSlip(*(full(1, DYNAMIC_SLIP) for _ in range(3)))
    pole = full(1, PAPER_POLE)
    bound = BOUNDS["proportional"](full(1, DYNAMIC_SLIP))
    found = []
    for law in (nominal_dynamic(pole), robust_dynamic(pole, full(1, 0.1), bound)):
        run = track(dynamic_plant(slip, 1), law, references, tick)
        error = run.position_error[: run.ending.last_row[0] + 1, 0]
        found += [error.max(), np.sqrt(np.mean(error**2)), error[-1]]
    return np.array(found)


def torques() -> float:
    """Violation of (21) by hand, with wheels that have inertia and axles that rub, there and back."""
    # made anew: a body keeps what it has worked out of its numbers
    heavy = Inertia(MAGELLAN_PRO, 18.2, 0.39375, wheel_inertia=0.0074, joint_friction=0.05)
    rate = np.array([[-3.0, 4.0]])
    push, spin = np.array([0.4]), np.array([-0.7])
    mass = 18.2 + 2.0 * 0.0074 / 0.0825**2
    inertia = 0.39375 + 2.0 * 0.0074 * (0.1624 / 0.0825) ** 2
    left, right = heavy.torques(push, spin, rate)[0]
    total = right + left - 0.0825 * mass * 0.4  # the axles rub against each other's sense
    difference = right - left - 0.0825 * inertia * -0.7 / 0.1624 - 2.0 * 0.05
    back = heavy.accelerations(np.array([[left, right]]), rate)
    return max(abs(total), abs(difference), abs(back[0][0] - 0.4), abs(back[1][0] + 0.7))


def accelerations() -> float:
    """Violation of (21) from torques to accelerations, by hand."""
    body = Inertia(MAGELLAN_PRO, 18.2, 0.39375)
    push, spin = body.accelerations(np.array([[0.1, 0.3]]), np.ones((1, 2)))
    return max(abs(push[0] - 0.4 / (0.0825 * 18.2)), abs(spin[0] - 0.2 * 0.1624 / (0.0825 * 0.39375)))


def ramp() -> float:
    """Violation of τ(t) = (r/2) m (μ₁ + μ̄₁ t) at both ends of a tick."""
    drive = TorqueDrive(Inertia(MAGELLAN_PRO, 18.2, 0.39375), full(1, 1e6), full(1, 0.05))
    command, memory, _ = drive.command(full(1, 0.2), full(1, 3.0), full(1, 0.0), np.ones((1, 2)), 0.01)
    half = 0.0825 / 2.0 * 18.2
    start, end = command.wheel_torque_start[0], command.wheel_torque_end[0]
    return max(*np.abs(start - half * 0.2), *np.abs(end - half * 0.23), abs(memory.acceleration[0] - 0.23))


def third_derivative() -> float:
    """Violation of F⃛ = A + Bμ̄ + C + Dμ̄ for the plant's own F⃛, at one state facing along x."""
    v, w, mu1, jerk, spin = 0.4, -0.6, 0.2, 0.5, -0.3
    v_t, v_s, w_s, rate, acceleration = 0.1, -0.15, 0.3, 0.2, -0.4
    turn, speed = w + w_s, v + v_t
    exact = np.array(
        [
            jerk - (speed * turn - rate) * turn,
            speed * spin + 2.0 * mu1 * turn - v_s * turn**2 - acceleration,
        ]
    )
    one = np.array([v]), np.array([w]), np.array([mu1])
    facing = np.ones(1), np.zeros(1)
    slip = Slip(np.array([v_t]), np.array([v_s]), np.array([w_s]))
    rates = np.array([rate]), np.array([acceleration])
    c_matrix, d_matrix = dynamic.slip_terms(*one, slip, *rates, *facing)
    a = dynamic.drift(*one, *facing)
    got = a[0] + [jerk, v * spin] + c_matrix[0] + d_matrix[0] @ [jerk, spin]
    return float(np.abs(got - exact).max())


def inverse_of_dynamics() -> float:
    """Violation of A + B μ̄ = v for the inverse, facing 0.7 rad."""
    c, s = np.array([math.cos(0.7)]), np.array([math.sin(0.7)])
    a, wanted, v = np.array([[0.3, -0.4]]), np.array([[-0.2, 0.7]]), np.array([0.4])
    jerk, spin = dynamic.invert_dynamics(v, c, s, wanted, a)
    got = a[0] + [c[0] * jerk[0] - s[0] * v[0] * spin[0], s[0] * jerk[0] + c[0] * v[0] * spin[0]]
    return float(np.abs(got - wanted[0]).max())
