"""The paper's kinematic slip model (29) as a plant, for any number of worlds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipctl.pairs import pair
from slipctl.plants.ending import judged
from slipctl.theory.robot import WheelGeometry
from slipctl.theory.slip import Affine, SlipLaw, slipping_velocity
from slipctl.tick import Array, BodyPose, Motion, SpeedCommand, Start, WheelContact


@dataclass(frozen=True)
class OdeState:
    """State of the kinematic model, what it was told last, and what follows from both.

    What follows is known when a step ends, costs next to nothing there, and is the next step's first stage.

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
    velocity : (N, 2) array
        With the slip of this instant [m/s].
    yaw_slip : (N,) array
        w_s [rad/s].
    wheel_rate : (N, 2) array
        Left, right [rad/s].
    """

    time: float
    position: Array
    heading: Array
    heading_vector: Array
    forward_speed: Array
    yaw_rate: Array
    wheel_angle: Array
    status: NDArray[np.int8]
    velocity: Array
    yaw_slip: Array
    wheel_rate: Array


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
        return self._state(
            time=0.0,
            position=np.array(start.position, order="F"),
            heading=start.heading.copy(),
            heading_vector=pair(np.cos(start.heading), np.sin(start.heading)),
            forward_speed=start.forward_speed.copy(),
            yaw_rate=start.yaw_rate.copy(),
            wheel_angle=np.zeros(start.position.shape, order="F"),
            status=np.zeros(len(start.heading), dtype=np.int8),
        )

    def _state(self, **integrated: Any) -> OdeState:
        """Return the state of what is integrated, together with what follows."""
        speed, heading_vector = integrated["forward_speed"], integrated["heading_vector"]
        slip = self.slip_law.affine(integrated["time"]).at(speed)
        return OdeState(
            **integrated,
            velocity=pair(*slipping_velocity(speed, slip, heading_vector[:, 0], heading_vector[:, 1])),
            yaw_slip=slip.yaw,
            wheel_rate=self.geometry.wheel_rates(speed, integrated["yaw_rate"]),
        )

    def with_own_slip(self, state: OdeState) -> OdeState:
        """Return a state that a plant with another slip law made, as it is under this one's."""
        return self._state(**{name: getattr(state, name) for name in INTEGRATED})

    def observe(self, state: OdeState) -> Motion:
        """Return the motion at the state's instant, before a new command takes force."""
        return Motion(
            position=state.position,
            velocity=state.velocity,
            heading_vector=state.heading_vector,
            heading_rate=state.yaw_rate + state.yaw_slip,
            wheel_rate=state.wheel_rate,
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
        turn, half = command.yaw_rate, tick / 2.0
        time = state.time + tick
        with np.errstate(over="ignore", invalid="ignore"):
            # Neither position nor heading feeds back on speed and slip, so all of them are known beforehand.
            # Rows 0 and 1 are the second and third stage, both in the middle, row 2 is the fourth and row 3
            # the new state, whose speed is not v + ū₁·tick: the law remembers what it commanded, to the last
            # bit. Numpy takes hardly longer for four rows than for one, but long for rows of two lengths.
            speed = np.empty((4, len(turn)))
            speed[0] = speed[1] = state.forward_speed + rate * half
            np.add(state.forward_speed, rate * tick, out=speed[2])
            speed[3] = command.forward_speed
            middle, end = self.slip_law.affine(state.time + half), self.slip_law.affine(time)
            slip = Affine.together((middle, middle, end, end)).at(speed)
            heading = np.empty(speed.shape)
            h1, h2, h4 = turn + state.yaw_slip, turn + slip.yaw[0], turn + slip.yaw[2]
            np.multiply(h1, half, out=heading[0])
            np.multiply(h2, half, out=heading[1])
            np.multiply(h2, tick, out=heading[2])
            h2 *= 2.0
            np.multiply(_simpson(h1, h2, h2, h4), tick / 6.0, out=heading[3])
            heading += state.heading
            cosine, sine = np.cos(heading), np.sin(heading)
            x, y = slipping_velocity(speed, slip, cosine, sine)
            velocity = pair(x[3], y[3])
            twice_x, twice_y = 2.0 * x[:2], 2.0 * y[:2]
            moved = pair(
                _simpson(state.velocity[:, 0], twice_x[0], twice_x[1], x[2]),
                _simpson(state.velocity[:, 1], twice_y[0], twice_y[1], y[2]),
            )
            moved *= tick / 6.0
            moved += state.position
            new = OdeState(
                time=time,
                position=moved,
                heading=heading[3],
                heading_vector=pair(cosine[3], sine[3]),
                forward_speed=command.forward_speed,
                yaw_rate=turn,
                wheel_angle=state.wheel_angle
                + self.geometry.wheel_rates((state.forward_speed + command.forward_speed) / 2.0, turn) * tick,
                status=state.status,
                velocity=velocity,
                yaw_slip=slip.yaw[3],
                wheel_rate=self.geometry.wheel_rates(command.forward_speed, turn),
            )
            status, moves = judged(state.status, moved, new.heading + new.forward_speed, self.arena)
        if moves is None:
            return new
        return self._state(
            time=time,
            position=np.where(moves[:, None], new.position, state.position),
            heading=np.where(moves, new.heading, state.heading),
            heading_vector=np.where(moves[:, None], new.heading_vector, state.heading_vector),
            forward_speed=np.where(moves, new.forward_speed, state.forward_speed),
            yaw_rate=np.where(moves, new.yaw_rate, state.yaw_rate),
            wheel_angle=np.where(moves[:, None], new.wheel_angle, state.wheel_angle),
            status=status,
        )


INTEGRATED = (
    "time",
    "position",
    "heading",
    "heading_vector",
    "forward_speed",
    "yaw_rate",
    "wheel_angle",
    "status",
)
"""Fields of a state from which the others follow."""


def _simpson(k1: Array, twice_k2: Array, twice_k3: Array, k4: Array) -> Array:
    total = k1 + twice_k2
    total += twice_k3
    total += k4
    return total
