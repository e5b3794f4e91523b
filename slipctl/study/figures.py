"""The figures of the paper, drawn again: the same quantities under the same numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from slipctl.study import style
from slipctl.study.runs import StudyRun

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Sections = Mapping[str, Mapping[str, StudyRun]]
TIME = "time t [s]"
FRAME = 1.1
"""Height over width of a frame that shows paths to scale."""


@dataclass(frozen=True)
class Picture:
    """One figure.

    Attributes
    ----------
    number : int
        As in the paper.
    section : str
        Which runs it shows.
    caption : str
    draw : callable
        From the section's nominal and robust run to the figure.
    """

    number: int
    section: str
    caption: str
    draw: Callable[[StudyRun, StudyRun], Figure]

    @property
    def name(self) -> str:
        """File name without its ending."""
        return f"figure-{self.number:02d}"


def slip_velocity(nominal: StudyRun, robust: StudyRun) -> Figure:
    """Draw v_t(t) under the robust law."""
    figure, axes = style.new_figure(1, 1, 2.4)
    _line(axes[0, 0], robust, robust["slip.longitudinal"], style.ROBUST, "$v_t$")
    _line(axes[0, 0], robust, robust["motion.forward_speed"], style.DESIRED, "$v$ (wheels)")
    style.label(axes[0, 0], TIME, "speed [m/s]")
    axes[0, 0].set_ylim(bottom=0.0)
    axes[0, 0].legend(loc="upper right", ncols=2)
    return figure


def paths(near_the_start: bool) -> Callable[[StudyRun, StudyRun], Figure]:
    """Return how to draw the desired path and both actual ones, and one end of them from near by."""

    def draw(nominal: StudyRun, robust: StudyRun) -> Figure:
        figure, axes = style.new_figure(1, 2, 4.0)
        whole, near = axes[0]
        for plot in (whole, near):
            _path(plot, robust, "reference.position", style.DESIRED, "desired", 2.6)
            _path(plot, nominal, "motion.position", style.NOMINAL, "nominal")
            _path(plot, robust, "motion.position", style.ROBUST, "robust")
            style.label(plot, "x [m]", "y [m]")
        _window(whole, [robust.pair("reference.position"), nominal.pair("motion.position")], 0.05)
        if near_the_start:
            first = robust["time"] <= 0.25 * robust["time"][-1]
            _window(near, [run.pair(column)[first] for run, column in _shown(nominal, robust)], 0.05)
        else:
            _window(near, [run.pair(column)[-1:] for run, column in _shown(nominal, robust)], 1.0)
        whole.set_title("the whole path")
        near.set_title("its first quarter" if near_the_start else "its end")
        style.legend_above(figure, whole)
        return figure

    return draw


def _shown(nominal: StudyRun, robust: StudyRun) -> list[tuple[StudyRun, str]]:
    return [(robust, "reference.position"), (robust, "motion.position"), (nominal, "motion.position")]


def errors(nominal: StudyRun, robust: StudyRun) -> Figure:
    """Draw the tracking errors in x and y."""
    figure, axes = style.new_figure(2, 1, 3.8, sharex=True)
    for index, (plot, axis) in enumerate(zip(axes[:, 0], "xy", strict=True)):
        for run, colour, name in ((nominal, style.NOMINAL, "nominal"), (robust, style.ROBUST, "robust")):
            gap = run.pair("motion.position") - run.pair("reference.position")
            _line(plot, run, 1e3 * gap[:, index], colour, name)
        plot.axhline(0.0, color=style.DESIRED, linewidth=0.8)
        style.label(plot, TIME if index else "", f"error in {axis} [mm]")
    style.legend_above(figure, axes[0, 0])
    return figure


def headings(nominal: StudyRun, robust: StudyRun) -> Figure:
    """Draw the desired heading and both actual ones."""
    figure, axes = style.new_figure(1, 1, 2.9)
    _line(axes[0, 0], robust, np.unwrap(robust["reference.heading"]), style.DESIRED, "desired", 2.6)
    _line(axes[0, 0], nominal, np.unwrap(nominal["motion.heading"]), style.NOMINAL, "nominal")
    _line(axes[0, 0], robust, np.unwrap(robust["motion.heading"]), style.ROBUST, "robust")
    style.label(axes[0, 0], TIME, "heading θ [rad]")
    style.legend_above(figure, axes[0, 0])
    return figure


def inputs(unit: str, beginning: float = 1.0) -> Callable[[StudyRun, StudyRun], Figure]:
    """Return how to draw both terms of the robust law: the `beginning` [s], and all of the run."""

    def draw(nominal: StudyRun, robust: StudyRun) -> Figure:
        figure, axes = style.new_figure(2, 2, 4.0, sharex="col")
        time, cut = robust["time"], False
        first = time <= min(beginning, 0.25 * time[-1])
        for index, axis in enumerate("xy"):
            hats = robust.pair("decision.nominal_input")[:, index]
            deltas = robust.pair("decision.robust_input")[:, index]
            for plot, shown in zip(axes[index], (first, np.ones_like(first)), strict=True):
                # the larger term behind, the smaller one on top of it
                _line(plot, robust, hats, style.NOMINAL_INPUT, r"nominal $\hat{v}$", shown=shown)
                _line(plot, robust, deltas, style.ROBUST_INPUT, r"corrective $\Delta v$", 1.1, shown=shown)
                plot.axhline(0.0, color=style.DESIRED, linewidth=0.8, zorder=0)
                style.label(
                    plot,
                    TIME if index else "",
                    f"{axis} component [{unit}]" if plot is axes[index, 0] else "",
                )
            # a peak at the start must not hide the rest
            most = 1.15 * max(np.abs(hats).max(), np.abs(deltas[~first]).max())
            cut |= bool(np.abs(deltas).max() > most)
            if np.abs(deltas).max() > most:
                axes[index, 1].set_ylim(-most, most)
        axes[0, 0].set_title("the beginning")
        axes[0, 1].set_title("the whole run" + (", peaks cut off" if cut else ""))
        style.legend_above(figure, axes[0, 0])
        return figure

    return draw


def torques(nominal: StudyRun, robust: StudyRun) -> Figure:
    """Draw both wheel torques of the robust law."""
    figure, axes = style.new_figure(1, 1, 2.9)
    for side, colour in (("right", style.NOMINAL_INPUT), ("left", style.ROBUST_INPUT)):
        values = robust[f"wheel.torque_command.{side}"]
        _line(axes[0, 0], robust, values, colour, rf"$\tau_{side[0]}$ ({side} wheel)")
    axes[0, 0].axhline(0.0, color=style.DESIRED, linewidth=0.8, zorder=0)
    style.label(axes[0, 0], TIME, "torque [N·m]")
    style.legend_above(figure, axes[0, 0])
    return figure


_KINEMATIC, _DYNAMIC, _EXPERIMENT = "kinematic", "dynamic", "experiment"
PICTURES: tuple[Picture, ...] = (
    Picture(
        3, _KINEMATIC, "Slip velocity v_t(t) under the robust kinematic law: 40 % of v(t).", slip_velocity
    ),
    Picture(4, _KINEMATIC, "Kinematic laws: desired and actual paths.", paths(False)),
    Picture(5, _KINEMATIC, "Kinematic laws: tracking errors in x and y.", errors),
    Picture(6, _KINEMATIC, "Kinematic laws: desired and actual heading.", headings),
    Picture(7, _KINEMATIC, "Robust kinematic law: nominal term v̂ and corrective term Δv.", inputs("m/s²")),
    Picture(8, _DYNAMIC, "Dynamic laws: desired and actual paths.", paths(True)),
    Picture(9, _DYNAMIC, "Dynamic laws: tracking errors in x and y.", errors),
    Picture(10, _DYNAMIC, "Dynamic laws: desired and actual heading.", headings),
    Picture(11, _DYNAMIC, "Robust dynamic law: nominal term v̂ and corrective term Δv.", inputs("m/s³", 2.5)),
    Picture(12, _DYNAMIC, "Robust dynamic law: wheel torques.", torques),
    Picture(14, _EXPERIMENT, "Experiment, simulated: desired and actual paths.", paths(True)),
    Picture(15, _EXPERIMENT, "Experiment, simulated: tracking errors in x and y.", errors),
    Picture(16, _EXPERIMENT, "Experiment, simulated: nominal term v̂ and corrective term Δv.", inputs("m/s²")),
)
"""Every figure that shows a run; 1 and 2 are sketches of the robot, 13 is a photograph."""

SHOWN = {
    _KINEMATIC: ("nominal", "paper"),
    _DYNAMIC: ("nominal", "proportional"),
    _EXPERIMENT: ("nominal", "robust"),
}
"""Labels of the nominal and the robust run that a section's figures show."""


