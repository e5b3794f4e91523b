"""What recording a baseline again changed: tables of old and new numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from slipctl.metrics import UNITS
from slipctl.report.amounts import amount, change_text, share_text
from slipctl.report.judged import metric_text, run_text

if TYPE_CHECKING:
    from rich.console import RenderableType

Change = Mapping[str, Any]
"""One number or status that is not as it was, as of `slipctl.regression.record.changes`."""

TITLES = ("metric", "old → new", "change", "tolerance")
INDENT = 4


def summary(scenario: str, runs: Sequence[Mapping[str, Any]], changes: Sequence[Change]) -> str:
    """Say in one line what was recorded.

    Parameters
    ----------
    scenario
        Its name.
    runs
        The runs of the new baseline, as in its file.
    changes
        As of `tables`.
    """
    numbers = [number for run in runs for number in run["metrics"].values()]
    chaotic = sum(number["gate"] == "verdict" for number in numbers)
    parts = [f"{_count(len(numbers), 'number')} of {_count(len(runs), 'run')} recorded"]
    if chaotic:
        parts.append(f"{chaotic} of them chaotic and not gated as numbers")
    if changes:
        parts.append(f"{len(changes)} changed")
    return f"{scenario}: {', '.join(parts)}"


def tables(changes: Sequence[Change]) -> list[RenderableType]:
    """Lay out old and new of everything that changed, for a terminal of 80 columns or more.

    Parameters
    ----------
    changes
        As of `slipctl.regression.record.changes`: ``before`` and ``after`` in the units of the metrics.

    Returns
    -------
    list of rich.text.Text or rich.padding.Padding
        Per run its name and a table, the columns of all tables below each other.
    """
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    rows = [_row(change) for change in changes]
    widths = [max(map(len, column)) for column in zip(TITLES, *rows, strict=True)]
    laid: list[RenderableType] = []
    pairs = zip(changes, rows, strict=True)
    for place, (run, group) in enumerate(groupby(pairs, key=lambda pair: run_text(pair[0]))):
        table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), show_header=place == 0)
        for title, width in zip(TITLES, widths, strict=True):
            least = width if title != TITLES[-1] else None  # no blanks at the end of a line
            justify = "right" if title == "change" else "left"
            table.add_column(title, min_width=least, justify=justify, overflow="fold", header_style="dim")
        for _, row in group:
            table.add_row(*row)
        laid += [Text(f"  {run}", style="bold"), Padding(table, (0, 0, 0, INDENT), expand=False)]
    return laid


def _row(change: Change) -> tuple[str, str, str, str]:
    metric, before, after = change["metric"], change["before"], change["after"]
    if metric == "status":
        return metric, f"{before or 'no such run'} → {after or 'no such run'}", "", ""
    unit, was, now = UNITS[metric], before["value"], after["value"]
    same = was == now
    return (
        metric_text(metric),
        amount(now, unit) if same else change_text(was, now, unit),
        "same" if same else share_text(was, now),
        _tolerance(before, after, unit),
    )


def _tolerance(before: Mapping[str, Any], after: Mapping[str, Any], unit: str) -> str:
    """Say the new tolerance, and the old one where it was another."""
    was, now = (_gate(entry, unit) for entry in (before, after))
    return now if was == now else f"{was} → {now}"


def _gate(entry: Mapping[str, Any], unit: str) -> str:
    return "chaotic" if entry["gate"] == "verdict" else amount(entry["tolerance"], unit, digits=2)


def _count(number: int, thing: str) -> str:
    return f"{number} {thing}{'' if number == 1 else 's'}"
