"""What ``slipctl check`` leaves besides its table: a JUnit file, recordings, annotations, a summary."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from slipctl.cli.exits import BadInput
from slipctl.cli.progress import interruptible

if TYPE_CHECKING:
    from slipctl.regression import Report
    from slipctl.report.judged import Judged
    from slipctl.scenario import Scenario

NONE = "none"
"""In place of a folder: no recordings."""

Junit = Annotated[
    Path | None,
    typer.Option("--junit", metavar="FILE", help="Write a JUnit file, for CI systems.", show_default=False),
]
Artefacts = Annotated[
    str,
    typer.Option(
        "--artefacts",
        metavar="DIR|none",
        help="Folder for recordings of the runs that fail, now and beside the baseline.",
    ),
]


def record_failing(
    source: str, scenario: Scenario, report: Report, artefacts: str, threads: int | None
) -> str | None:
    """Record the runs that failed, and say on standard error how to open the recordings.

    A recording that cannot be written does not undo the verdict: that is said, and the verdict stands.

    Returns
    -------
    str or None
        The command that opens the recordings; None where there are none.
    """
    if artefacts == NONE or not report.failed:
        return None
    from slipctl import regression
    from slipctl.experiment.folder import OutputError
    from slipctl.view import RecordingError

    compared = (report.recorded or {}).get("against") is None
    baseline = regression.baseline_file(source, scenario) if compared else None
    with interruptible(f"interrupted; {scenario.name} failed and was not recorded"):
        try:
            made = regression.record_failing(
                scenario, report.findings, Path(artefacts), baseline, threads=threads
            )
        except (OutputError, RecordingError, OSError) as error:
            print(f"{scenario.name}: no recordings: {error}", file=sys.stderr)
            return None
    if made is None:
        return None
    for note in made.notes:
        print(f"{scenario.name}: {note}", file=sys.stderr)
    print(f"{scenario.name}: look at what failed: {made.command}", file=sys.stderr)
    return made.command


def judged(source: str, report: Report, command: str | None) -> Judged:
    """Put together what files and pull requests say of a scenario."""
    from slipctl import shipped
    from slipctl.report.judged import Judged

    recorded = report.recorded or {}
    return Judged(
        scenario=report.scenario,
        findings=[finding.json() for finding in report.findings],
        file=shipped.scenario_path(source) if source in shipped.scenario_names() else Path(source),
        commit=recorded.get("commit"),
        date=recorded.get("date"),
        against=recorded.get("against"),
        notes=report.notes,
        command=command,
    )


def check_junit(junit: Path | None, compares: bool) -> None:
    """Refuse a JUnit file that cannot be, before minutes are spent.

    Raises
    ------
    BadInput
        One is wanted though nothing is compared, or in place of a folder.
    """
    if junit is None:
        return
    if not compares:
        raise BadInput("--junit is of a comparison: it does not go with --record or --update")
    if junit.is_dir():
        raise BadInput(f"--junit: {junit} is a folder; name a file in it, for instance {junit / 'check.xml'}")


def write_outputs(scenarios: Sequence[Judged], junit: Path | None, json_output: bool) -> None:
    """Write the JUnit file and tell GitHub, where it runs this.

    Raises
    ------
    BadInput
        The JUnit file cannot be written.
    """
    if junit is not None:
        from slipctl.report.junit import write

        try:
            write(junit, scenarios)
        except OSError as error:
            raise BadInput(f"--junit: cannot write {junit}: {error.strerror or error}") from None
    from slipctl.report import github

    if not github.active(os.environ):
        return
    workspace = os.environ.get("GITHUB_WORKSPACE")
    # what is read by a program has standard output to itself
    stream = sys.stderr if json_output else sys.stdout
    for line in github.workflow_commands(scenarios, Path(workspace) if workspace else None):
        print(line, file=stream)
    summary = os.environ.get("GITHUB_STEP_SUMMARY")
    if summary:
        try:
            github.append_summary(Path(summary), scenarios)
        except OSError as error:
            print(f"no step summary: {error}", file=sys.stderr)
