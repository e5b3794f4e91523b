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

    The wheels do exactly what they are told, so v is the wheel-derived speed. Neither position nor heading
    feeds back on speed and slip, so a tick is two quadratures: Simpson's rule for the heading and, with the
    heading in the middle from the same parabola, for the position. Of fourth order like a Runge–Kutta step,
    for half the work; its error at 100 Hz is far below the 1e-6 that a test holds against Radau.

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
        gained = command.forward_speed - state.forward_speed
        turn, time = command.yaw_rate, state.time + tick
        with np.errstate(over="ignore", invalid="ignore"):
            # Row 0 is the middle of the tick, row 1 its end: numpy takes hardly longer for two than for one.
            # The last speed is not v + ū₁·tick: the law remembers what it commanded, to the last bit.
            speed = np.empty((2, len(turn)))
            np.add(state.forward_speed, gained * 0.5, out=speed[0])
            speed[1] = command.forward_speed
            laws = self.slip_law.affine(state.time + tick / 2.0), self.slip_law.affine(time)
            slip = Affine.together(laws).at(speed)
            rates = turn + state.yaw_slip, *(turn + slip.yaw)
            heading = np.empty(speed.shape)
            np.multiply(_first_half(*rates), tick / 24.0, out=heading[0])
            np.multiply(_simpson(*rates), tick / 6.0, out=heading[1])
            heading += state.heading
            cosine, sine = np.cos(heading), np.sin(heading)
            velocity = np.array(slipping_velocity(speed, slip, cosine, sine))
            moved = _simpson(state.velocity, velocity[:, 0].T, velocity[:, 1].T)
            moved *= tick / 6.0
            moved += state.position
            wheel_rate = self.geometry.wheel_rates(command.forward_speed, turn)
            # both wheels gain the same over the tick
            turned = wheel_rate - (gained * (0.5 / self.geometry.wheel_radius))[:, None]
            turned *= tick
            turned += state.wheel_angle
            new = OdeState(
                time=time,
                position=moved,
                heading=heading[1],
                heading_vector=pair(cosine[1], sine[1]),
                forward_speed=command.forward_speed,
                yaw_rate=turn,
                wheel_angle=turned,
                status=state.status,
                velocity=velocity[:, 1].T,
                yaw_slip=slip.yaw[1],
                wheel_rate=wheel_rate,
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


def _simpson(begin: Array, middle: Array, end: Array) -> Array:
    """Return six times the mean of a parabola through three values."""
    total = 4.0 * middle
    total += begin
    total += end
    return total


def _first_half(begin: Array, middle: Array, end: Array) -> Array:
    """Return 24 times what the first half of the same parabola adds to that mean."""
    total = 8.0 * middle
    total += 5.0 * begin
    total -= end
    return total
