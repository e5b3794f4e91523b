"""What passes between the reference, the plant and the controller within one control tick.

Every array has the world as its leading axis: ``(N,)`` for a scalar per world and ``(N, 2)`` for a pair per
world; one robot is a batch of one. Pairs of wheels are ordered as `WHEELS`; pairs of coordinates x, y.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from enum import IntEnum
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

WHEELS = ("left", "right")


class Status(IntEnum):
    """What became of a world; everything but `RUNNING` ended it early."""

    RUNNING = 0
    DIVERGED = 1
    TIPPED = 2
    LEFT_THE_ARENA = 3


@dataclass(frozen=True)
class PathTime:
    """A path's own time τ at an instant, and the path as a function of τ.

    Attributes
    ----------
    elapsed, elapsed_after : (N,) arrays
        τ now and one tick later [s].
    rate, rate_after : (N,) arrays
        dτ/dt now and one tick later [1]; 0 where the robot rests.
    velocity, acceleration : (N, 2) arrays
        First and second derivative of the planned position by τ [m/s], [m/s²].
    """

    elapsed: Array
    elapsed_after: Array
    rate: Array
    rate_after: Array
    velocity: Array
    acceleration: Array

    def each(self, change: Callable[[Array], Array]) -> PathTime:
        """Return the same with every array changed."""
        return PathTime(*(change(getattr(self, field.name)) for field in fields(self)))


@dataclass(frozen=True)
class Reference:
    """The planned flat output and its derivatives at one instant.

    Attributes
    ----------
    position, velocity, acceleration, jerk : (N, 2) arrays
        World x, y in m, m/s, m/s², m/s³.
    path_time : PathTime or None
        None where the path has no time of its own.
    """

    position: Array
    velocity: Array
    acceleration: Array
    jerk: Array
    path_time: PathTime | None = None

    def each(self, change: Callable[[Array], Array]) -> Reference:
        """Return the same with every array changed."""
        return Reference(
            change(self.position),
            change(self.velocity),
            change(self.acceleration),
            change(self.jerk),
            None if self.path_time is None else self.path_time.each(change),
        )

    def row(self, k: int) -> Reference:
        """Return row `k` of a reference whose arrays are (T + 1, N, 2), or (T + 1, N)."""
        return self.each(lambda array: array[k])


@dataclass(frozen=True)
class Start:
    """How a world starts.

    Attributes
    ----------
    position : (N, 2) array
        World x, y of the axle midpoint [m].
    heading : (N,) array
        Counter-clockwise from the world's x axis [rad].
    forward_speed, yaw_rate : (N,) arrays
        Wheel-derived rates [m/s], [rad/s].
    forward_acceleration : (N,) array
        The planned one [m/s²].
    path_speed : (N,) array or None
        Planned speed in the path's own time, which is not 0 where the robot starts at rest [m/s]; None where
        the path has no time of its own.
    uphill_acceleration : (N,) array or None
        What a slope takes along the heading and torque motors already hold against [m/s²]; None on the level.
    """

    position: Array
    heading: Array
    forward_speed: Array
    yaw_rate: Array
    forward_acceleration: Array
    path_speed: Array | None = None
    uphill_acceleration: Array | None = None


@dataclass(frozen=True)
class Motion:
    """What the robot does at one instant; every field belongs to the same instant.

    Attributes
    ----------
    position, velocity : (N, 2) arrays
        World x, y of the axle midpoint [m], [m/s].
    heading_vector : (N, 2) array
        Cosine and sine of the heading.
    heading_rate : (N,) array
        Rate of the heading, Ω in the paper's terms w + w_s [rad/s].
    wheel_rate, wheel_angle : (N, 2) arrays
        Wheel rates and angles left, right, positive forward [rad/s], [rad].
    forward_speed, yaw_rate : (N,) arrays
        The same rates as v = r (left + right)/2 and w = r (right − left)/(2b) [m/s], [rad/s].
    acceleration : (N, 2) array or None
        World x, y [m/s²]; None where a plant has none to tell.
    """

    position: Array
    velocity: Array
    heading_vector: Array
    heading_rate: Array
    wheel_rate: Array
    wheel_angle: Array
    forward_speed: Array
    yaw_rate: Array
    acceleration: Array | None


@dataclass(frozen=True)
class Slip:
    """Slip velocities as in Fig. 2 of the paper.

    Attributes
    ----------
    longitudinal, lateral : (N,) arrays
        v_t forward and v_s, **positive to the right**, at the axle midpoint [m/s].
    yaw : (N,) array
        w_s, counter-clockwise [rad/s].
    """

    longitudinal: Array
    lateral: Array
    yaw: Array


@dataclass(frozen=True)
class SpeedCommand:
    """What wheel-speed servos are told for one tick.

    Attributes
    ----------
    forward_acceleration : (N,) array
        ū₁, held over the tick [m/s²].
    forward_speed : (N,) array
        The speed that ū₁ reaches at the end of the tick [m/s].
    yaw_rate : (N,) array
        ū₂, held over the tick [rad/s].
    wheel_rate : (N, 2) array
        Set points of the wheel servos over the tick, left and right [rad/s].
    """

    forward_acceleration: Array
    forward_speed: Array
    yaw_rate: Array
    wheel_rate: Array


@dataclass(frozen=True)
class TorqueCommand:
    """What torque motors are told for one tick.

    Attributes
    ----------
    acceleration : (N,) array
        μ₁ at the end of the tick [m/s²].
    yaw_acceleration : (N,) array
        μ₂, held over the tick [rad/s²].
    wheel_torque_start, wheel_torque_end : (N, 2) arrays
        Left and right, at both ends of the tick [N·m]; the paper's μ₁ is integrated, so torque ramps. A motor
        that can only hold a torque gets their mean.
    """

    acceleration: Array
    yaw_acceleration: Array
    wheel_torque_start: Array
    wheel_torque_end: Array


Command = SpeedCommand | TorqueCommand


@dataclass(frozen=True)
class DecisionTrace:
    """Why a law decided as it did; what a law does not have is None.

    Attributes
    ----------
    nominal_input, robust_input : (N, 2) arrays
        v̂ and Δv [m/s²]; [m/s³] for a dynamic law.
    saturated : (N,) bool array
        Whether a limit changed the command.
    robust_gain : (N,) array or None
        ρ, in the unit of Δv.
    weighted_error : (N, 2) array or None
        JᵀPe, the vector whose length the boundary layer bounds.
    path_speed : (N,) array or None
        ṽ of a law that controls in the path's own time [m/s]; all its other inputs are in that time, too.
    path_velocity : (N, 2) array or None
        dF/dτ as that law sees it [m/s].
    """

    nominal_input: Array
    robust_input: Array
    saturated: NDArray[np.bool_]
    robust_gain: Array | None = None
    weighted_error: Array | None = None
    path_speed: Array | None = None
    path_velocity: Array | None = None


AnyCommand = TypeVar("AnyCommand", SpeedCommand, TorqueCommand, covariant=True)


@dataclass(frozen=True)
class Decision(Generic[AnyCommand]):
    """What a law decides in one tick.

    Attributes
    ----------
    command : Command
    memory : object
        What the law wants to see again at the next tick; opaque to everybody else.
    trace : DecisionTrace
        The reasons.
    """

    command: AnyCommand
    memory: Any
    trace: DecisionTrace


@dataclass(frozen=True)
class BodyPose:
    """Where the robot's bodies are, for pictures.

    Attributes
    ----------
    height : (N,) array
        z of the body origin [m].
    quaternion : (N, 4) array
        Orientation of the base, order w, x, y, z.
    """

    height: Array
    quaternion: Array


@dataclass(frozen=True)
class WheelContact:
    """What happens between wheels and floor, left and right; forces act on the robot.

    Attributes
    ----------
    torque : (N, 2) array
        Motor torque [N·m].
    normal_force : (N, 2) array
        [N].
    longitudinal_force, lateral_force : (N, 2) arrays
        Along the body's forward and **left** axes [N].
    sliding : (N, 2) bool array
        Whether the friction force is at its limit.
    """

    torque: Array
    normal_force: Array
    longitudinal_force: Array
    lateral_force: Array
    sliding: NDArray[np.bool_]
