"""Record what a scenario gives, with tolerances measured from the runs beside it."""

from __future__ import annotations

import datetime
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipctl.experiment import Result
from slipctl.regression.baseline import Baseline, CannotJudge, Number, read, run_key, write
from slipctl.regression.check import Progress, Report, baseline_file, compare, report, run
from slipctl.regression.origin import Origin
from slipctl.regression.spread import Neighbour, measure, neighbours
from slipctl.regression.tracks import ticks_of_runs, tracks_file, write_tracks
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
    OSError
        The baseline cannot be written.
    KeyboardInterrupt
        It was interrupted; the old baseline stands.
    """
    scenario = load(source)
    path = baseline_file(source, scenario)
    result = run(scenario, 1, progress)

    def run_beside(moved: Scenario, cores: int | None) -> Mapping[str, Any]:
        return run(moved, cores, progress).json()

    beside = neighbours(scenario, run_beside, threads)
    new = new_baseline(result, beside, reason)
    old = None
    try:
        old = read(path)
        said = compare(scenario, old, result)
    except CannotJudge as error:
        notes = (f"nothing to compare with: {error}",) if path.exists() else ()
        said = report(scenario, result, (), notes)
    write_with_tracks(new, result, path)
    return Recording(said, path, new, changes(old, new))


def new_baseline(
    result: Result, beside: Mapping[tuple[str, str, int], Sequence[Neighbour]], reason: str
) -> Baseline:
    """Make a baseline of a result and of the runs beside it, as of `slipctl.regression.spread.neighbours`."""
    payload = result.json()
    return Baseline(
        scenario=payload["scenario"],
        scenario_id=payload["scenario_id"],
        model_id=payload["model_id"],
        versions=payload["versions"],
        machine=dict(Origin.of_manifest(result.manifest).machine),
        commit=_commit(),
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        reason=reason,
        runs=measure(payload, ticks_of_runs(result), beside),
    )


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


def _commit() -> str | None:
    """Git commit of this checkout, marked where code or models were changed since; None outside one."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    commit = _git(root, "rev-parse", "--short=12", "HEAD")
    changed = _git(root, "status", "--porcelain", "--", "slipctl", "models")
    return commit and commit + ("-dirty" if changed else "")


def _git(root: Path, *arguments: str) -> str | None:
    command = ["git", "-C", str(root), *arguments]
    try:
        answer = subprocess.run(command, capture_output=True, encoding="utf-8", check=True, timeout=10)
    except (OSError, subprocess.SubprocessError, UnicodeDecodeError):
        return None
    return answer.stdout.strip() or None
