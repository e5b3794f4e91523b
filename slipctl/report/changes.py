"""What recording a baseline again changed: a table of old and new numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from slipctl.report.table import value_text

if TYPE_CHECKING:
    from rich.table import Table

Change = Mapping[str, Any]
"""One number or status that is not as it was, as of `slipctl.regression.record.changes`."""


def summary(scenario: str, runs: Sequence[Mapping[str, Any]], changes: Sequence[Change]) -> str:
    """Say in one line what was recorded.

    Parameters
    ----------
    scenario
        Its name.
    runs
        The runs of the new baseline, as in its file.
    changes
        As of `table`.
    """
    numbers = [number for run in runs for number in run["metrics"].values()]
    chaotic = sum(number["gate"] == "verdict" for number in numbers)
    parts = [f"{len(numbers)} numbers of {len(runs)} runs recorded"]
    if chaotic:
        parts.append(f"{chaotic} of them chaotic and not gated as numbers")
    if changes:
        parts.append(f"{len(changes)} changed")
    return f"{scenario}: {', '.join(parts)}"


def table(changes: Sequence[Change]) -> Table:
    """Lay out old and new of everything that changed.

    Parameters
    ----------
    changes
        As of `slipctl.regression.record.changes`, in the units of the metrics.
    """
    from rich import box
    from rich.table import Table

    laid = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for heading in ("run", "metric"):
        laid.add_column(heading, overflow="fold")
    for heading in ("old", "new", "change", "tolerance"):
        laid.add_column(heading, justify="right", overflow="fold")
    last = None
    for change in changes:
        run = _run(change)
        before, after = change["before"], change["after"]
        laid.add_row(
            "" if run == last else run,
            change["metric"],
            _value(before),
            _value(after),
            _percent(before, after),
            _tolerance(before, after),
        )
        last = run
    return laid


def _run(change: Change) -> str:
    varied = [f"{key} {value_text(value)}" for key, value in change["varied"].items()]
    seed = [] if "seed" in change["varied"] else [f"seed {change['seed']}"]
    return ", ".join([change["controller"], *varied, *seed])


def _value(entry: Mapping[str, Any] | str | None) -> str:
    if entry is None:
        return "–"
    if isinstance(entry, str):
        return entry
    return "none" if entry["value"] is None else f"{entry['value']:.6g}"


def _percent(before: Any, after: Any) -> str:
    if not isinstance(before, Mapping) or not isinstance(after, Mapping):
        return ""
    was, now = before["value"], after["value"]
    if was == now:
        return "same"
    return f"{(now - was) / abs(was):+.2%}" if was and now is not None else ""


def _tolerance(before: Any, after: Any) -> str:
    """Say the new tolerance, and the old one where it differs."""
    if not isinstance(before, Mapping) or not isinstance(after, Mapping):
        return ""
    was, now = _gate(before), _gate(after)
    return now if was == now else f"{was} → {now}"


def _gate(entry: Mapping[str, Any]) -> str:
    return "chaotic" if entry["gate"] == "verdict" else f"{entry['tolerance']:.1e}"
