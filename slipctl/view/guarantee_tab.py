"""The tab *Guarantee*: hypotheses on the left, consequences on the right, what held below."""

from __future__ import annotations

import rerun.blueprint as rrb

from slipctl.guarantee import HYPOTHESES
from slipctl.view.theorem import LANES, slip_title
from slipctl.view.tracks import Track
from slipctl.view.views import Plots, column, lane


def guarantee_tab(track: Track, root: str, plots: Plots) -> rrb.Container:
    """Return the tab of one run whose law has a theorem."""
    theorem = track.info.theorem
    assert theorem is not None
    unit = track.units.get("guarantee.uncertainty", "m/s²")
    promised = track.info.guarantee.get("error_bound") is not None
    level, bound = (
        ("wide: the level it stays below", "wide: its ultimate bound")
        if promised
        else ("no level is promised", "no bound is promised")
    )

    def view(name: str, *columns: str) -> rrb.TimeSeriesView | None:
        return plots.view(name, columns, only=track.info.label, settled=True, headroom=True)

    hypotheses = column(
        view(f"Uncertainty |η| [{unit}] · wide: ρ", "decision.robust_gain", "guarantee.uncertainty"),
        view(
            slip_title(theorem),
            *("guarantee.bound.v_s", "guarantee.bound.slip"),
            *("guarantee.size.slip", "guarantee.size.v_t", "guarantee.size.v_s"),
        ),
        view("Yaw slip |w_s| [rad/s] · wide: its bound", "guarantee.bound.w_s", "guarantee.size.w_s"),
    )
    consequences = column(
        # no glyph beyond the viewer's own font: it ends where one is missing
        view("Weighted error |w| = |J'Pe| · wide: ε", "guarantee.bound.layer", "guarantee.weighted_error"),
        view(f"V = e'Pe · {level}", "guarantee.bound.level", "guarantee.lyapunov"),
        view(f"Position error [m] · {bound}", "guarantee.bound.error", "error.position"),
    )
    return rrb.Vertical(
        rrb.Horizontal(hypotheses, consequences),
        rrb.Horizontal(
            _lanes(track, root, "Hypotheses of the theorem", hypotheses=True),
            _lanes(track, root, "What follows, the tick and the slip monitor", hypotheses=False),
        ),
        row_shares=[2.0, 1.0],
        name=f"Guarantee · {track.name}",
    )


def _lanes(track: Track, root: str, name: str, hypotheses: bool) -> rrb.StateTimelineView:
    shown = [
        path
        for column_name, (path, *_) in LANES.items()
        if track.has(column_name) and (column_name.removeprefix("guarantee.") in HYPOTHESES) is hypotheses
    ]
    return rrb.StateTimelineView(contents=[f"+ {lane(root, path)}" for path in shown], name=name)
