"""Record what a scenario gives, with tolerances measured from the runs beside it."""

from __future__ import annotations

import datetime
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from slipctl.experiment import Result
from slipctl.experiment.folder import OutputError
from slipctl.regression.baseline.file import Baseline, CannotJudge, Number, read, run_key, write
from slipctl.regression.baseline.spread import Neighbour, measure, neighbours
from slipctl.regression.baseline.tracks import ticks_of_runs, tracks_file, write_tracks
from slipctl.regression.check import Progress, Report, baseline_file, compare, report, run
from slipctl.regression.git import commit_around
from slipctl.regression.judging.origin import Origin
from slipctl.regression.judging.ungated import only_status_judged
from slipctl.scenario import Scenario, load


@dataclass(frozen=True)
class Recording:
    """A baseline that was recorded.

    Attributes
    ----------
    report
        The new numbers judged by the old baseline, if there was a sound one.
    path
        The file that was written.
    baseline
        What is in it.
    changes
        Old and new of every number that is not the same, see `changes`.
    """

    report: Report
    path: Path
    baseline: Baseline
    changes: Sequence[Mapping[str, Any]]


def record(
    source: str, reason: str, threads: int | None = None, progress: Progress | None = None
) -> Recording:
    """Record the baseline of a scenario and its tracks, in place of what there was.

    Besides the run itself, on one thread, the scenario is run from starts moved by a nanometre and a
    nanoradian on one to three threads, and with half the timestep.

    Parameters
    ----------
    source : str
        Name or path of the scenario.
    reason : str
        Kept in the file, for those who read it later.
    threads : int, optional
        For the run with half the timestep.
    progress : callable, optional

    Returns
    -------
    Recording

    Raises
    ------
    ScenarioError
        The scenario cannot be read.
    CannotJudge
        From the very same start a law gave something else: nothing was recorded.
    OutputError
        The baseline cannot be written, which is seen before anything is run.
    OSError
        Nor can it afterwards.
    KeyboardInterrupt
        It was interrupted; the old baseline stands.
    """
    scenario = load(source)
    path = baseline_file(source, scenario)
    try_to_write(path)
    result = run(scenario, 1, progress)

    def run_beside(moved: Scenario, cores: int | None) -> Mapping[str, Any]:
        return run(moved, cores, progress).json()

    beside = neighbours(scenario, run_beside, threads)
    new = new_baseline(result, beside, reason, path)
    old = None
    try:
        old = read(path, source)
        said = compare(scenario, old, result)
    except CannotJudge as error:
        notes = (f"nothing to compare with: {error}",) if path.exists() else ()
        said = report(scenario, result, (), notes)
    silent = only_status_judged(new.runs, scenario.expect)
    said = replace(said, notes=tuple(dict.fromkeys((*said.notes, *silent))))
    write_with_tracks(new, result, path)
    return Recording(said, path, new, changes(old, new))


def new_baseline(
    result: Result, beside: Mapping[tuple[str, str, int], Sequence[Neighbour]], reason: str, path: Path
) -> Baseline:
    """Make a baseline of a result and of the runs beside it.

    The runs beside are as of `slipctl.regression.baseline.spread.neighbours`. The baseline names the commit
    of the repository that will hold the file at `path`: what its readers can go to.
    """
    payload = result.json()
    return Baseline(
        scenario=payload["scenario"],
        scenario_id=payload["scenario_id"],
        model_id=payload["model_id"],
        versions=payload["versions"],
        machine=dict(Origin.of_manifest(result.manifest).machine),
        commit=commit_around(path.parent, besides=path.parent.name),
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        reason=reason,
        runs=measure(payload, ticks_of_runs(result), beside),
    )


def try_to_write(path: Path) -> None:
    """See that a baseline can be written, before minutes are spent on it; nothing is left behind.

    Raises
    ------
    OutputError
        It cannot; the message says why.
    """
    beside = path.with_name(f".{path.name}.{os.getpid()}.part")
    made = not path.parent.exists()
    try:
        if path.is_dir():
            raise IsADirectoryError(None, "there is a folder in its place; move it away")
        path.parent.mkdir(parents=True, exist_ok=True)
        beside.touch()
        beside.unlink()
        if made:
            path.parent.rmdir()
    except OSError as error:
        raise OutputError(f"cannot write the baseline {path}: {error.strerror or error}") from None


def write_with_tracks(baseline: Baseline, result: Result, path: Path) -> None:
    """Write a baseline, and the tracks of its runs beside it.

    Raises
    ------
    OSError
        The folder is not writable.
    """
    about = {"scenario_id": baseline.scenario_id, "date": baseline.date, "commit": baseline.commit or ""}
    # The tracks go first: without a baseline they are not looked at.
    write_tracks(result, tracks_file(path), about)
    write(baseline, path)


def changes(old: Baseline | None, new: Baseline) -> list[dict[str, Any]]:
    """List old and new of every number that is not the same, run by run.

    Returns
    -------
    list of dict
        ``controller``, ``varied``, ``seed``, ``metric`` and, for the old and the new file, ``before`` and
        ``after``: a number as in the file, a status where the metric is ``status``, None where the run is not
        there. Empty where there was no old file.
    """
    if old is None:
        return []
    before = {run_key(run.controller, run.varied, run.seed): run for run in old.runs}
    after = {run_key(run.controller, run.varied, run.seed): run for run in new.runs}
    rows = []
    for key in dict.fromkeys([*before, *after]):
        was, now = before.get(key), after.get(key)
        either = now or was
        assert either is not None, "the key is from one of the two"
        which = {"controller": either.controller, "varied": either.varied, "seed": either.seed}
        if was is None or now is None or was.status != now.status:
            ends = {"before": was and was.status, "after": now and now.status}
            rows.append({**which, "metric": "status", **ends})
        if was is None or now is None:
            continue
        for metric, number in now.metrics.items():
            if _differ(was.metrics[metric], number):
                ends = {"before": was.metrics[metric].model_dump(), "after": number.model_dump()}
                rows.append({**which, "metric": metric, **ends})
    return rows


def _differ(was: Number, now: Number) -> bool:
    return (was.value, was.tolerance, was.tolerance_elsewhere, was.gate) != (
        now.value, now.tolerance, now.tolerance_elsewhere, now.gate,
    )  # fmt: skip
