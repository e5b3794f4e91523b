"""The floor that is not the same everywhere or always, and pushes: drawn, told of, listed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from slipctl.plants.terrain import Terrain
from slipctl.view.colours import Rgb
from slipctl.view.events import Event
from slipctl.view.tracks import Array, Track, nanoseconds

ICE: Rgb = (0xD6, 0xEE, 0xF8)
RUBBER: Rgb = (0x6B, 0x52, 0x3C)
WATER: Rgb = (0x2F, 0x7F, 0xC8)
PUSH: Rgb = (0xF2, 0x5C, 0x54)
GRIPS = 0.8  # friction from which a patch is drawn as rubber (assumed)
LONGEST_PUSH = 0.6  # m, of the arrow of the strongest push
PUSH_HEIGHT = 0.10  # m, about that of a centre of mass
LAYER = 0.0006  # m between patches that overlap, so that the later one shows
CORNERS = 48  # of a disc
MOST_STRIPES = 200
MOST_STEPS = 220  # of the terrain's mesh along the longer side of the scene
LOWEST: Rgb = (0x16, 0x1A, 0x1F)
HIGHEST: Rgb = (0x5C, 0x64, 0x6E)


def log_ground(rec: rr.RecordingStream, info: Mapping[str, Any], low: Array, high: Array) -> None:
    """Write the patches, and the floor's changes, between two corners (2,) of the scene [m]."""
    for index, patch in enumerate(info.get("patches") or ()):
        outlines = [outline for outline in outlines_of(patch, low, high) if len(outline) >= 3]
        if not outlines:
            continue
        height = lift(info, np.array([outline.mean(axis=0) for outline in outlines]))
        points, triangles, middles = [], [], []
        for outline in outlines:
            first = len(points)
            points += [[x, y, 0.002 + LAYER * index] for x, y in outline.tolist()]
            triangles += [[first, first + k, first + k + 1] for k in range(1, len(outline) - 1)]
            middles.append(outline.mean(axis=0))
        colour = colour_of(patch.get("friction"), patch.get("film"))
        mesh = rr.Mesh3D(
            vertex_positions=points,
            triangle_indices=triangles,
            vertex_normals=[[0.0, 0.0, 1.0]] * len(points),
            vertex_colors=[colour] * len(points),
        )
        if info.get("terrain") is None:  # else the terrain itself has the patch's colour
            rec.log(f"/ground/patches/{index}", mesh, static=True, strict=True)
        text = _surface(patch.get("friction"), patch.get("film"))
        label = rr.Points3D(
            [[*middles[len(middles) // 2], 0.004 + height[len(middles) // 2]]],
            radii=[0.004],
            colors=[colour],
            labels=[text],
            show_labels=True,
        )
        rec.log(f"/ground/patches/{index}/label", label, static=True, strict=True)
    changes = info.get("changes") or ()
    if changes:
        _log_changes(rec, info, low, high)


def _log_changes(rec: rr.RecordingStream, info: Mapping[str, Any], low: Array, high: Array) -> None:
    """Write a thin layer on the floor whose colour and label say what the floor is now."""
    states = [(0.0, info.get("friction"), info.get("film")), *_states(info)]
    middle, half = (low + high) / 2, (high - low) / 2
    layer = rr.Boxes3D.from_fields(
        centers=[[*middle, 0.0004]], half_sizes=[[*half, 0.0004]], fill_mode="solid", show_labels=True
    )
    rec.log("/ground/state", layer, static=True, strict=True)
    times = rr.TimeColumn("sim_time", duration=nanoseconds(np.array([time for time, _, _ in states])))
    colours = np.array([colour_of(friction, film, 0.35) for _, friction, film in states], dtype=np.uint8)
    labels = [_surface(friction, film) for _, friction, film in states]
    columns = rr.Boxes3D.columns(colors=colours, labels=labels)
    rec.send_columns("/ground/state", [times], columns, strict=True)


def lift(info: Mapping[str, Any], points: Array) -> Array:
    """Return the height (n,) of the floor under points (n, 2) [m]; 0 where it is level."""
    told = info.get("terrain")
    if told is None:
        return np.zeros(len(points))
    parts = (np.array(told[name], dtype=np.float64)[None] for name in ("amplitude", "wave_vector", "phase"))
    return Terrain(*parts).relief(np.nan_to_num(points)[None])[0][0]


def log_terrain(rec: rr.RecordingStream, info: Mapping[str, Any], low: Array, high: Array) -> None:
    """Write the uneven floor between two corners (2,) of the scene [m], patches in their colours."""
    longest = float(np.max(high - low))
    waves = np.array(info["terrain"]["wave_vector"], dtype=np.float64)
    step = max(1.0 / (16.0 * float(np.max(np.hypot(waves[:, 0], waves[:, 1])))), longest / MOST_STEPS)
    xs, ys = np.arange(low[0], high[0] + step, step), np.arange(low[1], high[1] + step, step)
    x, y = (grid.ravel() for grid in np.meshgrid(xs, ys, indexing="ij"))
    flat = np.stack([x, y], axis=1)
    height = lift(info, flat)
    top = max(float(np.max(np.abs(height))), 1e-9)
    bare = np.array(LOWEST) + (0.5 + 0.5 * height / top)[:, None] * (np.array(HIGHEST) - np.array(LOWEST))
    for patch in info.get("patches") or ():
        for outline in outlines_of(patch, low, high):
            bare[_inside(flat, outline)] = colour_of(patch.get("friction"), patch.get("film"))
    corner = (np.arange(len(xs) - 1)[:, None] * len(ys) + np.arange(len(ys) - 1)).ravel()
    right, up = corner + len(ys), corner + 1
    mesh = rr.Mesh3D(
        vertex_positions=np.column_stack([flat, height]),
        triangle_indices=np.concatenate(
            [np.stack([corner, right, right + 1], axis=1), np.stack([corner, right + 1, up], axis=1)]
        ),
        vertex_colors=np.round(bare).astype(np.uint8),
    )
    rec.log("/ground/terrain", mesh, static=True, strict=True)


def _inside(points: Array, outline: Array) -> NDArray[np.bool_]:
    """Return which points (n, 2) lie in a convex outline, counter-clockwise."""
    inside = np.full(len(points), len(outline) >= 3)
    for here, there in zip(outline, np.roll(outline, -1, axis=0), strict=True):
        side, way = there - here, points - here
        inside &= side[0] * way[:, 1] - side[1] * way[:, 0] >= 0
    return inside


def log_pushes(rec: rr.RecordingStream, root: str, track: Track, rows: Any, info: Mapping[str, Any]) -> None:
    """Write an arrow that pushes the robot while a push lasts; its length says how hard.

    Parameters
    ----------
    root : str
        Entity of the run.
    track : Track
    rows : int array
        Rows of the track that the scene keeps.
    info : mapping
    """
    pushes = info.get("pushes") or ()
    strongest = max((push["force"] for push in pushes), default=0.0)
    times, at = track.time[rows], track.pair("motion.position")[rows]
    for index, push in enumerate(pushes):
        angle = np.radians(push["heading_deg"])
        length = LONGEST_PUSH * push["force"] / strongest
        vector = length * np.array([np.cos(angle), np.sin(angle), 0.0])
        acts = (times >= push["start"]) & (times < push["start"] + push["duration"])
        if not acts.any():
            continue
        first = int(np.argmax(acts))
        last = len(acts) - int(np.argmax(acts[::-1]))
        shown = slice(first, min(last + 1, len(times)))  # the row after the push takes the arrow away
        begins = np.concatenate([at[shown][acts[shown]], np.full((int(acts.sum()), 1), PUSH_HEIGHT)], axis=1)
        style = rr.Arrows3D.from_fields(
            colors=[PUSH], radii=[0.014], labels=[f"{push['force']:g} N"], show_labels=True
        )
        entity = f"{root}/push/{index}"
        rec.log(entity, style, static=True, strict=True)
        columns = rr.Arrows3D.columns(
            vectors=np.tile(vector, (len(begins), 1)), origins=begins - vector
        ).partition(acts[shown].astype(int))
        rec.send_columns(
            entity, [rr.TimeColumn("sim_time", duration=nanoseconds(times[shown]))], columns, strict=True
        )


def outlines_of(patch: Mapping[str, Any], low: Array, high: Array) -> list[Array]:
    """Return the outlines (n, 2) of a patch's parts, counter-clockwise; stripes as far as the scene goes."""
    middle = np.array([patch["x"], patch["y"]])
    if patch["kind"] == "disc":
        angles = np.linspace(0.0, 2.0 * np.pi, CORNERS, endpoint=False)
        return [middle + patch["radius"] * np.stack([np.cos(angles), np.sin(angles)], axis=1)]
    angle = np.radians(patch["heading_deg"])
    along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    if patch["kind"] == "rectangle":
        signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
        return [middle + patch["length"] * signs[:, :1] * along + patch["width"] * signs[:, 1:] * across]
    box = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    reach = np.sum((box - middle) * along, axis=1) / patch["period"]
    first, last = int(np.floor(reach.min())), int(np.ceil(reach.max()))
    if patch.get("count") is not None:
        first, last = max(first, 0), min(last, patch["count"] - 1)
    parts = []
    for order in range(first, min(last, first + MOST_STRIPES) + 1):
        line = middle + order * patch["period"] * along
        part = _cut(
            _cut(box, line - patch["width"] / 2 * along, along), line + patch["width"] / 2 * along, -along
        )
        parts.append(part)
    return [part for part in parts if len(part)]


def _cut(outline: Array, point: Array, inward: Array) -> Array:
    """Return what of a convex outline lies on the inward side of a line through a point."""
    if len(outline) == 0:
        return outline
    depth = np.sum((outline - point) * inward, axis=1)
    kept: list[Array] = []
    for k in range(len(outline)):
        here, there = depth[k], depth[(k + 1) % len(outline)]
        if here >= 0:
            kept.append(outline[k])
        if (here >= 0) != (there >= 0):
            kept.append(outline[k] + here / (here - there) * (outline[(k + 1) % len(outline)] - outline[k]))
    return np.array(kept).reshape(-1, 2)


def colour_of(friction: float | None, film: float | None, dimmed: float = 1.0) -> Rgb:
    """Return the colour of a surface: ice is pale, rubber brown, a film blue."""
    share = min(max(float(friction or 0.0) / GRIPS, 0.0), 1.0)
    light, dark = np.array(ICE), np.array(RUBBER)
    colour = np.array(WATER) if film is not None else light + share * (dark - light)
    red, green, blue = (int(value) for value in np.round(dimmed * colour))
    return red, green, blue


def floor_events(info: Mapping[str, Any]) -> list[Event]:
    """Return the changes of the floor and the pushes as lines of the event log."""
    found = [Event(push["start"], "INFO", f"push: {_push(push)}") for push in info.get("pushes") or ()] + [
        Event(time, "INFO", f"the floor: {_surface(friction, film)}")
        for time, friction, film in _states(info)
    ]
    return sorted(found, key=lambda event: event.time)


def floor_words(info: Mapping[str, Any]) -> list[str]:
    """Return the lines of the page *Run info* about patches, changes and pushes; empty without any."""
    lines = [
        f"* Patch, {patch['kind']}: {_surface(patch.get('friction'), patch.get('film'))}"
        for patch in info.get("patches") or ()
    ]
    lines += [
        f"* From {time:g} s on beside the patches: {_surface(friction, film)}"
        for time, friction, film in _states(info)
    ]
    lines += [f"* Push from {push['start']:g} s on: {_push(push)}" for push in info.get("pushes") or ()]
    return ["## Floor and pushes", "", *lines, ""] if lines else []


def _push(push: Mapping[str, Any]) -> str:
    return f"{push['force']:g} N towards {push['heading_deg']:g}° for {push['duration']:g} s"


def _states(info: Mapping[str, Any]) -> list[tuple[float, float | None, float | None]]:
    friction, film = info.get("friction"), info.get("film")
    states: list[tuple[float, float | None, float | None]] = []
    changes: Sequence[Mapping[str, Any]] = info.get("changes") or ()
    for change in changes:
        friction = friction if change.get("friction") is None else change["friction"]
        film = film if change.get("film") is None else change["film"]
        film = None if change.get("dry") else film
        states.append((float(change["time"]), friction, film))
    return states


def _surface(friction: float | None, film: float | None) -> str:
    text = "friction as before" if friction is None else f"μ {friction:g}"
    return text if film is None else f"{text}, film {film:g} N·s/m"
