"""How the figures look, and how they are written: the same bytes for the same numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito's palette, the same colours as in the recordings
DESIRED = "#808080"
NOMINAL = "#E69F00"
ROBUST = "#009E73"
NOMINAL_INPUT = "#0072B2"
ROBUST_INPUT = "#D55E00"
THIRD = "#56B4E9"
FOURTH = "#CC79A7"

WIDTH = 6.4
"""Width of every figure [in]."""

_SETTINGS: dict[Any, Any] = {
    "svg.hashsalt": "slipctl",  # names inside an SVG are random without it
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same on every machine
    "font.size": 9.0,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.4,
    "lines.solid_joinstyle": "round",
    "figure.dpi": 100.0,
    "savefig.dpi": 100.0,
    "path.simplify": True,
}


@contextmanager
def styled() -> Iterator[None]:
    """Set the style while figures are made, whatever the user's own matplotlibrc says."""
    import matplotlib as mpl

    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def new_figure(rows: int, columns: int, height: float, **options: Any) -> tuple[Figure, np.ndarray]:
    """Return a figure and its axes (rows, columns); never shown, so no window system is needed."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    from matplotlib.ticker import MaxNLocator

    for plot in np.ravel(axes):
        plot.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    return figure, np.asarray(axes)


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Name both axes, each with its unit, and what is shown."""
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    if title:
        axes.set_title(title)


def legend_above(figure: Figure, axes: Axes) -> None:
    """Put one legend of the lines in `axes` above all of the figure."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=len(labels))


def thinned(count: int, most: int = 4000) -> slice:
    """Return which of `count` samples to draw: a picture has no room for more, and files stay small."""
    return slice(None, None, max(1, count // most))


def write(figure: Figure, path: Path, vector: bool = True) -> None:
    """Write `path`.png, and `path`.svg beside it; neither holds a date or a version."""
    figure.savefig(path.with_suffix(".png"), metadata={"Software": None})
    if vector:
        figure.savefig(path.with_suffix(".svg"), metadata={"Date": None, "Creator": None})
