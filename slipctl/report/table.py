"""The table on the terminal: one row per world, the controllers side by side.

Laid out here and not by a table class, because the controllers' names head groups of columns, and because
the same table goes to a terminal, a pipe and a log file: what colour says is also said by a sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from slipctl.report import guarantee

if TYPE_CHECKING:
    from rich.text import Text

ON_THE_PATH = 0.1
"""A run whose position error never exceeds this [m] is said to keep to its path (assumed;
only a way to read the table, no gate uses it)."""

SIDE_BY_SIDE = 2
"""Controllers beside each other before the table goes on below: two fill a terminal of 100 columns."""

GAP = "   "

MILLIMETRES = {"RMS": "rms_position_error", "max": "max_position_error", "final": "final_position_error"}
SLIP = "median_slip_ratio"
STATUS_WORDS = {"completed": "ok", "left_the_arena": "left"}


@dataclass(frozen=True)
class Cell:
    """One entry of the table: its text, and what colour says in addition."""

    text: str
    style: str = ""


@dataclass(frozen=True)
class Group:
    """Adjacent columns under one heading: ``titles`` and, per row, as many cells."""

    heading: str
    titles: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


def worlds(runs: Sequence[Mapping[str, Any]]) -> list[list[Mapping[str, Any]]]:
    """Group runs that met the same world, in the order in which the worlds first appear.

    Parameters
    ----------
    runs
        The ``runs`` of the JSON output: each with ``controller``, ``varied``, ``seed``, ``status`` and
        ``metrics``.
    """
    grouped: dict[tuple, list[Mapping[str, Any]]] = {}
    for run in runs:
        key = (repr(sorted(run["varied"].items(), key=lambda item: item[0])), run["seed"])
        grouped.setdefault(key, []).append(run)
    return list(grouped.values())


def results(payload: Mapping[str, Any], end_times: Sequence[float] | None = None) -> list[Text]:
    """Lay out the results of a run as lines of text.

    Parameters
    ----------
    payload
        The JSON output of a run (``Result.json()``).
    end_times
        Time at which each run ended [s], in the order of ``payload["runs"]``; said where a run ended early.

    Returns
    -------
    list of rich.text.Text
        Heading, one row per world (one per controller where there is a single world), and one sentence per
        controller that says where it keeps to its path. ``*`` marks the smallest error of a world among the
        runs that reached the end, ``!`` an error above `ON_THE_PATH`.
    """
    from rich.text import Text

    runs = payload["runs"]
    times = {id(run): end for run, end in zip(runs, end_times, strict=True)} if end_times is not None else {}
    grouped = worlds(runs)
    labels = list(dict.fromkeys(run["controller"] for run in runs))
    groups = [_controller_group(label, grouped, times, compared=len(labels) > 1) for label in labels]
    if len(grouped) == 1:
        names = Group("", ("controller",), tuple((Cell(label, "bold"),) for label in labels))
        lines = _render([names, Group("", groups[0].titles, tuple(group.rows[0] for group in groups))])
    else:
        lines = []
        for first in range(0, len(groups), SIDE_BY_SIDE):
            lines += [Text()] * bool(lines)
            lines += _render([_world_group(grouped), *groups[first : first + SIDE_BY_SIDE]])
    lines.append(Text())
    marks = ["errors in mm", "slip: median, in % of the speed"]
    signs = {cell.text[-1:] for group in groups for row in group.rows for cell in row}
    if "*" in signs:
        marks.append("* smallest of its world")
    if "!" in signs:
        marks.append(f"! more than {1e3 * ON_THE_PATH:.0f} mm off")
    lines.append(Text(" · ".join(marks), style="dim"))
    if len(grouped) > 1:
        lines += [Text(_reach(label, grouped)) for label in labels]
    for label in labels:
        own = [run for world in grouped for run in world if run["controller"] == label]
        said = guarantee.sentence(label, own, _spans(own, guarantee.holds))
        lines += [] if said is None else [Text(said)]
    return lines


def _world_group(grouped: Sequence[Sequence[Mapping[str, Any]]]) -> Group:
    firsts = [runs[0] for runs in grouped]
    keys = list(dict.fromkeys(key for run in firsts for key in run["varied"]))
    # The same varied values with several seeds: only the seed tells such worlds apart.
    seeds = len({repr(run["varied"]) for run in firsts}) < len(firsts) and "seed" not in keys
    titles = [*keys, *(["seed"] if seeds else [])]
    rows = [
        tuple(Cell(value_text(run["varied"].get(key, ""))) for key in keys)
        + ((Cell(str(run["seed"])),) if seeds else ())
        for run in firsts
    ]
    return Group("", tuple(titles), tuple(rows))


def _controller_group(
    label: str, grouped: Sequence[Sequence[Mapping[str, Any]]], times: Mapping[int, float], compared: bool
) -> Group:
    rows = []
    for runs in grouped:
        run = next((run for run in runs if run["controller"] == label), None)
        if run is None:
            rows.append((Cell(""),) * (len(MILLIMETRES) + 2))
            continue
        errors = [_error(run, runs, metric, compared) for metric in MILLIMETRES.values()]
        slip = run["metrics"].get(SLIP)
        slip_cell = Cell("–" if slip is None else number_text(100 * slip))
        rows.append((*errors, slip_cell, _status(run, times.get(id(run)))))
    return Group(label, (*MILLIMETRES, "slip", "status"), tuple(rows))


def _error(run: Mapping[str, Any], rivals: Sequence[Mapping[str, Any]], metric: str, compared: bool) -> Cell:
    value = run["metrics"].get(metric)
    if value is None:
        return Cell("– ", "red")
    reached = [
        other["metrics"][metric]
        for other in rivals
        if other["status"] == "completed" and other["metrics"].get(metric) is not None
    ]
    if compared and run["status"] == "completed" and value == min(reached):
        off = value > ON_THE_PATH
        return Cell(number_text(1e3 * value) + "*", "bold red" if off else "bold green")
    if value > ON_THE_PATH:
        return Cell(number_text(1e3 * value) + "!", "red")
    return Cell(number_text(1e3 * value) + " ")


def _status(run: Mapping[str, Any], end_time: float | None) -> Cell:
    status: str = run["status"]
    words = STATUS_WORDS.get(status, status)
    if status == "completed":
        return Cell(words)
    return Cell(words if end_time is None else f"{words} at {end_time:.1f} s", "red")


def _reach(label: str, grouped: Sequence[Sequence[Mapping[str, Any]]]) -> str:
    """Say in which worlds a controller keeps to its path."""
    runs = [run for world in grouped for run in world if run["controller"] == label]
    kept = [run for run in runs if keeps_to_the_path(run)]
    sentence = (
        f"{label} stays within {1e3 * ON_THE_PATH:.0f} mm of the path in {len(kept)} of {len(runs)} worlds"
    )
    spans = _spans(runs, keeps_to_the_path)
    return f"{sentence}: {spans}" if kept and spans else sentence


def _spans(runs: Sequence[Mapping[str, Any]], inside: Callable[[Mapping[str, Any]], bool]) -> str:
    """Say at which values of the one varied number runs are `inside`; "" where there is no such number."""
    keys = list(runs[0]["varied"])
    values = [run["varied"].get(keys[0]) for run in runs] if len(keys) == 1 else []
    numbers = all(isinstance(value, int | float) for value in values)
    if not values or not numbers or len(set(values)) < len(runs):
        return ""
    ordered = sorted(runs, key=lambda run: run["varied"][keys[0]])
    ranges: list[list[float]] = []
    previous = False
    for run in ordered:
        here, value = inside(run), run["varied"][keys[0]]
        if here and previous:
            ranges[-1][-1] = value
        elif here:
            ranges.append([value, value])
        previous = here
    spans = [f"{low:g}" if low == high else f"{low:g} to {high:g}" for low, high in ranges]
    return f"{keys[0]} {', '.join(spans)}"


def keeps_to_the_path(run: Mapping[str, Any]) -> bool:
    """Whether a run reached its end and its position error never exceeded `ON_THE_PATH`."""
    worst = run["metrics"].get("max_position_error")
    return run["status"] == "completed" and worst is not None and worst <= ON_THE_PATH


def number_text(value: float) -> str:
    """Write a number with three digits that matter and without an exponent where people read millimetres."""
    size = abs(value)
    if size >= 99.95:
        return f"{value:.0f}"
    if size >= 9.995:
        return f"{value:.1f}"
    if size >= 0.0095 or size == 0:
        return f"{value:.2f}"
    return f"{value:.0e}"


def value_text(value: object) -> str:
    """Write a varied value: numbers short, everything else as it stands."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _render(groups: Sequence[Group]) -> list[Text]:
    """Lay groups of columns side by side: headings, titles, a rule and the rows."""
    from rich.text import Text

    widths = [
        [
            max(len(_title(title)), *(len(row[column].text) for row in group.rows))
            for column, title in enumerate(group.titles)
        ]
        for group in groups
    ]
    spans = [
        max(sum(columns) + sum(len(_before(title)) for title in group.titles[1:]), len(group.heading))
        for group, columns in zip(groups, widths, strict=True)
    ]

    def line(cells: Sequence[Sequence[Cell]]) -> Text:
        laid = Text()
        for group, columns, span, row in zip(groups, widths, spans, cells, strict=True):
            start = len(laid)
            for title, width, cell in zip(group.titles, columns, row, strict=True):
                laid.append("" if len(laid) == start else _before(title))
                left = title in ("status", "controller")
                laid.append(cell.text.ljust(width) if left else cell.text.rjust(width), style=cell.style)
            laid.append(" " * (start + span - len(laid)) + GAP)
        laid.rstrip()
        return laid

    heads = Text()
    for group, span in zip(groups, spans, strict=True):
        heads.append(group.heading.ljust(span) + GAP, style="bold")
    heads.rstrip()
    titles = line([[Cell(_title(title), "dim") for title in group.titles] for group in groups])
    rule = Text("─" * (sum(spans) + len(GAP) * (len(spans) - 1)), style="dim")
    rows = [line([group.rows[index] for group in groups]) for index in range(len(groups[0].rows))]
    return [*([heads] if heads.plain else []), titles, rule, *rows]


def _title(title: str) -> str:
    return f"{title} " if title in MILLIMETRES else title  # the place of the mark after the digits


def _before(title: str) -> str:
    return "  " if title == "status" else " "  # numbers have room enough where a mark may stand
