"""Time-series views over the runs of a world, and how they are stacked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import rerun.blueprint as rrb

from slipctl.view.framing import axis_range, from_zero
from slipctl.view.plots import derived, entity
from slipctl.view.tracks import Track

TIMES = rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal)
BELOW = 0.04
"""Share of an axis of amounts below 0, so that a line at 0 does not lie on the edge."""

LEGEND = rrb.PlotLegend(rrb.Corner2D.RightTop)


class Plots:
    """Time-series views over the runs of a world; series that a run lacks are left out."""

    def __init__(self, tracks: Sequence[Track], roots: Mapping[str, str]) -> None:
        self._tracks, self._roots = tracks, roots
        self._derived = {
            track.info.label: {series.path: series.values for series in derived(track)} for track in tracks
        }

    def view(
        self,
        name: str,
        columns: Sequence[str],
        only: str | None = None,
        first: Sequence[str] = (),
        settled: bool = False,
        headroom: bool = False,
    ) -> rrb.TimeSeriesView | None:
        """Return one view, or None where no run has any of its columns.

        Parameters
        ----------
        name : str
            With the unit.
        columns : sequence of str
            Columns or derived series, of every run or of `only` one.
        first : sequence of str
            Columns shown once, from the run that lasted longest.
        settled : bool
            Whether a first transient that dwarfs the rest is left out of the axis (and the name says so).
        headroom : bool
            Whether the axis starts just below 0 and leaves room above, so that no line lies under the legend.
        """
        longest = max(self._tracks, key=lambda track: track.time[-1])
        wanted = [(longest, column) for column in first]
        wanted += [
            (track, column)
            for column in columns
            for track in self._tracks
            if only in (None, track.info.label)
        ]
        present = [(track, column) for track, column in wanted if self._values(track, column) is not None]
        if not present:
            return None
        pairs = [(track.time, self._values(track, column)) for track, column in present]
        series = [(time, values) for time, values in pairs if values is not None]
        limits = axis_range(series) if settled else None
        shown = limits
        if headroom:
            # an axis without the transient ends where it ends; then only the lower end is wanted
            shown = (0.0, limits[1]) if limits else from_zero(series)
            shown = (-BELOW * shown[1], shown[1]) if shown else None
        return rrb.TimeSeriesView(
            contents=[f"+ {entity(self._roots[track.info.label], column)}" for track, column in present],
            name=name + (" · axis without the first transient" if limits else ""),
            axis_x=TIMES,
            axis_y=rrb.ScalarAxis(range=shown) if shown else None,
            plot_legend=LEGEND,
        )

    def _values(self, track: Track, column: str) -> np.ndarray | None:
        if column in self._derived[track.info.label]:
            return self._derived[track.info.label][column]
        return track.values(column) if track.has(column) else None


def column(*views: rrb.TimeSeriesView | None, first: float = 1.0) -> rrb.Vertical:
    """Stack the views there are; the uppermost gets `first` times the height of the others."""
    shown = [view for view in views if view is not None]
    return rrb.Vertical(contents=shown, row_shares=[first, *(1.0 for _ in shown[1:])])


def lane(root: str, name: str) -> str:
    """Return the entity of a lane of states below a run's root."""
    return f"{root}/state/{name.replace(' ', '_')}"
