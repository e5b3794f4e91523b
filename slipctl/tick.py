"""What passes between the reference, the plant and the controller within one control tick.

Every array has the world as its leading axis: ``(N,)`` for a scalar per world and ``(N, 2)`` for a pair per
world; one robot is a batch of one. Pairs of wheels are ordered left, right; pairs of coordinates x, y.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Status(IntEnum):
    """What became of a world; everything but `RUNNING` ended it early."""

    RUNNING = 0
    DIVERGED = 1
    TIPPED = 2
    LEFT_THE_ARENA = 3


@dataclass(frozen=True)
class Reference:
    """The planned flat output and its derivatives at one instant.

    Attributes
    ----------
    position, velocity, acceleration : (N, 2) arrays
        World x, y in m, m/s, m/s².
    """

    position: Array
    velocity: Array
    acceleration: Array


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
    """

    position: Array
    heading: Array
    forward_speed: Array
    yaw_rate: Array


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
    wheel_rate : (N, 2) array
        Wheel rates left, right, positive forward [rad/s].
    forward_speed, yaw_rate : (N,) arrays
        The same rates as v = r (left + right)/2 and w = r (right − left)/(2b) [m/s], [rad/s].
    """

    position: Array
    velocity: Array
    heading_vector: Array
    heading_rate: Array
    wheel_rate: Array
    forward_speed: Array
    yaw_rate: Array


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
class Command:
    """What the drive is told for one tick.

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
class DecisionTrace:
    """Why a law decided as it did; what a law does not have is None.

    Attributes
    ----------
    nominal_input, robust_input : (N, 2) arrays
        v̂ and Δv [m/s²].
    saturated : (N,) bool array
        Whether a limit changed the command.
    robust_gain : (N,) array or None
        ρ [m/s²].
    weighted_error : (N, 2) array or None
        JᵀPe, the vector whose length the boundary layer bounds.
    """

    nominal_input: Array
    robust_input: Array
    saturated: NDArray[np.bool_]
    robust_gain: Array | None = None
    weighted_error: Array | None = None


@dataclass(frozen=True)
class Decision:
    """What a law decides in one tick.

    Attributes
    ----------
    command : Command
    memory : object
        What the law wants to see again at the next tick; opaque to everybody else.
    trace : DecisionTrace
        The reasons.
    """

    command: Command
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
    wheel_angle : (N, 2) array
        Left, right [rad].
    """

    height: Array
    quaternion: Array
    wheel_angle: Array


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


@dataclass(frozen=True)
class Shape:
    """One drawable piece of a robot.

    Attributes
    ----------
    body : str
        ``base``, ``left_wheel`` or ``right_wheel``.
    kind : str
        ``box``, ``cylinder``, ``sphere``, ``ellipsoid``, ``capsule``, ``mesh`` or ``plane``.
    size : (3,) array
        As in MJCF [m].
    position, quaternion : (3,), (4,) arrays
        Pose in the frame of the body [m]; w, x, y, z.
    rgba : (4,) array
        Colour, 0 to 1.
    """

    body: str
    kind: str
    size: Array
    position: Array
    quaternion: Array
    rgba: Array
