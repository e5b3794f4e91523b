"""The paper's dynamic slip model (31) as a plant, for any number of worlds.

Symbols as in the paper; V = v + v_t and Ω = w + w_s, the speeds of the body.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.plants.ending import judged
from slipctl.theory.dynamic import Inertia
from slipctl.theory.slip import SlipLaw
from slipctl.tick import Array, BodyPose, Motion, Slip, Start, TorqueCommand, WheelContact


@dataclass(frozen=True)
class DynamicState:
    """State of the dynamic model.

    (31d) and (31f) say V̇ = μ₁ − v_sΩ and Ω̇ = μ₂ once the slip's own rates are moved to the left, so the state
    holds V and Ω, and v and w follow from the slip law: no slip rate has to be differentiated numerically.

    Attributes
    ----------
    time : float
        [s].
    position, wheel_angle, wheel_torque : (N, 2) arrays
        [m]; left, right [rad]; the torque in force before this instant, left, right [N·m].
    heading, body_speed, heading_rate : (N,) arrays
        θ [rad], V [m/s], Ω [rad/s].
    status : (N,) int8 array
        Values of `Status`.
    """

    time: float
    position: Array
    heading: Array
    body_speed: Array
    heading_rate: Array
    wheel_angle: Array
    wheel_torque: Array
    status: NDArray[np.int8]


@dataclass(frozen=True)
class DynamicOde:
    """Equations (31a)–(31f); the paper neglects the wheels' inertia, so `inertia` has none by default.

    Torques ramp over a tick, because μ₁ is an integral. One classical Runge–Kutta step per tick.

    Attributes
    ----------
    inertia : Inertia
    slip_law : SlipLaw
    arena : (N,) array
        Distance from the world's origin at which a run ends [m].
    """

    inertia: Inertia
    slip_law: SlipLaw
    arena: Array

    def start(self, start: Start) -> DynamicState:
        """Return the planned state at the planned wheel rates; slip acts from the first instant."""
        slip = self.slip_law.affine(0.0).at(start.forward_speed)
        still = np.zeros_like(start.forward_speed)
        rates = self.inertia.geometry.wheel_rates(start.forward_speed, start.yaw_rate)
        return DynamicState(
            time=0.0,
            position=start.position.copy(),
            heading=start.heading.copy(),
            body_speed=start.forward_speed + slip.longitudinal,
            heading_rate=start.yaw_rate + slip.yaw,
            wheel_angle=np.zeros_like(start.position),
            wheel_torque=self.inertia.torques(start.forward_acceleration, still, rates),
            status=np.zeros(len(start.heading), dtype=np.int8),
        )

    def _wheels(self, time: float, body_speed: Array, heading_rate: Array) -> tuple[Array, Array, Slip]:
        """Return v, w and the slip of body speeds V and Ω."""
        law = self.slip_law.affine(time)
        speed = (body_speed - law.offset.longitudinal) / (1.0 + law.fraction.longitudinal)
        slip = law.at(speed)
        return speed, heading_rate - slip.yaw, slip

    def observe(self, state: DynamicState) -> Motion:
        """Return the motion at the state's instant; the acceleration is the one of the torque before it."""
        speed, turn, slip = self._wheels(state.time, state.body_speed, state.heading_rate)
        c, s = np.cos(state.heading), np.sin(state.heading)
        rates = self.inertia.geometry.wheel_rates(speed, turn)
        push, _ = self.inertia.accelerations(state.wheel_torque, rates)
        along, across = (
            push,
            state.body_speed * state.heading_rate - self._lateral_rate(state, push, speed, slip),
        )
        return Motion(
            position=state.position,
            velocity=pair(*_turned(state.body_speed, -slip.lateral, c, s)),
            heading_vector=pair(c, s),
            heading_rate=state.heading_rate,
            wheel_rate=rates,
            wheel_angle=state.wheel_angle,
            forward_speed=speed,
            yaw_rate=turn,
            acceleration=pair(*_turned(along, across, c, s)),
        )

    def _lateral_rate(self, state: DynamicState, push: Array, speed: Array, slip: Slip) -> Array:
        """Return v̇_s [m/s²]."""
        law, rate = self.slip_law.affine(state.time), self.slip_law.affine_rate(state.time)
        body_rate = push - slip.lateral * state.heading_rate
        wheel_rate = (body_rate - rate.at(speed).longitudinal) / (1.0 + law.fraction.longitudinal)
        return rate.at(speed).lateral + law.fraction.lateral * wheel_rate

    def details(self, state: DynamicState) -> tuple[BodyPose, WheelContact] | None:
        """Return None: the model has neither bodies nor contacts."""
        return None

    def step(self, state: DynamicState, command: TorqueCommand, tick: float) -> DynamicState:
        """Return the state one tick [s] later; worlds that ended stay where they are."""
        first, last = command.wheel_torque_start, command.wheel_torque_end

        def derivative(elapsed: float, y: Array) -> Array:
            """Return the rates of x, y, θ, V, Ω and both wheel angles, (7, N)."""
            heading, body_speed, heading_rate = y[2], y[3], y[4]
            speed, turn, slip = self._wheels(state.time + elapsed, body_speed, heading_rate)
            rates = self.inertia.geometry.wheel_rates(speed, turn)
            push, spin = self.inertia.accelerations(first + (last - first) * (elapsed / tick), rates)
            x_rate, y_rate = _turned(body_speed, -slip.lateral, np.cos(heading), np.sin(heading))
            body_rate = push - slip.lateral * heading_rate
            return np.stack([x_rate, y_rate, heading_rate, body_rate, spin, rates[:, 0], rates[:, 1]])

        y = np.stack(
            [
                *state.position.T,
                state.heading,
                state.body_speed,
                state.heading_rate,
                *state.wheel_angle.T,
            ]
        )
        with np.errstate(over="ignore", invalid="ignore"):
            k1 = derivative(0.0, y)
            k2 = derivative(tick / 2.0, y + tick / 2.0 * k1)
            k3 = derivative(tick / 2.0, y + tick / 2.0 * k2)
            k4 = derivative(tick, y + tick * k3)
            new = y + (k1 + 2.0 * k2 + 2.0 * k3 + k4) * (tick / 6.0)
            rest = new.sum(axis=0) + last.sum(axis=1)
            status, moves = judged(state.status, new[:2].T, rest, self.arena)
        if moves is not None:
            new, last = np.where(moves, new, y), np.where(moves[:, None], last, state.wheel_torque)
        return DynamicState(
            time=state.time + tick,
            position=new[:2].T,
            heading=new[2],
            body_speed=new[3],
            heading_rate=new[4],
            wheel_angle=new[5:].T,
            wheel_torque=last,
            status=status,
        )


def _turned(along: Array, left: Array, cosine: Array, sine: Array) -> tuple[Array, Array]:
    """Return world x and y (N,) of a vector given along the heading and to the left."""
    return along * cosine - left * sine, along * sine + left * cosine
