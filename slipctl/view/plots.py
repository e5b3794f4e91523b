"""Every numeric column as a time series, with its unit in its name, and the few series derived from them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import rerun as rr
from rerun.chunk import Chunk

from slipctl.view.chunks import Clock, lasting, scalars
from slipctl.view.colours import NOMINAL_INPUT, REFERENCE, ROBUST_INPUT, Rgb, darker, lighter
from slipctl.view.theorem import HELD, LANES, quantities
from slipctl.view.tracks import PLOT_RATE, Array, Track, kept, nanoseconds, stride

STATES = {
    # column → entity below the run, word and colour while true, word and colour while false
    "wheel.sliding.left": ("left_wheel", ("slides", 0xD55E00FF), ("grips", 0x3A3F44FF)),
    "wheel.sliding.right": ("right_wheel", ("slides", 0xD55E00FF), ("grips", 0x3A3F44FF)),
    "decision.saturated": ("command", ("saturated", 0xCC79A7FF), ("free", 0x3A3F44FF)),
    "guarantee.held": HELD,
    **LANES,
}


@dataclass(frozen=True)
class Series:
    """Something derived from columns that a plot needs.

    Attributes
    ----------
    path : str
        Below the run, in the manner of a column: ``slip.bound.upper``.
    unit : str
        Unit, or "" where it has none.
    values : (T,) array
        Values at the times of the track.
    """

    path: str
    unit: str
    values: Array


def entity(root: str, column: str) -> str:
    """Return the entity of a column below a run's root: ``error.position`` → ``…/error/position``."""
    return f"{root}/{column.replace('.', '/')}"


def derived(track: Track) -> list[Series]:
    """Return ‖v̂‖ and ‖Δv‖, the slip bound ±α|v| where the controller has one, and those of its theorem."""
    series = []
    for stem in ("decision.nominal_input", "decision.robust_input"):
        if track.has(f"{stem}.x", f"{stem}.y"):
            norm = track.norm(stem)
            if np.any(norm[np.isfinite(norm)] != 0):  # a law without Δv gets no line on the axis
                series.append(Series(f"{stem}.norm", track.units.get(f"{stem}.x", "m/s²"), norm))
    alpha = track.info.slip_bound
    if alpha is not None and track.has("motion.forward_speed"):
        bound = alpha * np.abs(track.values("motion.forward_speed"))
        unit = track.units.get("motion.forward_speed", "m/s")
        series += [Series("slip.bound.upper", unit, bound), Series("slip.bound.lower", unit, -bound)]
    return series + [Series(*quantity) for quantity in quantities(track)]


def columns(track: Track) -> list[str]:
    """Return the columns that become series: all numbers and booleans with at least one value."""
    return [name for name in track.table.column_names if name not in ("run", "time") and track.has(name)]


def log_series(rec: rr.RecordingStream, root: str, track: Track, colour: Rgb, order: int) -> int:
    """Write all series of a run.

    Rows are kept bit for bit: all of them up to 200 Hz, beyond that every n-th and the last.

    Returns
    -------
    int
        The stride n.
    """
    step = stride(track.time, PLOT_RATE)
    every = Clock.of(track.time, kept(track.time, step))
    rec.send_chunks([*_series(root, track, every, colour, order), *_states(root, track)])
    return step


def _series(root: str, track: Track, every: Clock, colour: Rgb, order: int) -> Iterator[Chunk]:
    """Yield the chunks of all series: how each is drawn, then its values in the rows that have one."""
    found = [
        (name, track.units.get(name, ""), track.values(name), track.filled(name)) for name in columns(track)
    ]
    for series in derived(track):
        finite = np.isfinite(series.values)
        found.append((series.path, series.unit, series.values, None if finite.all() else finite))
    clocks: dict[bytes, Clock] = {}  # columns that begin late begin together
    for name, unit, values, filled in found:
        clock = every
        if filled is not None:
            key = filled.tobytes()
            clock = clocks[key] = clocks.get(key) or Clock.of(track.time, every.rows[filled[every.rows]])
        if len(clock.rows) == 0:
            continue
        path, (shade, width) = entity(root, name), _style(name, colour, order)
        held = name.startswith(("decision.", "wheel.rate_command")) or name in STATES
        yield lasting(
            path,
            rr.SeriesLines,
            colors=(shade,),
            widths=(width,),
            names=(series_name(track.name, name, unit),),
            interpolation_mode="StepAfter" if held else "Linear",
        )
        yield scalars(path, clock, values)


def series_name(label: str, column: str, unit: str) -> str:
    """Return the name in the legend: label, column, unit; a group that says nothing new is left out."""
    if column.startswith("guarantee.bound."):
        column = "error.bound"
    if column.startswith("guarantee.size."):
        column = f"error.|{column.rpartition('.')[2]}|"
    group, _, rest = column.partition(".")
    column = rest if group in ("error", "wheel", "decision", "guarantee") else column
    return f"{label} {column} [{unit}]" if unit not in ("", "1") else f"{label} {column}"


def _style(name: str, colour: Rgb, order: int) -> tuple[Rgb | tuple[int, int, int, int], float]:
    """Colour and width of a series; what is commanded or bounds lies wide and pale behind what happens."""
    if name.startswith("reference."):
        return REFERENCE, 3.0
    if name.startswith("decision.nominal_input"):
        return lighter(NOMINAL_INPUT, 0.15 + 0.3 * (order == 0)), 1.5
    if name.startswith("decision.robust_input"):
        return lighter(ROBUST_INPUT, 0.15 * min(order, 3)), 1.5
    if name.startswith(("slip.bound", "guarantee.bound")):
        return lighter(colour, 0.6), 4.0
    if name == "decision.robust_gain":
        return lighter(ROBUST_INPUT, 0.5), 4.0
    if name.startswith("wheel.rate_command"):
        return lighter(colour, 0.7), 1.2  # drawn after the actual rate, which is wider
    if name.startswith("wheel.rate."):
        return colour, 6.0 if order == 0 else 3.5
    if name in ("slip.lateral", "guarantee.size.v_s"):
        return (0xCC, 0x79, 0xA7), 1.5
    if name == "slip.yaw":
        return darker(colour, 0.3), 1.5
    if name.endswith(".right"):
        return lighter(colour, 0.45), 1.5
    return colour, 1.5


def _states(root: str, track: Track) -> Iterator[Chunk]:
    """Yield the chunks of the lanes: the words and colours of each, then its changes."""
    for column, (name, true, false) in STATES.items():
        if not track.has(column):
            continue
        values = track.values(column)
        present = np.isfinite(values)
        time, on = track.time[present], values[present] > 0
        changes = np.flatnonzero(np.concatenate([[True], on[1:] != on[:-1]]))
        path = f"{root}/state/{name.replace(' ', '_')}"
        words = [true[0] if on[change] else false[0] for change in changes]
        both = (true[0], false[0])
        yield lasting(path, rr.StateConfiguration, values=both, labels=both, colors=(true[1], false[1]))
        times = rr.TimeColumn("sim_time", duration=nanoseconds(time[changes]))
        column = rr.ComponentColumn(rr.StateChange.descriptor_state(), rr.components.TextBatch(words))
        yield Chunk.from_columns(path, [times], [column])
