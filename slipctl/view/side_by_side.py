"""A recording of one world as it is and as it was: both in one scene and in shared plots, the old in grey."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr
import rerun.blueprint as rrb
from rerun.recording_stream import is_enabled as is_recording_enabled

from slipctl.shape import Shape
from slipctl.view.colours import Rgb, run_colours
from slipctl.view.content import RecordingError, RunInfo, application_id, recording_id, recording_name
from slipctl.view.framing import axis_range
from slipctl.view.layout import scene_view
from slipctl.view.plots import entity
from slipctl.view.recording import new_stream, put, strict
from slipctl.view.scene import choose_scales, log_run, log_world
from slipctl.view.tracks import Array, Track, nanoseconds, read_tracks
from slipctl.view.views import LEGEND, TIMES, column

BASELINE: Rgb = (0xD8, 0xD8, 0xD8)
"""Lighter than the reference, which is grey as well."""

TINT = 0.25
"""Share of the run's colour in the grey of its baseline, where there are several baselines."""

HEADROOM = 0.45
"""Share of an axis left free above the lines: the legend lies there."""

ENDING = "against-baseline"
PLOTTED = {"error.position": "Position error [m]", "error.cross_track": "Cross-track error [m]"}
DISTANCE = "against_baseline.distance"


@dataclass(frozen=True)
class Pair:
    """A run and its baseline.

    Attributes
    ----------
    now, before : Track
        The second has only the columns that baselines keep, and rows wide apart.
    distance : (T,) array
        Between the two robots at the times of `before` [m]; NaN where one of them has ended.
    """

    now: Track
    before: Track
    distance: Array


def write(
    path: Path,
    signals: pa.Table,
    runs: Sequence[RunInfo],
    baselines: Mapping[str, pa.Table],
    info: Mapping[str, Any],
    page: str,
    shapes: Sequence[Shape] | None = None,
) -> Path:
    """Write some runs of one world beside their baselines.

    Parameters
    ----------
    path : Path
        The ``.rrd`` to write; replaced if it exists.
    signals : pyarrow.Table
        As for `slipctl.view.recording.write`.
    runs : sequence of RunInfo
        The runs as they are now.
    baselines : mapping of str to pyarrow.Table
        Label to where the robot was: columns ``time``, ``motion.position.x``, ``motion.position.y``,
        ``motion.heading``, ``error.position`` and ``error.cross_track``.
    info : mapping
        As for `slipctl.view.recording.write`.
    page : str
        Markdown of what differs, shown beside the scene.
    shapes : sequence of Shape or None
        The robot's shapes; None = a plain disc robot.

    Returns
    -------
    Path
        `path`.

    Raises
    ------
    RecordingError
        A run has no baseline or no rows, or the file cannot be written.
    """
    pairs = [_pair(track, baselines.get(track.info.label)) for track in read_tracks(signals, runs)]
    with strict():
        content = _encode(pairs, info, page, shapes)
    return put(path, content)


def _pair(now: Track, table: pa.Table | None) -> Pair:
    label = now.info.label
    if table is None or len(table) == 0:
        raise RecordingError(f"there is no track of the baseline of {label}")
    missing = [name for name in ("time", *POSITION, "motion.heading") if name not in table.column_names]
    if missing:
        raise RecordingError(f"the baseline's track of {label} lacks the columns {', '.join(missing)}")
    # single precision is kept on disk: the ticks that it meant come back
    time = np.round(table["time"].cast(pa.float64()).to_numpy(), 6)
    name = f"{now.name} baseline"
    info = RunInfo(run=now.info.run, label=label, status="completed", end_time=float(time[-1]))
    before = Track(info, name, table, time, now.units)
    here, there = now.pair("motion.position"), before.pair("motion.position")
    apart = [np.interp(time, now.time, here[:, axis]) - there[:, axis] for axis in (0, 1)]
    distance = np.where(time <= now.time[-1] + 1e-9, np.hypot(*apart), np.nan)
    return Pair(now, before, distance)


POSITION = ("motion.position.x", "motion.position.y")


def _encode(
    pairs: Sequence[Pair], info: Mapping[str, Any], page: str, shapes: Sequence[Shape] | None
) -> bytes:
    colours = run_colours([pair.now.info for pair in pairs])
    both = [part for pair in pairs for part in (pair.before, pair.now)]
    with new_stream(f"{application_id(info)}-{ENDING}", f"{recording_id(info)}-{ENDING}") as rec:
        if not is_recording_enabled(rec):
            return b""
        memory = rec.memory_recording()
        rec.send_blueprint(_blueprint(pairs), make_active=False, make_default=True)
        # the viewer shows only the beginning of a name
        rec.send_recording_name(f"vs baseline: {recording_name(info)}")
        log_world(rec, both, info)
        scales = choose_scales([pair.now for pair in pairs])
        for place, pair in enumerate(pairs):
            label = pair.now.info.label
            colour, old = colours[label], _grey(colours[label], len(pairs))
            log_run(rec, _root("baseline", label), pair.before, old, shapes, info, scales, place)
            log_run(rec, _root("runs", label), pair.now, colour, shapes, info, scales, len(pairs) + place)
        for plot in _plots(pairs):
            for curve in plot.curves:
                label = curve.pair.now.info.label
                colour = _grey(colours[label], len(pairs)) if curve.old else colours[label]
                _log(rec, curve, colour)
        rec.log("/info/summary", rr.TextDocument(page, media_type="text/markdown"), static=True, strict=True)
        return memory.drain_as_bytes()


