"""``slipctl check``."""

from __future__ import annotations

import json
import sys
from typing import TYPE_CHECKING, Annotated

import typer

from slipctl.cli.certify import RequireCertified, require
from slipctl.cli.exits import BadInput, Exit
from slipctl.cli.options import Json, Quiet, Threads
from slipctl.cli.outputs import (
    Artefacts,
    Junit,
    check_junit,
    judged,
    record_failing,
    write_outputs,
)
from slipctl.cli.progress import interruptible, progress_bar
from slipctl.cli.recording import reason_to_record, record_all

if TYPE_CHECKING:
    from collections.abc import Sequence

    from slipctl.regression import Report
    from slipctl.scenario import Scenario


NAMED = 6
"""Scenarios that a message lists."""


def check(
    scenarios: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="SCENARIO",
            help="Scenario files or names; by default all with a baseline.",
            show_default=False,
        ),
    ] = None,
    record: Annotated[
        bool, typer.Option("--record", help="Record a first baseline: numbers and measured tolerances.")
    ] = False,
    update: Annotated[
        bool, typer.Option("--update", help="Record it again, in place of the old one; needs --reason.")
    ] = False,
    reason: Annotated[
        str | None,
        typer.Option("--reason", metavar="TEXT", help="Why the numbers may change; kept in the baseline."),
    ] = None,
    against: Annotated[
        str | None,
        typer.Option(
            "--against",
            metavar="REV|RUN",
            help="Compare with another git revision, run here and now, or with a run folder.",
        ),
    ] = None,
    junit: Junit = None,
    artefacts: Artefacts = "runs/check",
    json_output: Json = False,
    quiet: Quiet = False,
    threads: Threads = None,
    require_certified: RequireCertified = False,
) -> None:
    """Run scenarios and compare them with their committed baselines.

    Worse than recorded, or another status: exit 1. No sound baseline: exit 3, unless something else failed.
    """
    why = reason_to_record(record, update, reason)
    if against is not None and why is not None:
        raise BadInput("--against compares and records nothing: it does not go with --record or --update")
    check_junit(junit, why is None)
    from slipctl import regression

    if why is not None and not scenarios:
        raise BadInput(_which_to_record(regression.recorded_scenarios(), record))
    names = scenarios or regression.recorded_scenarios()
    if not names:
        print(
            "no scenario has a baseline; record one: slipctl check NAME --record",
            file=sys.stderr,
        )
        raise typer.Exit(Exit.NOT_JUDGED)
    loaded = _read(names)
    if require_certified:
        require(loaded)
    if why is not None:
        record_all(names, loaded, why, record, threads, json_output, quiet)
        return
    if against is not None:
        _look_up(names, against)
    reports, told = [], []
    for name, scenario in zip(names, loaded, strict=True):
        with interruptible(f"interrupted; {name} was not judged"), progress_bar(quiet) as progress:
            if against is None:
                report = regression.check(name, threads, progress)
            else:
                report = regression.against(name, against, threads, progress)
        reports.append(report)
        for note in report.notes:
            print(f"{report.scenario}: {note}", file=sys.stderr)
        if not json_output and not quiet:
            _show(name, report)
        command = record_failing(name, scenario, report, artefacts, threads)
        told.append(judged(name, report, command))
    status = verdict(reports)
    if not write_outputs(told, junit, json_output):
        status = status or Exit.NOT_JUDGED
    if json_output and status < Exit.BAD_INPUT:
        print(json.dumps(as_json(reports, passed=status == Exit.GOOD), allow_nan=False, ensure_ascii=False))
    if json_output or quiet:
        _say_failures(reports)
    if status:
        raise typer.Exit(status)


def verdict(reports: Sequence[Report]) -> Exit:
    """Exit status of several scenarios: a failed gate outweighs one that could not be judged."""
    if any(report.failed for report in reports):
        return Exit.GATE_FAILED
    return Exit.GOOD if all(report.judged for report in reports) else Exit.NOT_JUDGED


def as_json(reports: Sequence[Report], passed: bool) -> dict:
    """Give the reports as the contract's JSON object."""
    results = [finding.json() for report in reports for finding in report.findings]
    return {"passed": passed, "results": results}


def _read(names: Sequence[str]) -> list[Scenario]:
    """Read every scenario before the first is run: a misspelt name must not cost minutes."""
    from slipctl.scenario import load

    return [load(name) for name in names]


def _which_to_record(recorded: Sequence[str], first: bool) -> str:
    """Say that all baselines at once are not what anyone means."""
    if first:
        return "--record needs to be told which scenario: slipctl check SCENARIO --record"
    text = "--update needs to be told which scenario: slipctl check SCENARIO --update --reason '…'"
    named = ", ".join(recorded[:NAMED]) + (", …" if len(recorded) > NAMED else "")
    return f"{text}; with a baseline: {named}" if recorded else text


def _look_up(names: Sequence[str], against: str) -> None:
    from slipctl.regression import UnknownRevision, look_up

    try:
        look_up(names, against)
    except UnknownRevision as error:
        raise BadInput(str(error)) from None


def _show(name: str, report: Report) -> None:
    from rich.console import Console
    from rich.text import Text

    from slipctl.report.certificate import standing_line
    from slipctl.report.findings import lines

    console = Console(highlight=False)
    findings = [finding.json() for finding in report.findings]
    said = judged(name, report, None)
    for line in lines(report.scenario, findings, said.update, said.since):
        console.print(line, soft_wrap=isinstance(line, Text))
    certified = standing_line(report.certified, report.model)
    if certified is not None:
        console.print(f"  {certified}", markup=False, soft_wrap=True)


def _say_failures(reports: Sequence[Report]) -> None:
    from slipctl.report.findings import sentence

    for report in reports:
        for finding in report.findings:
            if finding.verdict.failed or not finding.verdict.judged:
                print(sentence(finding.json()), file=sys.stderr)
