"""The tab *Guarantee*: hypotheses on the left, consequences on the right, what held below."""

from __future__ import annotations

import rerun.blueprint as rrb

from slipctl.view.theorem import LANES, slip_title
from slipctl.view.tracks import Track
from slipctl.view.views import Plots, column, lane


def guarantee_tab(track: Track, root: str, plots: Plots) -> rrb.Container:
    """Return the tab of one run whose law has a theorem."""
    theorem = track.info.theorem
    assert theorem is not None
    label = track.info.label
    unit = "m/s²" if theorem.order == 2 else "m/s³"
    bounds = ["guarantee.bound.v_s", "guarantee.bound.slip"]
    sizes = ["guarantee.size.slip", "guarantee.size.v_t", "guarantee.size.v_s"]
    hypotheses = column(
        plots.view(
            f"Uncertainty |η| [{unit}] · wide: ρ",
            ["decision.robust_gain", "guarantee.uncertainty"],
            only=label,
            settled=True,
        ),
        plots.view(slip_title(theorem), [*bounds, *sizes], only=label, settled=True),
        plots.view(
            "Yaw slip |w_s| [rad/s] · wide: its bound",
            ["guarantee.bound.w_s", "guarantee.size.w_s"],
            only=label,
            settled=True,
        ),
    )
    consequences = column(
        plots.view(
            "|JᵀPe| · wide: boundary layer ε",
            ["guarantee.bound.layer", "guarantee.weighted_error"],
            only=label,
            settled=True,
        ),
        plots.view(
            "V = eᵀPe · wide: level it stays below",
            ["guarantee.bound.level", "guarantee.lyapunov"],
            only=label,
            settled=True,
        ),
        plots.view(
            "Position error [m] · wide: ultimate bound",
            ["guarantee.bound.error", "error.position"],
            only=label,
            settled=True,
        ),
    )
    lanes = [f"+ {lane(root, name)}" for column, (name, *_) in LANES.items() if track.has(column)]
    return rrb.Vertical(
        rrb.Horizontal(hypotheses, consequences),
        rrb.StateTimelineView(contents=lanes, name="Hypotheses, consequence, tick, monitor"),
        row_shares=[2.4, 1],
        name=f"Guarantee · {track.name}",
    )
