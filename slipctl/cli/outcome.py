"""What is said of a run that has ended: on standard output its results, on standard error what went wrong."""

from __future__ import annotations

import json
import sys
from collections import Counter
from typing import TYPE_CHECKING

from slipctl.cli.exits import DEFECT, Exit

if TYPE_CHECKING:
    from slipctl.experiment import Result

NAMED = 5
"""Failed runs that are named one by one; all of them stand in the manifest."""


def report(result: Result, json_output: bool, quiet: bool) -> Exit:
    """Say what came of a run, and return the exit status.

    Parameters
    ----------
    result : Result
    json_output, quiet : bool
        Whether one JSON object, or nothing, is printed instead of a table.

    Returns
    -------
    Exit
        ``NOT_JUDGED`` where no run could be simulated, or one of a world alone could not.
    """
    alone = is_alone(result)
    for note in result.manifest.get("robot_notes", ()):
        print(f"robot: {note}", file=sys.stderr)
    _say_ended_early(result)
    _say_failures(result, alone)
    if alone and _rows_of_failed(result):
        print(f"the rows before are in {result.folder}: {result.recording_note}", file=sys.stderr)
        print(DEFECT, file=sys.stderr)
        return Exit.NOT_JUDGED
    if result.failures and len(result.failures) == result.metrics.num_rows:
        print("no run could be simulated", file=sys.stderr)
        return Exit.NOT_JUDGED
    if json_output:
        _print_json(result)
    elif not quiet:
        _show(result)
    return Exit.GOOD


def is_alone(result: Result) -> bool:
    """Whether it was one world alone, so that no other is left to be judged where a run of it failed."""
    return not result.varied or len(result.manifest.get("only_worlds", ())) == 1


def _rows_of_failed(result: Result) -> bool:
    """Whether a run that failed has rows: what its simulation had done before it raised."""
    ends = zip(result.metrics["status"].to_pylist(), result.metrics["end_time"].to_pylist(), strict=True)
    return any(status == "failed" and end is not None for status, end in ends)


def _print_json(result: Result) -> None:
    """Print the one object run by run: of many runs it would fill the memory."""
    write = sys.stdout.write
    write(json.dumps(result.json_head(), allow_nan=False, ensure_ascii=False)[:-1] + ', "runs": [')
    for index, run in enumerate(result.json_runs()):
        write((", " if index else "") + json.dumps(run, allow_nan=False, ensure_ascii=False))
    write("]}\n")
    sys.stdout.flush()


def _show(result: Result) -> None:
    from rich.console import Console

    from slipctl.report import many
    from slipctl.report.certificate import standing_line
    from slipctl.report.table import results

    console = Console(highlight=False)
    console.print(result.manifest["scenario"], style="bold", markup=False)
    if result.manifest.get("worlds", 1) > many.SHOWN:
        for text in many.lines(result.metrics, result.varied):
            console.print(text, markup=False, soft_wrap=True)
    else:
        payload = result.json()
        for line in results(payload, result.metrics.column("end_time").to_pylist()):
            console.print(line, soft_wrap=True)
    standing = result.manifest.get("certified")
    certified = standing and standing_line(standing, result.manifest["scenario_file"]["robot"]["model"])
    if certified is not None:
        console.print(f"\n{certified}", markup=False, soft_wrap=True)
    notes = [result.recording_note]
    if not result.signals_note.endswith("every row of every run"):
        notes.append(result.signals_note)
    console.print(f"\n{' · '.join([*notes, str(result.folder)])}", markup=False, soft_wrap=True)


def _say_ended_early(result: Result) -> None:
    counts = Counter(result.metrics.column("status").to_pylist())
    ended = {status: count for status, count in counts.items() if status != "completed"}
    if ended:
        parts = ", ".join(f"{count} {status}" for status, count in ended.items())
        total = result.metrics.num_rows
        print(f"{sum(ended.values())} of {total} runs ended early: {parts}", file=sys.stderr)


def _say_failures(result: Result, alone: bool) -> None:
    if not result.failures:
        return
    from slipctl.experiment.chunk import ended_its_process
    from slipctl.experiment.chunkfiles import resume_command
    from slipctl.experiment.replay import replay_command

    told: set[int] = set()
    for failed in result.failures[:NAMED]:
        world = failed["world"]
        print(f"world {world} ({failed['controller']}) failed: {failed['failure']}", file=sys.stderr)
        if result.folder is not None and world not in told and not alone:
            print(f"  run it alone: {replay_command(result.folder, world)}", file=sys.stderr)
        told.add(world)
    more = len(result.failures) - NAMED
    if more > 0:
        print(f"and {more} more, listed under failures in {result.folder}/manifest.json", file=sys.stderr)
    ended = len({failed["world"] for failed in result.failures if ended_its_process(failed["failure"])})
    if ended and result.folder is not None:
        who = "1 world ended its" if ended == 1 else f"{ended} worlds ended their"
        print(
            f"{who} worker processes; if the machine was to blame, put that right and try again: "
            f"{resume_command(result.folder)}",
            file=sys.stderr,
        )
