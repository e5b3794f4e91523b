"""Where cameras look and which part of an axis is shown, decided by the data."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipctl.view.tracks import Array, Track

TRANSIENT = 0.1  # share of the run, assumed: what comes later is the part that one wants to read
DWARFS = 3.0  # a transient this many times larger than all the rest is left out of the axis
MARGIN = 0.4  # m around the path, the size of a robot


def axis_range(series: Sequence[tuple[Array, Array]]) -> tuple[float, float] | None:
    """Return the range of an axis that leaves out the first transient, or None where it may choose itself.

    Parameters
    ----------
    series : sequence of (time (T,), values (T,))
        All that the plot shows; NaN is ignored.

    Returns
    -------
    (low, high) or None
        None unless the first tenth of the time holds values three times beyond everything later.
    """
    start, end = min(time[0] for time, _ in series), max(time[-1] for time, _ in series)
    split = start + TRANSIENT * (end - start)
    everything = np.concatenate([values for _, values in series])
    later = np.concatenate([values[time >= split] for time, values in series])
    everything, later = everything[np.isfinite(everything)], later[np.isfinite(later)]
    if len(later) == 0 or len(everything) == 0:
        return None
    size = float(np.max(np.abs(later)))
    if size == 0 or float(np.max(np.abs(everything))) <= DWARFS * size:
        return None
    low, high = min(0.0, float(np.min(later))), max(0.0, float(np.max(later)))
    span = high - low
    return low - (0.4 if low < 0 else 0.05) * span, high + (0.4 if high > 0 else 0.05) * span


def from_zero(series: Sequence[tuple[Array, Array]]) -> tuple[float, float] | None:
    """Return the range of an axis for amounts: from 0 to well above the largest; None where all are 0.

    The viewer writes numbers at steps of 1, 10, 100 … where there is room for them: beyond half a power of
    ten the axis goes on to the next, so that it does not end up with a 0 alone.
    """
    tops = [float(np.nanmax(values)) for _, values in series if np.isfinite(values).any()]
    top = 1.4 * max(tops, default=0.0)
    if not np.isfinite(top) or top <= 0.0:
        return None
    power = 10.0 ** np.floor(np.log10(top))
    return 0.0, top if top <= 5.0 * power else 10.5 * power


def scene_box(tracks: Sequence[Track]) -> tuple[Array, Array]:
    """Return lower and upper corner (2,) [m] of what the scene should show.

    The reference counts whole; a robot that ran away counts only as far as one size of the reference beyond
    it, otherwise the path would be a dot.
    """
    reference = [track.pair("reference.position") for track in tracks if track.has("reference.position.x")]
    driven = np.concatenate([track.pair("motion.position") for track in tracks])
    driven = driven[np.all(np.isfinite(driven), axis=1)]
    anchor = np.concatenate(reference) if reference else driven
    anchor = anchor[np.all(np.isfinite(anchor), axis=1)]
    if len(anchor) == 0:
        return np.array([-1.0, -1.0]), np.array([1.0, 1.0])
    low, high = anchor.min(axis=0), anchor.max(axis=0)
    reach = max(float(np.max(high - low)), 1.0)
    driven = np.clip(driven, low - reach, high + reach)
    if len(driven):
        low, high = np.minimum(low, driven.min(axis=0)), np.maximum(high, driven.max(axis=0))
    return low - MARGIN, high + MARGIN
