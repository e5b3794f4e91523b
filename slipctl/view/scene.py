"""The moving part of the 3D views: robots, trails, reference and arrows, at no more than 50 rows a second."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import rerun as rr

from slipctl.shape import Shape
from slipctl.view.chunks import lasting, strips
from slipctl.view.colours import REFERENCE, ROBUST_INPUT, Rgb, lighter
from slipctl.view.framing import scene_box
from slipctl.view.ground import lift, log_ground, log_pushes, log_terrain
from slipctl.view.robot import HALF_TRACK, WHEEL_RADIUS, disc_robot, log_shapes, xyzw
from slipctl.view.tracks import SCENE_RATE, TRAIL_PIECES, Array, Track, kept, nanoseconds, nice, stride

ARROW = 0.5  # m, the length that the 95 % quantile of a vector gets at most
GRIPS: Rgb = (0x56, 0xB4, 0xE9)
SLIDES: Rgb = (0xF0, 0xE4, 0x42)
GRID = 0.5  # m
FLOOR: Rgb = (0x22, 0x26, 0x2B)
LINES: Rgb = (0x4A, 0x50, 0x57)
NESTING = 0.06  # share by which each further robot is drawn slimmer: coinciding robots all show
ABOVE_FLOOR = 0.004  # m, so that lines and floor do not flicker


@dataclass(frozen=True)
class Scales:
    """Lengths of the arrows, the same for every run of a world so that they can be compared.

    Attributes
    ----------
    slip : float
        Metres of arrow per m/s of slip velocity.
    traction : float or None
        Newtons per metre of arrow; None where there are no forces.
    """

    slip: float
    traction: float | None


def choose_scales(tracks: Sequence[Track]) -> Scales:
    """Choose round scales so that the arrow of the 95 % quantile is at most 0.5 m long."""
    slips = [
        np.hypot(track.values("slip.longitudinal"), track.values("slip.lateral"))
        for track in tracks
        if track.has("slip.longitudinal", "slip.lateral")
    ]
    forces = [
        np.hypot(
            track.values(f"wheel.longitudinal_force.{side}"), track.values(f"wheel.lateral_force.{side}")
        )
        for track in tracks
        for side in ("left", "right")
        if track.has(*_force_columns(side))
    ]
    slip = nice(np.clip(ARROW / max(_quantile(slips), 1e-9), 0.05, 20.0))
    traction = None if not forces else 1 / nice(np.clip(ARROW / max(_quantile(forces), 1e-9), 1e-4, 0.2))
    return Scales(slip, traction)


def log_world(rec: rr.RecordingStream, tracks: Sequence[Track], info: Mapping[str, Any]) -> None:
    """Write what all runs share: the axes, the reference path and the moving reference."""
    rec.log("/", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True, strict=True)
    low, high = scene_box(tracks)
    low, high = (np.floor((low - 1) / GRID) * GRID, np.ceil((high + 1) / GRID) * GRID)
    if info.get("terrain") is not None:
        log_terrain(rec, info, low, high)
    else:
        _log_level_floor(rec, low, high)
    log_ground(rec, info, low, high)
    if info.get("slope_deg"):
        angle = np.radians(float(info.get("downhill_deg") or 0.0))
        start = [*((low + high) / 2 - 0.4 * (high - low) * [np.cos(angle), np.sin(angle)]), 0.02]
        arrow = rr.Arrows3D(
            origins=[start],
            vectors=[[0.5 * np.cos(angle), 0.5 * np.sin(angle), 0.0]],
            colors=[lighter(REFERENCE)],
            radii=[0.008],
            labels=[f"downhill {info['slope_deg']:g}°"],
            show_labels=True,
        )
        rec.log("/ground/downhill", arrow, static=True, strict=True)
    planners = [track for track in tracks if track.has("reference.position.x", "reference.position.y")]
    if not planners:
        return
    longest = max(planners, key=lambda track: track.time[-1])
    rows = kept(longest.time, stride(longest.time, SCENE_RATE))
    planned = longest.pair("reference.position")[rows]
    path = _at_height(planned, ABOVE_FLOOR + lift(info, planned))
    line = rr.LineStrips3D([path], colors=[REFERENCE], radii=[0.006])
    rec.log("/reference/path", line, static=True, strict=True)
    rec.send_columns(
        "/reference/target",
        [rr.TimeColumn("sim_time", duration=nanoseconds(longest.time[rows]))],
        rr.Transform3D.columns(translation=path),
        strict=True,
    )
    pole: dict[str, Any] = {"strips": (((0.0, 0.0, 0.0), (0.0, 0.0, 0.42)),), "radii": (0.004,)}
    rec.send_chunks(lasting("/reference/target/pole", rr.LineStrips3D, **pole, colors=(REFERENCE,)))
    top: dict[str, Any] = {"positions": ((0.0, 0.0, 0.42),), "radii": (0.018,)}
    rec.send_chunks(lasting("/reference/target/top", rr.Points3D, **top, colors=(lighter(REFERENCE),)))


def _log_level_floor(rec: rr.RecordingStream, low: Array, high: Array) -> None:
    floor = rr.Boxes3D(mins=[[*low, -0.02]], sizes=[[*(high - low), 0.02]], colors=[FLOOR], fill_mode="solid")
    rec.log("/ground/floor", floor, static=True, strict=True)
    along_y = [[[x, low[1], 0.001], [x, high[1], 0.001]] for x in np.arange(low[0], high[0] + GRID / 2, GRID)]
    along_x = [[[low[0], y, 0.001], [high[0], y, 0.001]] for y in np.arange(low[1], high[1] + GRID / 2, GRID)]
    lines = rr.LineStrips3D(np.array(along_y + along_x), colors=[LINES], radii=rr.Radius.ui_points([0.6]))
    rec.log("/ground/grid", lines, static=True, strict=True)


def log_run(
    rec: rr.RecordingStream,
    root: str,
    track: Track,
    colour: Rgb,
    shapes: Sequence[Shape] | None,
    info: Mapping[str, Any],
    scales: Scales,
    order: int,
) -> None:
    """Write one robot: its bodies, its trail and its arrows.

    Parameters
    ----------
    root : str
        Entity of the run, ``/runs/<label>``.
    order : int
        Place among the runs of the world; trails and labels of later ones lie a little higher.
    """
    radius = float(info.get("wheel_radius") or WHEEL_RADIUS)
    half_track = float(info.get("half_track") or HALF_TRACK)
    positions = track.pair("motion.position")
    height = track.values("body.height") if track.has("body.height") else np.full(len(positions), radius)
    pose = np.concatenate([positions, height[:, None], _quaternions(track)], axis=1)
    rows = kept(track.time, stride(track.time, SCENE_RATE))
    rows = rows[np.all(np.isfinite(pose[rows]), axis=1)]  # a diverged robot stays where it was last seen
    if len(rows) == 0:
        return
    times = [rr.TimeColumn("sim_time", duration=nanoseconds(track.time[rows]))]
    base = f"{root}/robot/base"
    rec.send_columns(
        base,
        times,
        rr.Transform3D.columns(translation=pose[rows, :3], quaternion=xyzw(pose[rows, 3:])),
        strict=True,
    )
    shapes = disc_robot(radius, half_track) if shapes is None else shapes
    slim = 1 - NESTING * order
    fit: dict[str, Any] = {"scale": (slim, slim, 1.0), "translation": (0.0, 0.0, 0.003 * order)}
    rec.send_chunks(lasting(f"{base}/body", rr.Transform3D, **fit))
    log_shapes(rec, f"{base}/body", shapes, "base", colour)
    for place, (side, sign) in enumerate((("left", 1), ("right", -1))):
        wheel = f"{base}/{side}_wheel"
        angle = _wheel_angles(track)[rows, place]
        axle = np.array([0.0, sign * half_track, 0.0])
        rec.send_columns(
            wheel,
            times,
            rr.Transform3D.columns(
                translation=np.tile(axle, (len(rows), 1)),
                quaternion=np.stack([0 * angle, np.sin(angle / 2), 0 * angle, np.cos(angle / 2)], axis=1),
            ),
            strict=True,
        )
        log_shapes(rec, wheel, shapes, f"{side}_wheel", colour)
    _log_label(rec, base, track, colour, order)
    floor = ABOVE_FLOOR * (2 + order) + lift(info, positions[rows])
    _log_trail(rec, f"{root}/trail", track, _at_height(positions[rows], floor), rows, colour, order)
    _log_arrows(rec, base, track, rows, scales, half_track, -pose[rows, 2])
    log_pushes(rec, root, track, rows, info)


def _log_label(rec: rr.RecordingStream, base: str, track: Track, colour: Rgb, order: int) -> None:
    """Write a name above the robot that says how the run ended, once it has."""
    names, at = [track.name], [float(track.time[0])]
    if track.info.status != "completed":
        names.append(f"{track.name}: {track.info.status.replace('_', ' ')}")
        at.append(float(track.info.end_time if track.info.end_time is not None else track.time[-1]))
    label = f"{base}/label"
    above: dict[str, Any] = {"positions": ((0.0, 0.0, 0.26 + 0.09 * order),), "radii": (0.006,)}
    rec.send_chunks(lasting(label, rr.Points3D.from_fields, **above, colors=(colour,), show_labels=True))
    times = [rr.TimeColumn("sim_time", duration=nanoseconds(np.array(at)))]
    rec.send_columns(label, times, rr.Points3D.columns(labels=names), strict=True)


def _log_trail(
    rec: rr.RecordingStream, trail: str, track: Track, ground: Array, rows: Any, colour: Rgb, order: int
) -> None:
    """Write a trail that grows: each row is the piece since the row before, the view shows all until now."""
    ends = np.unique(np.linspace(0, len(rows) - 1, min(TRAIL_PIECES, len(rows))).round().astype(int))[1:]
    if len(ends) == 0:
        return
    starts = np.concatenate([[0], ends[:-1]])
    pieces = [np.arange(first, last + 1) for first, last in zip(starts, ends, strict=True)]
    radius = max(0.011 - 0.004 * order, 0.003)
    rec.send_chunks(lasting(trail, rr.LineStrips3D.from_fields, colors=(colour,), radii=(radius,)))
    times = [rr.TimeColumn("sim_time", duration=nanoseconds(track.time[rows[ends]]))]
    lines = strips(ground[np.concatenate(pieces)], ends - starts + 1)
    column = rr.ComponentColumn(rr.LineStrips3D.descriptor_strips(), lines)
    rec.send_columns(trail, times, [column], strict=True)


def _log_arrows(
    rec: rr.RecordingStream,
    base: str,
    track: Track,
    rows: Any,
    scales: Scales,
    half_track: float,
    floor: Array,
) -> None:
    times = [rr.TimeColumn("sim_time", duration=nanoseconds(track.time[rows]))]
    if track.has("slip.longitudinal", "slip.lateral"):
        slip = np.stack([track.values("slip.longitudinal"), -track.values("slip.lateral")], axis=1)[rows]
        arrow = f"{base}/arrows/slip"
        style: dict[str, Any] = {"origins": ((0.0, 0.0, 0.22),), "colors": (ROBUST_INPUT,), "radii": (0.012,)}
        rec.send_chunks(lasting(arrow, rr.Arrows3D.from_fields, **style))
        vectors = _at_height(np.nan_to_num(slip) * scales.slip, 0.0)
        rec.send_columns(arrow, times, rr.Arrows3D.columns(vectors=vectors), strict=True)
    for side, sign in (("left", 1), ("right", -1)):
        if scales.traction is None or not track.has(*_force_columns(side)):
            continue
        force = np.stack([track.values(name) for name in _force_columns(side)], axis=1)[rows]
        arrow = f"{base}/arrows/traction_{side}"
        rec.send_chunks(lasting(arrow, rr.Arrows3D.from_fields, radii=(0.010,)))
        origins = np.stack([0 * floor, 0 * floor + sign * (half_track + 0.05), floor + 0.015], axis=1)
        vectors = _at_height(np.nan_to_num(force) / scales.traction, 0.0)
        name = f"wheel.sliding.{side}"
        slides = track.values(name)[rows] > 0 if track.has(name) else np.zeros(len(rows), dtype=bool)
        colours = np.where(slides[:, None], SLIDES, GRIPS).astype(np.uint8)
        columns = rr.Arrows3D.columns(vectors=vectors, origins=origins, colors=colours)
        rec.send_columns(arrow, times, columns, strict=True)


def _force_columns(side: str) -> tuple[str, str]:
    return f"wheel.longitudinal_force.{side}", f"wheel.lateral_force.{side}"


def _quaternions(track: Track) -> Array:
    """Orientation w, x, y, z (T, 4); from the heading where the plant is flat."""
    names = [f"body.quaternion.{part}" for part in "wxyz"]
    if track.has(*names):
        return np.stack([track.values(name) for name in names], axis=1)
    half = track.values("motion.heading") / 2
    return np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=1)


def _wheel_angles(track: Track) -> Array:
    """Angles left, right (T, 2) [rad]; a plant without them gets the sum of its wheel rates."""
    if track.has("wheel.angle.left", "wheel.angle.right"):
        return np.nan_to_num(track.pair("wheel.angle", ("left", "right")))
    if not track.has("wheel.rate.left", "wheel.rate.right"):
        return np.zeros((len(track.time), 2))
    rates = np.nan_to_num(track.pair("wheel.rate", ("left", "right")))
    turned = np.cumsum(rates[:-1] * np.diff(track.time)[:, None], axis=0)
    return np.concatenate([np.zeros((1, 2)), turned])


def _at_height(points: Array, height: float | Array) -> Array:
    return np.column_stack([points, np.broadcast_to(height, len(points))])


def _quantile(parts: list[Array]) -> float:
    values = np.concatenate(parts) if parts else np.zeros(0)
    values = values[np.isfinite(values)]
    return float(np.quantile(values, 0.95)) if len(values) else 0.0