@dataclass(frozen=True)
class Curve:
    """One line of a plot: where it is written, its name in the legend, its times [s] and its values."""

    pair: Pair
    path: str
    name: str
    time: Array
    values: Array
    old: bool = False


@dataclass(frozen=True)
class Plot:
    """One plot: its title with the unit, and its lines, the old ones first so that they lie below."""

    title: str
    curves: tuple[Curve, ...]


def _plots(pairs: Sequence[Pair]) -> list[Plot]:
    sides = [(pair, pair.before, "baseline") for pair in pairs] + [(pair, pair.now, "runs") for pair in pairs]
    plots = []
    for name, title in PLOTTED.items():
        parts = [(pair, stem, track) for pair, track, stem in sides if track.has(name)]
        curves = [_curve(pair, stem, name, track, track.values(name)) for pair, stem, track in parts]
        plots.append((title, curves))
    names = {pair.now.info.label: replace(pair.before, name=pair.now.name) for pair in pairs}
    apart = [_curve(pair, "runs", DISTANCE, names[pair.now.info.label], pair.distance) for pair in pairs]
    plots.append(("Distance from where the baseline was [m]", apart))
    drawn = [(title, tuple(curve for curve in curves if len(curve.time))) for title, curves in plots]
    return [Plot(title, curves) for title, curves in drawn if curves]


def _curve(pair: Pair, stem: str, name: str, track: Track, values: Array) -> Curve:
    finite = np.isfinite(values)
    path = entity(_root(stem, pair.now.info.label), name)
    return Curve(pair, path, track.name, track.time[finite], values[finite], old=stem == "baseline")


def _log(rec: rr.RecordingStream, curve: Curve, colour: Rgb) -> None:
    style = rr.SeriesLines(colors=[colour], widths=[4.0 if curve.old else 1.5], names=[curve.name])
    rec.log(curve.path, style, static=True, strict=True)
    times = rr.TimeColumn("sim_time", duration=nanoseconds(curve.time))
    rec.send_columns(curve.path, [times], rr.Scalars.columns(scalars=curve.values), strict=True)


def _root(stem: str, label: str) -> str:
    return f"/{stem}/{rr.escape_entity_path_part(label)}"


def _grey(colour: Rgb, count: int) -> Rgb:
    """Return the colour of a baseline: grey, with a touch of its run's colour where there are several."""
    share = 0.0 if count == 1 else TINT
    red, green, blue = (
        round((1.0 - share) * grey + share * part) for grey, part in zip(BASELINE, colour, strict=True)
    )
    return red, green, blue


def _view(plot: Plot) -> rrb.TimeSeriesView:
    """Show a plot with room above its lines, where the legend is."""
    series = [(curve.time, curve.values) for curve in plot.curves]
    limits, title = axis_range(series), plot.title
    if limits is not None:
        title += " · axis without the first transient"
    else:
        low = min(0.0, *(float(values.min()) for _, values in series))
        high = max(0.0, *(float(values.max()) for _, values in series))
        limits = (low - 0.05 * (high - low), high + HEADROOM * (high - low)) if high > low else None
    return rrb.TimeSeriesView(
        contents=[f"+ {curve.path}" for curve in plot.curves],
        name=title,
        axis_x=TIMES,
        axis_y=rrb.ScalarAxis(range=limits) if limits else None,
        plot_legend=LEGEND,
    )


def _blueprint(pairs: Sequence[Pair]) -> rrb.Blueprint:
    # every track has a label of its own, so that the scene finds its place
    tracks, roots = [], {}
    named = [("baseline", pair.before) for pair in pairs] + [("runs", pair.now) for pair in pairs]
    for stem, track in named:
        label = f"{stem}/{track.info.label}"
        roots[label] = _root(stem, track.info.label)
        tracks.append(replace(track, info=replace(track.info, label=label)))
    compared = rrb.Horizontal(
        scene_view("From above · grid 0.5 m · pale: the baseline", tracks, roots, above=True),
        column(*map(_view, _plots(pairs))),
        column_shares=[1, 1],
        name="Against the baseline",
    )
    scene = rrb.Horizontal(
        scene_view("3D · grid 0.5 m · pale: the baseline", tracks, roots, above=False),
        rrb.TextDocumentView(origin="/info/summary", name="What differs"),
        column_shares=[3, 2],
        name="3D and what differs",
    )
    return rrb.Blueprint(
        rrb.Tabs(compared, scene),
        rrb.BlueprintPanel(state="expanded"),  # the panel that switches between the recordings of a folder
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="sim_time", loop_mode="all"),
        auto_views=False,
        auto_layout=False,
    )
