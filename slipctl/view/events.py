"""What happened in a run, as a short log: slip onset, sliding wheels, saturated commands, how it ended."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipctl.guarantee.words import violation
from slipctl.view.theorem import violations
from slipctl.view.tracks import Array, Track

SLIP_ONSET = 0.05  # slip ratio, assumed: far above the creep of a gripping wheel, far below a lost one
MERGE = 0.2  # s, assumed: shorter gaps do not end an episode
MOST = 200  # episodes of one kind; a chattering flag is no story


@dataclass(frozen=True)
class Event:
    """One line of the event log.

    Attributes
    ----------
    time : float
        [s].
    level : str
        ``INFO``, ``WARN`` or ``ERROR``.
    text : str
        What happened.
    """

    time: float
    level: str
    text: str


def events(track: Track) -> list[Event]:
    """Return the events of a run in the order of time."""
    found: list[Event] = []
    label = track.name
    if track.has("slip.ratio"):
        ratio = track.values("slip.ratio")
        for start, end in episodes(track.time, ratio > SLIP_ONSET):
            inside = ratio[(track.time >= start) & (track.time <= end)]
            peak = float(np.nanmax(inside))
            found.append(
                Event(
                    start,
                    "WARN",
                    f"slip onset: ratio above {SLIP_ONSET:.0%}{_for(start, end)}, peak {peak:.0%}",
                )
            )
    for side in ("left", "right"):
        if track.has(f"wheel.sliding.{side}"):
            for start, end in _flag(track, f"wheel.sliding.{side}"):
                found.append(Event(start, "WARN", f"{side} wheel slides{_for(start, end)}"))
    if track.has("decision.saturated"):
        for start, end in _flag(track, "decision.saturated"):
            found.append(Event(start, "WARN", f"command saturated{_for(start, end)}"))
    if track.has("guarantee.held"):
        found += _guarantee(track)
    status, end = track.info.status, float(track.time[-1])
    if track.info.end_time is not None:
        end = float(track.info.end_time)
    level = "INFO" if status == "completed" else "ERROR"
    found.append(Event(end, level, f"ended: {status.replace('_', ' ')}"))
    found = [Event(event.time, event.level, f"{label}: {event.text}") for event in found]
    return sorted(found, key=lambda event: event.time)


def episodes(time: Array, active: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Return start and end [s] of every stretch in which `active` holds, short gaps bridged.

    Parameters
    ----------
    time : (T,) array
        [s].
    active : (T,) bool array
        The condition.

    Returns
    -------
    list of (float, float)
        At most 200; the last one then reaches to the end of the last stretch.
    """
    edges = np.diff(np.concatenate([[False], active, [False]]).astype(np.int8))
    starts, ends = time[np.flatnonzero(edges == 1)], time[np.flatnonzero(edges == -1) - 1]
    merged: list[tuple[float, float]] = []
    for start, end in zip(starts.tolist(), ends.tolist(), strict=True):
        if merged and (start - merged[-1][1] < MERGE or len(merged) == MOST):
            merged[-1] = (merged[-1][0], end)
        else:
            merged.append((start, end))
    return merged


def _guarantee(track: Track) -> list[Event]:
    found = []
    told = track.info.guarantee
    if told.get("first_violation") is not None:
        time = told["first_violation_time"]
        assert isinstance(time, float)
        found.append(Event(time, "WARN", f"guarantee {violation(told)}"))
    for start, end in episodes(track.time, track.values("guarantee.held") == 0):
        which = violations(track, int(np.searchsorted(track.time, start)))
        text = f"guarantee not held{_for(start, end)}"
        found.append(Event(start, "INFO", f"{text}: {which}" if which else text))
    if track.has("guarantee.alarm"):
        seen = track.values("guarantee.monitored_slip")
        for start, end in _flag(track, "guarantee.alarm"):
            peak = float(np.nanmax(seen[(track.time >= start) & (track.time <= end)]))
            found.append(
                Event(start, "ERROR", f"slip alarm: slip beyond its bound{_for(start, end)}, peak {peak:.0%}")
            )
    return found


def _flag(track: Track, name: str) -> list[tuple[float, float]]:
    return episodes(track.time, track.values(name) > 0)


def _for(start: float, end: float) -> str:
    return f" for {end - start:.2f} s" if end > start else ""
