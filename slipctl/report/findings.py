"""What ``slipctl check`` says of a scenario: a count, and a row for everything that is not the same."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

from slipctl.report.amounts import amount, change_text, interval_text, share_text
from slipctl.report.judged import FAILED, Finding, metric_text, run_text

if TYPE_CHECKING:
    from rich.console import RenderableType

QUIET = ("same", "claim_held")
"""Verdicts that are counted and not shown."""

WORDS = {
    "status_changed": "status changed",
    "unjudged": "not judged",
    "claim_held": "claim held",
    "claim_failed": "claim failed",
    "claim_open": "claim open",
}
PLURALS = {"claim_held": "claims held", "claim_failed": "claims failed", "claim_open": "claims open"}
STYLES = {"worse": "bold red", "status_changed": "bold red", "claim_failed": "bold red", "better": "green"}
ORDER = (
    "worse", "status_changed", "claim_failed", "missing", "extra", "unjudged", "claim_open",
    "better", "chaotic", "same", "claim_held",
)  # fmt: skip
"""Verdicts in the order in which they are counted."""

TITLES = ("metric", "baseline → current", "change", "tolerance", "verdict")
INDENT = 4


def lines(
    scenario: str, findings: Sequence[Finding], updated: bool = False, since: str | None = None
) -> list[RenderableType]:
    """Lay out the findings of one scenario for a terminal of 80 columns or more.

    Parameters
    ----------
    scenario
        Its name.
    findings
        All of them.
    updated
        Whether the present numbers have just been recorded, so that nothing is asked of the reader.
    since
        What the numbers are compared with, see `slipctl.report.judged.Judged.since`.

    Returns
    -------
    list of rich.text.Text or rich.padding.Padding
        The count; a table per run that is not the same, its columns below those of the others; a sentence per
        claim and per thing that could not be judged.
    """
    from rich.text import Text

    counts = Counter(finding["verdict"] for finding in findings)
    laid: list[RenderableType] = [Text.assemble((scenario, "bold"), f": {count_text(counts)}")]
    shown = [finding for finding in findings if finding["verdict"] not in QUIET]
    if since is not None and any(finding["claim"] is None and finding["metric"] for finding in shown):
        laid.append(Text(f"  compared with {since}", style="dim"))
    laid += _tables([finding for finding in shown if _is_number(finding)])
    for finding in shown:
        if not _is_number(finding):
            laid.append(Text("  " + _short(finding), style=STYLES.get(finding["verdict"], "yellow")))
    if counts["better"] and not updated and not any(counts[verdict] for verdict in FAILED):
        laid.append(Text("  better than the baseline: record it with --update --reason '…'", style="green"))
    return laid


def count_text(counts: Mapping[str, int]) -> str:
    """Say how many findings of each verdict there are: ``2 worse, 194 same, 3 claims held``."""
    parts = []
    for verdict in (*ORDER, *(name for name in counts if name not in ORDER)):
        count = counts.get(verdict, 0)
        word = WORDS.get(verdict, verdict)
        if count:
            parts.append(f"{count} {word if count == 1 else PLURALS.get(verdict, word)}")
    return ", ".join(parts) or "recorded for the first time"


def sentence(finding: Finding) -> str:
    """Say one finding in one line: which scenario and run, which number, both values and the tolerance."""
    if finding["controller"] is None and finding["claim"] is None:
        return f"{finding['scenario']}: {WORDS['unjudged']}: {finding['note']}"
    return f"{finding['scenario']}: {_short(finding)}"


def values_text(finding: Finding) -> str:
    """Say the values of a finding: both and the change, or what a claim requires and what was measured."""
    unit = finding["unit"]
    if finding["claim"] is not None:
        text = f"measured {amount(finding['current'], unit)}"
        if finding["interval"] is not None:
            text += f" ({interval_text(finding['interval'], unit)})"
        return f"{text}, required {amount(finding['baseline'], unit)}"
    text = change_text(finding["baseline"], finding["current"], unit)
    share = share_text(finding["baseline"], finding["current"])
    text += f" ({share})" if share else ""
    if finding["interval"] is not None:
        text += f", difference {interval_text(finding['interval'], unit)}"
    return text


def _short(finding: Finding) -> str:
    verdict = WORDS.get(finding["verdict"], finding["verdict"])
    run = run_text(finding)
    note = f" ({finding['note']})" if finding["note"] else ""
    if finding["claim"] is not None:
        where = f" [{run}]" if run else ""
        return f"{verdict}: {finding['claim']}{where}: {values_text(finding)}{note}"
    if finding["controller"] is None:
        return f"{verdict}: {finding['note']}"
    if finding["metric"] is None:
        return f"{run}: {verdict}{note}"
    tolerance = finding["tolerance"]
    allowed = f", tolerance {amount(tolerance, finding['unit'], digits=2)}" if tolerance is not None else ""
    if finding["metric"] == "status":
        return f"{run}: {verdict}: {values_text(finding)}{note}"
    return f"{run}: {verdict}: {finding['metric']} {values_text(finding)}{allowed}{note}"


def _is_number(finding: Finding) -> bool:
    return finding["claim"] is None and finding["metric"] not in (None, "status")


def _tables(findings: Sequence[Finding]) -> list[RenderableType]:
    from rich.padding import Padding
    from rich.table import Table
    from rich.text import Text

    rows = [_row(finding) for finding in findings]
    widths = [max(map(len, column)) for column in zip(TITLES, *rows, strict=True)]
    laid: list[RenderableType] = []
    pairs = zip(findings, rows, strict=True)
    for place, (run, group) in enumerate(groupby(pairs, key=lambda pair: run_text(pair[0]))):
        table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), show_header=place == 0)
        for title, width in zip(TITLES, widths, strict=True):
            justify = "right" if title in ("change", "tolerance") else "left"
            least = width if title != TITLES[-1] else None  # no blanks at the end of a line
            table.add_column(title, min_width=least, justify=justify, overflow="fold", header_style="dim")
        for finding, row in group:
            table.add_row(*row[:-1], Text(row[-1], style=STYLES.get(finding["verdict"], "yellow")))
        laid += [Text(f"  {run}", style="bold"), Padding(table, (0, 0, 0, INDENT), expand=False)]
    # many numbers share one note: it is said once
    notes = dict.fromkeys(finding["note"] for finding in findings if finding["note"])
    return laid + [Text(f"  {note}", style="dim") for note in notes]


def _row(finding: Mapping[str, Any]) -> tuple[str, ...]:
    unit, tolerance = finding["unit"], finding["tolerance"]
    share = share_text(finding["baseline"], finding["current"])
    if finding["interval"] is not None:
        # in place of the share: both are too wide for 80 columns
        share = interval_text(finding["interval"], unit)
    return (
        metric_text(finding["metric"]),
        change_text(finding["baseline"], finding["current"], unit),
        share,
        "" if tolerance is None else amount(tolerance, unit, digits=2),
        str(WORDS.get(finding["verdict"], finding["verdict"])),
    )
