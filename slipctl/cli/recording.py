"""``slipctl check --record`` and ``--update``."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from slipctl.cli.exits import BadInput, Exit
from slipctl.cli.progress import interruptible, progress_bar

if TYPE_CHECKING:
    from slipctl.regression import Finding, Recording
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

    A claim that does not hold, or is open, is said, and the baseline is written all the same.

    Raises
    ------
    BadInput
        With `first`, one of them has a baseline; or two of them would have the same one.
    OutputError
        A baseline cannot be written, which is seen before anything is run.
    typer.Exit
        With 1 where a claim failed, otherwise with 3 where one is open or a law cannot be recorded.
    """
    from slipctl import regression

    paths = _paths(names, loaded)
    if first:
        _refuse_recorded(names, paths)
    for path in paths:
        regression.try_to_write(path)
    findings: list[Finding] = []
    for name, path in zip(names, paths, strict=True):
        stands = "; the old baseline stands" if path.exists() else ""
        try:
            with (
                interruptible(f"interrupted; {name} was not recorded{stands}"),
                progress_bar(quiet) as progress,
            ):
                recording = regression.record(name, why, threads, progress)
        except regression.CannotJudge as error:
            print(f"{error}{stands}", file=sys.stderr)
            findings.append(regression.unjudged(path.stem, str(error)))
            continue
        for note in recording.report.notes:
            print(f"{recording.report.scenario}: {note}", file=sys.stderr)
        findings += recording.report.findings
        if not json_output and not quiet:
            _show(recording)
        _say_claims(recording)
        print(f"{recording.path} written", file=sys.stderr)
    status = _status(findings)
    if json_output and status < Exit.BAD_INPUT:
        results = [finding.json() for finding in findings]
        print(json.dumps({"passed": not status, "results": results}, allow_nan=False, ensure_ascii=False))
    if status:
        raise typer.Exit(status)


def _status(findings: Sequence[Finding]) -> Exit:
    """By what a new baseline does not excuse: the claims, and what could not be recorded at all."""
    counted = [finding for finding in findings if finding.claim is not None or finding.controller is None]
    if any(finding.verdict.failed for finding in counted):
        return Exit.GATE_FAILED
    return Exit.GOOD if all(finding.verdict.judged for finding in counted) else Exit.NOT_JUDGED


def _say_claims(recording: Recording) -> None:
    from slipctl.report.findings import sentence

    for finding in recording.report.findings:
        if finding.claim is not None and (finding.verdict.failed or not finding.verdict.judged):
            print(f"{sentence(finding.json())}; the baseline is written all the same", file=sys.stderr)


def _paths(names: Sequence[str], loaded: Sequence[Scenario]) -> list[Path]:
    """Say where each baseline will lie; two scenarios must not overwrite each other's."""
    from slipctl.regression import baseline_file

    found: dict[Path, str] = {}
    for name, scenario in zip(names, loaded, strict=True):
        path = baseline_file(name, scenario)
        if path in found:
            raise BadInput(
                f"{found[path]} and {name} share the baseline {path}: give them different names"
                if found[path] != name
                else f"{name} is named twice"
            )
        found[path] = name
    return list(found)


def _refuse_recorded(names: Sequence[str], paths: Sequence[Path]) -> None:
    """Refuse to put a first baseline where there is one: nobody would have said why."""
    from slipctl.report.judged import update_command

    for name, path in zip(names, paths, strict=True):
        if path.exists():
            raise BadInput(f"{path} exists; to replace it, say why: {update_command(name)}")


def _show(recording: Recording) -> None:
    from rich.console import Console

    from slipctl.report.changes import summary, tables

    console = Console(highlight=False)
    runs = [run.model_dump() for run in recording.baseline.runs]
    console.print(summary(recording.report.scenario, runs, recording.changes), markup=False, soft_wrap=True)
    if recording.changes:
        for laid in tables(recording.changes):
            console.print(laid)
