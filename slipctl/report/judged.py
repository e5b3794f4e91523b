"""What was judged of one scenario: all that tables, JUnit files and pull requests need to know of it."""

from __future__ import annotations

import shlex
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
    source : str or None
        Name or path of the scenario as the user gave it, for commands that name it; None where its baseline
        is not what was compared with.
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
    source: str | None = None
    file: Path | None = None
    commit: str | None = None
    date: str | None = None
    against: str | None = None
    notes: Sequence[str] = field(default_factory=tuple)
    command: str | None = None

    @property
    def since(self) -> str | None:
        """What the present numbers are compared with, see `since_text`."""
        return self.against if self.against is not None else since_text(self.commit, self.date)

    @property
    def update(self) -> str | None:
        """The command that records the present numbers, if there is one."""
        return None if self.source is None else update_command(self.source)

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


def since_text(commit: str | None, date: str | None) -> str | None:
    """Say which record is meant: ``commit 3f2a1b of 2026-11-20``, or ``the record of 2026-11-20``."""
    if commit is None:
        return None if date is None else f"the record of {date}"
    return f"commit {commit}" + ("" if date is None else f" of {date}")


def update_command(source: str) -> str:
    """Return the command that records one scenario again, to be pasted into a shell as it stands."""
    return f"slipctl check {shlex.quote(source)} --update --reason '…'"


def run_text(finding: Finding) -> str:
    """Say which run is meant: ``robust_kinematic, ground.friction 0.16, seed 1``."""
    seed, varied = finding["seed"], finding["varied"]
    parts = [finding["controller"]] if finding["controller"] is not None else []
    parts += [f"{key} {value_text(value)}" for key, value in varied.items()]
    parts += [f"seed {seed}"] if seed is not None and "seed" not in varied else []
    return ", ".join(parts)


def claim_text(finding: Finding) -> str:
    """Write a claim with the metric that was judged: one claim may be about two."""
    metric = finding["metric"]
    about = "" if metric in (None, "status") else f": {metric_text(metric)}"
    return f"{finding['claim']}{about}"


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
