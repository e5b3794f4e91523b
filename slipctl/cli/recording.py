"""``slipctl check --record`` and ``--update``."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from slipctl.cli.exits import BadInput
from slipctl.cli.progress import interruptible, progress_bar

if TYPE_CHECKING:
    from slipctl.regression import Recording
    from slipctl.scenario import Scenario

FIRST = "first record"
"""The reason of a first baseline, unless another is given."""


def reason_to_record(record: bool, update: bool, reason: str | None) -> str | None:
    """Say why a baseline is recorded; None where none is.

    Raises
    ------
    BadInput
        The options contradict each other, or the reason is missing.
    """
    said = (reason or "").strip()
    if record and update:
        raise BadInput("--record makes a first baseline, --update replaces one: give one of them")
    if update and not said:
        raise BadInput(
            "--update needs --reason: say why the numbers may change, for those who read the baseline later"
        )
    if reason is not None and not (record or update):
        raise BadInput("--reason goes with --update or --record only")
    if update:
        return said
    return (said or FIRST) if record else None


def record_all(
    names: Sequence[str],
    loaded: Sequence[Scenario],
    why: str,
    first: bool,
    threads: int | None,
    json_output: bool,
    quiet: bool,
) -> None:
    """Record the baselines of scenarios and show what that changes.

    Raises
    ------
    BadInput
        With `first`, one of them has a baseline.
    """
    from slipctl import regression

    if first:
        _refuse_recorded(names, loaded)
    results = []
    for name in names:
        with interruptible(f"interrupted; {name} was not recorded"), progress_bar(quiet) as progress:
            recording = regression.record(name, why, threads, progress)
        for note in recording.report.notes:
            print(f"{recording.report.scenario}: {note}", file=sys.stderr)
        results += [finding.json() for finding in recording.report.findings]
        if not json_output and not quiet:
            _show(recording)
        print(f"{recording.path} written", file=sys.stderr)
    if json_output:
        print(json.dumps({"passed": True, "results": results}, allow_nan=False, ensure_ascii=False))


def _refuse_recorded(names: Sequence[str], loaded: Sequence[Scenario]) -> None:
    """Refuse to put a first baseline where there is one: nobody would have said why."""
    from slipctl.regression import baseline_file

    for name, scenario in zip(names, loaded, strict=True):
        path = baseline_file(name, scenario)
        if path.exists():
            raise BadInput(
                f"{path} exists; to replace it, say why: slipctl check {name} --update --reason '…'"
            )


def _show(recording: Recording) -> None:
    from rich.console import Console

    from slipctl.report.changes import summary, tables

    console = Console(highlight=False)
    runs = [run.model_dump() for run in recording.baseline.runs]
    console.print(summary(recording.report.scenario, runs, recording.changes), markup=False, soft_wrap=True)
    if recording.changes:
        for laid in tables(recording.changes):
            console.print(laid)
