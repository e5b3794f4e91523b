"""``slipctl run`` and ``slipctl sweep``."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from slipctl.cli.certify import RequireCertified, require
from slipctl.cli.exits import Exit
from slipctl.cli.options import Json, Out, Quiet, Record, Source, Threads, View
from slipctl.cli.progress import interruptible, progress_bar

if TYPE_CHECKING:
    from slipctl.experiment import Result
    from slipctl.scenario import Scenario

RUNS = Path("runs")


def run(
    source: Source,
    out: Out = RUNS,
    record: Record = "auto",
    view: View = False,
    json_output: Json = False,
    quiet: Quiet = False,
    threads: Threads = None,
    require_certified: RequireCertified = False,
) -> None:
    """Run a scenario, the whole grid where it has one, and show its controllers side by side."""
    from slipctl.scenario import load

    scenario = load(source)
    if require_certified:
        require([scenario])
    execute(scenario, out, record, view, json_output, quiet, threads)


def sweep(
    source: Source,
    over: Annotated[
        list[str] | None,
        typer.Option(
            "--over",
            metavar="KEY=VALUES",
            help="Key to vary and its values: 0.1,0.2 or FROM:TO:COUNT or FROM:TO:COUNT:log. Repeatable.",
        ),
    ] = None,
    out: Out = RUNS,
    record: Record = "auto",
    view: View = False,
    json_output: Json = False,
    quiet: Quiet = False,
    threads: Threads = None,
) -> None:
    """Run a scenario over grids given here; those of the file stay unless the same key is given."""
    from slipctl.scenario import load, sweep_over

    scenario = sweep_over(load(source), over or [])
    execute(scenario, out, record, view, json_output, quiet, threads)


def execute(
    scenario: Scenario,
    out: Path,
    record: str,
    view: bool,
    json_output: bool,
    quiet: bool,
    threads: int | None,
) -> None:
    """Run a scenario and report it; ends the command with the exit status."""
    from slipctl import experiment
    from slipctl.experiment.record import check_choice

    check_choice(record)
    nothing = "interrupted before any run was finished; nothing was written"
    with interruptible(nothing), progress_bar(quiet) as progress:
        result = experiment.run(scenario, out=out, record=record, threads=threads, progress=progress)
    if result.interrupted:
        done = result.metrics.num_rows
        print(f"interrupted; the {done} finished runs are in {result.folder}", file=sys.stderr)
        raise typer.Exit(Exit.INTERRUPTED)
    for note in result.manifest.get("robot_notes", ()):
        print(f"robot: {note}", file=sys.stderr)
    payload = result.json()
    _say_ended_early(payload["runs"])
    if json_output:
        print(json.dumps(payload, allow_nan=False, ensure_ascii=False))
    elif not quiet:
        _show(result, payload, scenario.robot.model)
    if view:
        from slipctl.cli.view import show_folder

        show_folder(result.folder)


def _show(result: Result, payload: dict[str, Any], model: str) -> None:
    from rich.console import Console

    from slipctl.report.certificate import standing_line
    from slipctl.report.table import results

    console = Console(highlight=False)
    console.print(payload["scenario"], style="bold", markup=False)
    for line in results(payload, result.metrics.column("end_time").to_pylist()):
        console.print(line, soft_wrap=True)
    certified = standing_line(result.manifest.get("certified"), model)
    if certified is not None:
        console.print(f"\n{certified}", markup=False, soft_wrap=True)
    console.print(f"\n{result.recording_note} · {result.folder}", markup=False, soft_wrap=True)


def _say_ended_early(runs: Sequence[dict[str, Any]]) -> None:
    counts: dict[str, int] = {}
    for entry in runs:
        if entry["status"] != "completed":
            counts[entry["status"]] = counts.get(entry["status"], 0) + 1
    if counts:
        parts = ", ".join(f"{count} {status}" for status, count in counts.items())
        print(f"{sum(counts.values())} of {len(runs)} runs ended early: {parts}", file=sys.stderr)
