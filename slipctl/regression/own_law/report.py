"""What came of a law of one's own in one scenario, and how it is said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from slipctl.experiment import Result
from slipctl.metrics import UNITS
from slipctl.regression.baseline.file import Baseline
from slipctl.regression.judging.findings import Finding, Verdict
from slipctl.report.amounts import change_text
from slipctl.report.changes import count_text as recorded_text
from slipctl.report.findings import count_text, lines, sentence
from slipctl.report.judged import since_text

NOT_AS_RECORDED = (
    Verdict.WORSE,
    Verdict.STATUS_CHANGED,
    Verdict.MISSING,
    Verdict.EXTRA,
    Verdict.UNJUDGED,
)

WIDTH = 100
"""Columns of a table in a message."""


@dataclass(frozen=True)
class OwnLawReport:
    """What came of one law in one scenario.

    Attributes
    ----------
    scenario, label : str
    path : pathlib.Path
        The law's baseline.
    findings : tuple of Finding
        Its numbers against the baseline, then the claims.
    result : Result
        The run itself, with the listed controllers in it.
    baseline : Baseline
        What was compared with, or what was just recorded.
    notes : tuple of str
        What is different from when the baseline was recorded and does not stop the judgement.
    changes : tuple of dict or None
        Old and new of every number that recording changed, see `slipctl.regression.record.changes`; None
        where nothing was recorded.
    """

    scenario: str
    label: str
    path: Path
    findings: tuple[Finding, ...]
    result: Result
    baseline: Baseline
    notes: tuple[str, ...] = ()
    changes: tuple[dict[str, Any], ...] | None = None

    @property
    def name(self) -> str:
        """Scenario and law."""
        return f"{self.scenario}, {self.label}"

    @property
    def recorded(self) -> bool:
        """Whether the baseline was just written."""
        return self.changes is not None

    @property
    def passed(self) -> bool:
        """Whether nothing is worse, no claim fails and everything could be judged."""
        return not any(finding.verdict.failed or not finding.verdict.judged for finding in self.findings)

    @property
    def recordable(self) -> bool:
        """Whether a number or a status is not as recorded, so that recording it changes the outcome."""
        return any(finding.verdict in NOT_AS_RECORDED for finding in self.findings)

    @property
    def better(self) -> tuple[Finding, ...]:
        """The numbers that are better than recorded."""
        return tuple(finding for finding in self.findings if finding.verdict is Verdict.BETTER)

    def count_text(self) -> str:
        """Say how many findings of each verdict there are."""
        return count_text(Counter(str(finding.verdict) for finding in self.findings))

    def better_lines(self) -> list[str]:
        """Say what is better than recorded."""
        return [sentence(finding.json()) for finding in self.better]

    def recorded_text(self) -> str:
        """Say how many numbers were recorded, and how many of them are chaotic."""
        return recorded_text([run.model_dump() for run in self.baseline.runs], self.changes or ())

    def change_lines(self) -> list[str]:
        """Say old and new of every value that recording changed."""
        said = []
        for change in self.changes or ():
            before, after = (_value(change[end]) for end in ("before", "after"))
            if before != after:
                varied = "".join(f"{key} {value:g}: " for key, value in change["varied"].items())
                metric = change["metric"]
                said.append(f"{varied}{metric} {change_text(before, after, UNITS.get(metric))}")
        return said

    def text(self) -> str:
        """Lay out what was found, as plain text."""
        from rich.console import Console

        written = StringIO()
        console = Console(file=written, width=WIDTH, color_system=None, highlight=False)
        since = f"{since_text(self.baseline.commit, self.baseline.date)}: {self.baseline.reason}"
        said = [finding.json() for finding in self.findings]
        for line in [
            *lines(self.name, said, since=since),
            *(f"  {note}" for note in self.notes),
        ]:
            console.print(line, markup=False)
        return "\n".join(row.rstrip() for row in written.getvalue().splitlines())


def _value(end: Mapping[str, Any] | str | None) -> float | str | None:
    return end["value"] if isinstance(end, Mapping) else end
