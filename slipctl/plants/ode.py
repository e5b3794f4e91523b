"""The paper's kinematic slip model (29) as a plant, for any number of worlds."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.plants.ending import judged
from slipctl.theory.robot import WheelGeometry
from slipctl.theory.slip import SlipLaw, slipping_velocity
from slipctl.tick import Array, BodyPose, Motion, Slip, SpeedCommand, Start, WheelContact


@dataclass(frozen=True)
class OdeState:
    """State of the kinematic model and what it was told last.

    Attributes
    ----------
    time : float
        [s].
    position : (N, 2) array
        [m].
    heading, forward_speed : (N,) arrays
        θ [rad] and v [m/s].
    heading_vector : (N, 2) array
        Cosine and sine of θ.
    yaw_rate : (N,) array
        The w in force before this instant [rad/s].
    wheel_angle : (N, 2) array
        Left, right [rad].
    status : (N,) int8 array
        Values of `Status`.
    """

    time: float
    position: Array
    heading: Array
    heading_vector: Array
    forward_speed: Array
    yaw_rate: Array
    wheel_angle: Array
    status: NDArray[np.int8]


@dataclass(frozen=True)
class KinematicOde:
    """Equation (29): ẋ, ẏ, θ̇ with slip, v̇ = ū₁, both inputs held over a tick.

    The wheels do exactly what they are told, so v is the wheel-derived speed. One classical Runge–Kutta step
    per tick: its error at 100 Hz is far below the 1e-6 that a test holds against Radau.

    Attributes
    ----------
    geometry : WheelGeometry
    slip_law : SlipLaw
        Gives the slip from time and v.
    arena : (N,) array
        Distance from the world's origin at which a run ends [m].
    """

    geometry: WheelGeometry
    slip_law: SlipLaw
    arena: Array

    def start(self, start: Start) -> OdeState:
        """Return the planned state; slip acts from the first instant."""
        return OdeState(
            time=0.0,
            position=np.array(start.position, order="F"),
            heading=start.heading.copy(),
            heading_vector=pair(np.cos(start.heading), np.sin(start.heading)),
            forward_speed=start.forward_speed.copy(),
            yaw_rate=start.yaw_rate.copy(),
            wheel_angle=np.zeros(start.position.shape, order="F"),
            status=np.zeros(len(start.heading), dtype=np.int8),
        )

    def observe(self, state: OdeState) -> Motion:
        """Return the motion at the state's instant, before a new command takes force."""
        slip = self.slip_law.affine(state.time).at(state.forward_speed)
        cosine, sine = state.heading_vector[:, 0], state.heading_vector[:, 1]
        velocity = slipping_velocity(state.forward_speed, slip, cosine, sine)
        return Motion(
            position=state.position,
            velocity=pair(*velocity),
            heading_vector=state.heading_vector,
            heading_rate=state.yaw_rate + slip.yaw,
            wheel_rate=self.geometry.wheel_rates(state.forward_speed, state.yaw_rate),
            wheel_angle=state.wheel_angle,
            forward_speed=state.forward_speed,
            yaw_rate=state.yaw_rate,
            acceleration=None,
        )

    def details(self, state: OdeState) -> tuple[BodyPose, WheelContact] | None:
        """Return None: a kinematic model has neither bodies nor contacts."""
        return None

    def step(self, state: OdeState, command: SpeedCommand, tick: float) -> OdeState:
        """Return the state one tick [s] later.

        A world that ended stays where it is; one that diverged keeps its last finite state.
        """
        # ū₁ where the wheels are as fast as the law believes; they are not in the first tick from rest
        rate = (command.forward_speed - state.forward_speed) / tick
        turn = command.yaw_rate

        def driven(elapsed: float) -> tuple[Array, Slip]:
            speed = state.forward_speed + rate * elapsed
            return speed, self.slip_law.affine(state.time + elapsed).at(speed)

        # Neither position nor heading feeds back on speed and slip, so both stages in the middle have the
        # same, every heading is known beforehand, and one call turns all of them.
        with np.errstate(over="ignore", invalid="ignore"):
            (v1, s1), (v2, s2), (v4, s4) = driven(0.0), driven(tick / 2.0), driven(tick)
            h1, h2, h4 = turn + s1.yaw, turn + s2.yaw, turn + s4.yaw
            later = np.empty((4, len(turn)))
            np.multiply(h1, tick / 2.0, out=later[0])
            np.multiply(h2, tick / 2.0, out=later[1])
            np.multiply(h2, tick, out=later[2])
            np.multiply(_simpson(h1, 2.0 * h2, 2.0 * h2, h4), tick / 6.0, out=later[3])
            later += state.heading
            cosines, sines = np.cos(later), np.sin(later)
            x1, y1 = slipping_velocity(v1, s1, state.heading_vector[:, 0], state.heading_vector[:, 1])
            x2, y2 = slipping_velocity(v2, s2, cosines[:2], sines[:2])
            x4, y4 = slipping_velocity(v4, s4, cosines[2], sines[2])
            x2 *= 2.0
            y2 *= 2.0
            moved = np.array((_simpson(x1, x2[0], x2[1], x4), _simpson(y1, y2[0], y2[1], y4)))
            moved *= tick / 6.0
            moved += state.position.T
            new = OdeState(
                time=state.time + tick,
                position=moved.T,
                heading=later[3],
                heading_vector=pair(cosines[3], sines[3]),
                # not v + ū₁·tick: the law remembers the speed it commanded, to the last bit
                forward_speed=command.forward_speed,
                yaw_rate=turn,
                wheel_angle=state.wheel_angle
                + self.geometry.wheel_rates((state.forward_speed + command.forward_speed) / 2.0, turn) * tick,
                status=state.status,
            )
        finite = np.isfinite(new.heading + new.forward_speed)
        status, moves = judged(state.status, new.position, finite, self.arena)
        if np.count_nonzero(moves) == len(moves):
            return new if status is state.status else replace(new, status=status)
        return OdeState(
            time=new.time,
            position=np.where(moves[:, None], new.position, state.position),
            heading=np.where(moves, new.heading, state.heading),
            heading_vector=np.where(moves[:, None], new.heading_vector, state.heading_vector),
            forward_speed=np.where(moves, new.forward_speed, state.forward_speed),
            yaw_rate=np.where(moves, new.yaw_rate, state.yaw_rate),
            wheel_angle=np.where(moves[:, None], new.wheel_angle, state.wheel_angle),
            status=status,
        )


def _simpson(k1: Array, twice_k2: Array, twice_k3: Array, k4: Array) -> Array:
    return k1 + twice_k2 + twice_k3 + k4
