"""The robot in the scene: shapes of the plant, or a plain disc robot, tinted with the colour of the run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import rerun as rr

from slipctl.shape import Shape
from slipctl.view.chunks import lasting
from slipctl.view.colours import Rgb, darker

WHEEL_RADIUS = 0.0825  # m, Table II of Ryu & Agrawal; used where the plant does not say
HALF_TRACK = 0.1624  # m, likewise
AXLE_ALONG_Y = (np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)  # w, x, y, z: turns a cylinder's axis from z to y


def disc_robot(wheel_radius: float = WHEEL_RADIUS, half_track: float = HALF_TRACK) -> list[Shape]:
    """Return a round robot with two spoked wheels and a mark that points ahead.

    Parameters
    ----------
    wheel_radius, half_track : float
        [m].

    Returns
    -------
    list of Shape
        Bodies ``base``, ``left_wheel`` and ``right_wheel``; the body's origin is the axle midpoint.
    """
    width = 0.04
    reach = half_track - 0.75 * width  # the wheels stand out, so that one sees them turn
    ahead = [0.62 * reach, 0.0, 0.107]
    shapes = [
        _shape("base", "cylinder", [reach, 0.05, 0.0], [0.0, 0.0, 0.05], (0.8, 0.2, 0.2, 1.0)),
        _shape("base", "box", [0.30 * reach, 0.02, 0.008], ahead, (0.95, 0.95, 0.95, 1.0)),
    ]
    for body in ("left_wheel", "right_wheel"):
        tyre, spoke = (0.12, 0.12, 0.12, 1.0), (0.9, 0.9, 0.9, 1.0)
        size = [wheel_radius, width / 2, 0.0]
        shapes.append(_shape(body, "cylinder", size, [0.0, 0.0, 0.0], tyre, AXLE_ALONG_Y))
        size = [0.9 * wheel_radius, width / 2 + 0.003, 0.008]
        shapes.append(_shape(body, "box", size, [0.0, 0.0, 0.0], spoke))
    return shapes


def log_shapes(rec: rr.RecordingStream, parent: str, shapes: Sequence[Shape], body: str, colour: Rgb) -> None:
    """Write the shapes of one body as static entities below `parent`.

    Shapes that the model paints in a colour take the colour of the run and black parts of the base a dark
    shade of it; the rest stays: black tyres, white spokes. Kinds that have no picture (planes, meshes) are
    left out.
    """
    chunks = []
    for number, shape in enumerate(shape for shape in shapes if shape.body == body):
        drawn = _archetype(shape, _tint(shape, colour))
        if drawn is not None:
            build, fields = drawn
            chunks.append(lasting(f"{parent}/shape_{number}", build, **fields))
    rec.send_chunks(chunks)


def xyzw(quaternion: Any) -> np.ndarray:
    """Return quaternions (…, 4) in Rerun's order x, y, z, w from MuJoCo's w, x, y, z."""
    return np.roll(np.asarray(quaternion, dtype=np.float64), -1, axis=-1)


def _shape(
    body: str,
    kind: str,
    size: list[float],
    position: list[float],
    rgba: tuple,
    quaternion: tuple = (1, 0, 0, 0),
) -> Shape:
    numbers = [np.array(values, dtype=np.float64) for values in (size, position, quaternion, rgba)]
    return Shape(body, kind, numbers[0], numbers[1], numbers[2], numbers[3])


def _tint(shape: Shape, colour: Rgb) -> Rgb:
    red, green, blue = (float(part) for part in shape.rgba[:3])
    value = max(red, green, blue)
    if value - min(red, green, blue) >= 0.15:
        return colour
    if shape.body == "base" and value < 0.3:
        return darker(colour, 0.6)  # seen from above, too, one knows whose robot it is
    return round(255 * red), round(255 * green), round(255 * blue)


def _archetype(shape: Shape, colour: Rgb) -> tuple[Callable[..., rr.AsComponents], dict[str, Any]] | None:
    """Translate one shape; sizes are half lengths and radii as in MJCF, Rerun wants whole lengths."""
    size = tuple(float(part) for part in shape.size)
    pose: dict[str, Any] = {
        "quaternions": (tuple(xyzw(shape.quaternion).tolist()),),
        "colors": (colour,),
        "fill_mode": "solid",
    }
    middle = np.asarray(shape.position, dtype=np.float64)
    center = (tuple(middle.tolist()),)
    match shape.kind:
        case "box":
            return rr.Boxes3D, {"half_sizes": (size,), "centers": center, **pose}
        case "cylinder":
            return rr.Cylinders3D, {"lengths": (2 * size[1],), "radii": (size[0],), "centers": center, **pose}
        case "sphere":
            return rr.Ellipsoids3D, {"radii": (size[0],), "centers": center, **pose}
        case "ellipsoid":
            return rr.Ellipsoids3D, {"half_sizes": (size,), "centers": center, **pose}
        case "capsule":
            # Rerun's capsule grows from its origin along z, MuJoCo's is centred
            start = middle - _rotate(shape.quaternion, np.array([0.0, 0.0, size[1]]))
            pose["translations"] = (tuple(start.tolist()),)
            return rr.Capsules3D, {"lengths": (2 * size[1],), "radii": (size[0],), **pose}
    return None


def _rotate(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    scalar, axis = float(quaternion[0]), np.asarray(quaternion[1:], dtype=np.float64)
    twice = 2 * np.cross(axis, vector)
    return vector + scalar * twice + np.cross(axis, twice)