def draw_all(sections: Sections, folder: Path) -> list[Picture]:
    """Write every figure whose section was run as PNG and SVG into `folder`; return which."""
    drawn = []
    with style.styled():
        for picture in PICTURES:
            runs = sections.get(picture.section)
            if not runs:
                continue
            nominal, robust = (runs[label] for label in SHOWN[picture.section])
            style.write(picture.draw(nominal, robust), folder / picture.name)
            drawn.append(picture)
    return drawn


def _window(axes: Axes, paths: list[np.ndarray], margin: float) -> None:
    """Show some paths to scale in a frame of fixed shape, with room of `margin` times their size around."""
    points = np.concatenate(paths)
    centre = (points.max(axis=0) + points.min(axis=0)) / 2.0
    half = (0.5 + margin) * np.ptp(points, axis=0)
    width = max(half[0], half[1] / FRAME, 0.02)
    axes.set_xlim(centre[0] - width, centre[0] + width)
    axes.set_ylim(centre[1] - FRAME * width, centre[1] + FRAME * width)
    axes.set_box_aspect(FRAME)


def _line(
    axes: Axes,
    run: StudyRun,
    values: np.ndarray,
    colour: str,
    name: str,
    width: float = 1.4,
    shown: np.ndarray | None = None,
) -> None:
    time = run["time"]
    if shown is not None:
        time, values = time[shown], values[shown]
    some = style.thinned(len(time))
    axes.plot(time[some], values[some], color=colour, label=name, linewidth=width)
    axes.set_xlim(time[0] - 0.015 * np.ptp(time), time[-1])  # what happens at once must not hide


def _path(axes: Axes, run: StudyRun, column: str, colour: str, name: str, width: float = 1.4) -> None:
    pair = run.pair(column)
    some = style.thinned(len(pair))
    axes.plot(pair[some, 0], pair[some, 1], color=colour, label=name, linewidth=width)
