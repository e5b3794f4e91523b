"""What was judged of one scenario: all that tables, JUnit files and pull requests need to know of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from slipctl.report.amounts import relative_change
from slipctl.report.table import value_text

Finding = Mapping[str, Any]
"""One entry of ``results`` in the JSON output of ``slipctl check``."""

FAILED = ("worse", "status_changed", "claim_failed")
NOT_JUDGED = ("missing", "extra", "unjudged", "claim_open")


@dataclass(frozen=True)
class Judged:
    """One scenario.

    Attributes
    ----------
    scenario : str
        Its name.
    findings : sequence of Finding
        All of them.
    file : Path or None
        The scenario file; None where it is not known.
    commit, date : str or None
        What the baseline was recorded on, and when; None where there is no baseline.
    against : str or None
        What was compared with, where that is no baseline.
    notes : sequence of str
        What else is not as it was.
    command : str or None
        What opens the recordings of the runs that failed; None where there are none.
    """

    scenario: str
    findings: Sequence[Finding]
    file: Path | None = None
    commit: str | None = None
    date: str | None = None
    against: str | None = None
    notes: Sequence[str] = field(default_factory=tuple)
    command: str | None = None

    @property
    def since(self) -> str | None:
        """What the present numbers are compared with: ``commit 3f2a1b of 2026-11-20``."""
        if self.against is not None:
            return self.against
        parts = [f"commit {self.commit}" if self.commit else "", f"of {self.date}" if self.date else ""]
        return " ".join(part for part in parts if part) or None

    @property
    def failed(self) -> list[Finding]:
        """What closes the gate, worst first."""
        return worst_first(finding for finding in self.findings if finding["verdict"] in FAILED)

    @property
    def not_judged(self) -> list[Finding]:
        """What could not be compared."""
        return [finding for finding in self.findings if finding["verdict"] in NOT_JUDGED]

    @property
    def better(self) -> list[Finding]:
        """What is better than recorded, most first."""
        return worst_first(finding for finding in self.findings if finding["verdict"] == "better")


def run_text(finding: Finding) -> str:
    """Say which run is meant: ``robust_kinematic, ground.friction 0.16, seed 1``."""
    seed, varied = finding["seed"], finding["varied"]
    parts = [finding["controller"]] if finding["controller"] is not None else []
    parts += [f"{key} {value_text(value)}" for key, value in varied.items()]
    parts += [f"seed {seed}"] if seed is not None and "seed" not in varied else []
    return ", ".join(parts)


def metric_text(metric: str) -> str:
    """Write a metric's name for people."""
    return metric.replace("_", " ").replace("cross track", "cross-track")


def severity(finding: Finding) -> tuple[int, float]:
    """Say how bad a finding is: statuses and claims before numbers, those by share of their value."""
    if finding["verdict"] in ("status_changed", "claim_failed") or finding["current"] is None:
        return 1, 0.0
    share = relative_change(finding["baseline"], finding["current"])
    return 0, float("inf") if share is None else abs(share)


def worst_first(findings: Iterable[Finding]) -> list[Finding]:
    """Sort by `severity`; what is equally bad keeps its order."""
    return sorted(findings, key=severity, reverse=True)
