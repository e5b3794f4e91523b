"""The layout that a recording carries: five kinds of tab, with units in the names of the views."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import rerun.blueprint as rrb

from slipctl.view.framing import scene_box
from slipctl.view.guarantee_tab import guarantee_tab
from slipctl.view.plots import STATES
from slipctl.view.scene import Scales
from slipctl.view.summary import arrow_words
from slipctl.view.theorem import LANES
from slipctl.view.tracks import Track
from slipctl.view.views import Plots, column, lane

SKY = rrb.Background((0x16, 0x19, 0x1D))
NO_GRID = rrb.LineGrid3D(visible=False)
UNTIL_NOW = rrb.VisibleTimeRanges(
    timeline="sim_time",
    start=rrb.TimeRangeBoundary.infinite(),
    end=rrb.TimeRangeBoundary.cursor_relative(),
)


def blueprint(
    tracks: Sequence[Track], scales: Scales, roots: Mapping[str, str], sweep: bool, active_tab: int = 0
) -> rrb.Blueprint:
    """Return the layout of one world.

    Parameters
    ----------
    tracks : sequence of Track
        The runs; their values decide cameras and axes.
    scales : Scales
        Said in the names of the 3D views.
    roots : mapping
        Entity of each label.
    sweep : bool
        Whether there are other worlds to switch to.
    active_tab : int
        The tab that is open at first.
    """
    plots = Plots(tracks, roots)
    scene = "3D · grid 0.5 m"
    overview = rrb.Horizontal(
        scene_view(scene, tracks, roots, above=False),
        column(
            plots.view("Position error [m]", ["error.position"], settled=True, headroom=True),
            plots.view(
                f"Inputs: nominal |v̂|, robust |Δv| [{_input_unit(tracks)}]",
                ["decision.nominal_input.norm", "decision.robust_input.norm"],
                settled=True,
                headroom=True,
            ),
            plots.view(
                "Left wheel [rad/s] · thin: commanded",
                ["wheel.rate_command.left", "wheel.rate.left"],
                settled=True,
            ),
            plots.view(
                "Right wheel [rad/s] · thin: commanded",
                ["wheel.rate_command.right", "wheel.rate.right"],
                settled=True,
            ),
        ),
        column_shares=[3, 2],
        name="Overview",
    )
    tracking = rrb.Horizontal(
        scene_view("From above · grid 0.5 m", tracks, roots, above=True),
        column(
            plots.view("Position error [m]", ["error.position"], settled=True, headroom=True),
            plots.view("Cross-track error [m]", ["error.cross_track"], settled=True),
            plots.view("Heading error [rad]", ["error.heading"], settled=True),
            plots.view("Forward speed v [m/s]", ["motion.forward_speed"], first=["reference.forward_speed"]),
        ),
        column_shares=[1, 1],
        name="Tracking",
    )
    slip = [_slip_tab(track, roots[track.info.label], plots, scales, len(tracks)) for track in tracks]
    theorems = [
        guarantee_tab(track, roots[track.info.label], plots)
        for track in tracks
        if track.info.theorem is not None and track.has("guarantee.held")
    ]
    about = rrb.Horizontal(
        rrb.TextDocumentView(origin="/info/summary", name="Summary"),
        rrb.TextLogView(
            contents=[f"+ {root}/events" for root in roots.values()],
            name="Events",
            columns=rrb.TextLogColumns(text_log_columns=["LogLevel", "Body"]),
        ),
        column_shares=[3, 2],
        name="Run info",
    )
    return rrb.Blueprint(
        rrb.Tabs(overview, tracking, *slip, *theorems, about, active_tab=active_tab),
        # the panel that switches between the worlds of a sweep
        rrb.BlueprintPanel(state="expanded" if sweep else "collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="sim_time", loop_mode="all"),
        auto_views=False,
        auto_layout=False,
    )


def _slip_tab(track: Track, root: str, plots: Plots, scales: Scales, count: int) -> rrb.Container:
    label = track.info.label
    states = [
        f"+ {lane(root, name)}"
        for column, (name, *_) in STATES.items()
        if track.has(column) and column not in LANES
    ]
    bound = "" if track.info.slip_bound is None else f" · wide: bound ±{track.info.slip_bound:g}|v|"
    slip = ["slip.bound.upper", "slip.bound.lower", "slip.longitudinal", "slip.lateral"]
    gain, unit = ["decision.robust_gain", "guarantee.uncertainty"], _input_unit([track])
    views = [
        plots.view(f"Slip [m/s]{bound}", slip, only=label, settled=True),
        plots.view("Traction forward [N]", _sides("wheel.longitudinal_force"), only=label),
        plots.view("Traction to the left [N]", _sides("wheel.lateral_force"), only=label),
        plots.view("Wheel load [N]", _sides("wheel.normal_force"), only=label),
        plots.view(f"Uncertainty |η| [{unit}] · wide: ρ", gain, only=label, settled=True, headroom=True),
    ]
    camera = rrb.Spatial3DView(
        origin=f"{root}/robot/base",
        contents=[f"+ {root}/**", "+ /reference/**", "+ /ground/**", f"- {root}/robot/base/label"],
        name=" · ".join(arrow_words(scales)),
        background=SKY,
        line_grid=NO_GRID,
        overrides=_growing([root]),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=(-0.95, -0.55, 0.75),
            look_target=(0.05, 0.0, 0.05),
            eye_up=(0, 0, 1),
        ),
    )
    name = "Slip & wheels" if count == 1 else f"Slip & wheels · {track.name}"
    left: rrb.Container | rrb.View = camera
    if states:
        lanes = rrb.StateTimelineView(contents=states, name="Wheels, command, guarantee")
        left = rrb.Vertical(camera, lanes, row_shares=[2.6, 1])
    return rrb.Horizontal(left, column(*views, first=1.5), column_shares=[1, 1], name=name)


def scene_view(
    name: str, tracks: Sequence[Track], roots: Mapping[str, str], above: bool
) -> rrb.Spatial3DView:
    """Return a view of the whole scene, from above or from the side, in which trails grow."""
    low, high = scene_box(tracks)
    middle, size = (low + high) / 2, float(max(high - low))
    if above:
        position, up = (middle[0], middle[1] - 1e-3, 1.05 * size), (0, 1, 0)
    else:
        position, up = (middle[0] - 0.18 * size, middle[1] - 0.68 * size, 0.48 * size), (0, 0, 1)
    hidden = [f"- {root}/robot/base/{part}/**" for root in roots.values() for part in ("arrows", "label")]
    return rrb.Spatial3DView(
        origin="/",
        contents=[
            "+ /ground/**",
            "+ /reference/**",
            *(f"+ {root}/**" for root in roots.values()),
            *(hidden if above else []),
        ],
        name=name,
        background=SKY,
        line_grid=NO_GRID,
        overrides=_growing(roots.values()),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital, position=position, look_target=(middle[0], middle[1], 0.0), eye_up=up
        ),
    )


def _input_unit(tracks: Sequence[Track]) -> str:
    """Return the unit of v̂, Δv, η and ρ: of an acceleration, or of a jerk for dynamic laws."""
    return tracks[0].units.get("decision.nominal_input.x", "m/s²")


def _growing(roots: Iterable[str]) -> dict[Any, Any]:
    """Show every piece of a trail up to the cursor."""
    return {f"{root}/trail": UNTIL_NOW for root in roots}


def _sides(stem: str) -> list[str]:
    return [f"{stem}.left", f"{stem}.right"]
