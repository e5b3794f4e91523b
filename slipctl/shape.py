"""What a robot looks like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


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
