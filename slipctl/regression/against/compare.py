"""Hold a scenario against another git revision or a run folder, in place of its baseline."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from typing import Any

from slipctl import experiment
from slipctl.regression.against.paired import paired_differences
from slipctl.regression.against.reference import Reference, find
from slipctl.regression.baseline.file import Baseline, CannotJudge, RunBaseline, read, run_key
from slipctl.regression.baseline.gated import GATED
from slipctl.regression.baseline.spread import TIMESTEP, Neighbour, measure, scenarios_beside
from slipctl.regression.baseline.tracks import ticks_of_runs
from slipctl.regression.check import Report, baseline_file, run
from slipctl.regression.judging.findings import judge, unjudged
from slipctl.regression.judging.origin import Origin, differences, is_elsewhere
from slipctl.regression.judging.ungated import only_status_judged
from slipctl.scenario import Scenario, load, scenario_id

Progress = Callable[[int, int, str], None]

NUDGED = "start.x_offset"
"""The key that is moved, to either side, where there is no baseline to take tolerances from."""


def look_up(sources: Iterable[str], name: str) -> None:
    """See that a name can be compared with before anything is run.

    Raises
    ------
    UnknownRevision
        It is neither a run folder nor a revision of the checkout that holds a scenario.
    """
    for source in sources:
        # a scenario that is in no checkout has a report that says so
        with suppress(CannotJudge):
            find(source, name)


def against(source: str, name: str, threads: int | None = None, progress: Progress | None = None) -> Report:
    """Run a scenario as it is and compare it with what it gave elsewhere.

    Parameters
    ----------
    source : str
        Name or path of the scenario.
    name : str
        A git revision of the checkout that holds the scenario file, where it is run as it stood; or a run
        folder, which is read. A name that is both is the folder.
    threads : int, optional
    progress : callable, optional

    Returns
    -------
    Report
        Run by run as with a baseline, then controller by controller the mean differences with their
        intervals. A gated metric that is not there to compare with is not judged. Tolerances are those of the
        baseline, if there is one of this very scenario; otherwise they are measured here, from two starts
        moved by a nanometre.

    Raises
    ------
    ScenarioError
        The scenario cannot be read.
    UnknownRevision
        The name means nothing.
    KeyboardInterrupt
        It was interrupted: part of a scenario cannot be judged.
    """
    scenario = load(source)
    try:
        reference = find(source, name).reference(threads, progress)
        result = run(scenario, threads, progress)
        return _compare(source, scenario, reference, result, threads, progress)
    except CannotJudge as error:
        return Report(scenario.name, (unjudged(scenario.name, str(error)),))


def _compare(
    source: str,
    scenario: Scenario,
    reference: Reference,
    result: experiment.Result,
    threads: int | None,
    progress: Progress | None,
) -> Report:
    payload, now = result.json(), Origin.of_manifest(result.manifest)
    then = Origin.of_manifest(
        {
            "model_id": now.model_id,  # another robot is what is being judged, not another place
            "versions": reference.payload["versions"],
            "machine": now.machine if reference.machine is None else reference.machine,
        }
    )
    elsewhere = is_elsewhere(then, now)
    notes = [f"against {reference.label}", *reference.notes]
    for what, key in (("scenario", "scenario_id"), ("robot model", "model_id")):
        if reference.payload[key] != payload[key]:
            notes.append(f"another {what} than then, judged all the same")
    notes += differences(then, now)
    recorded = _recorded(source, scenario, payload)
    if recorded is None:
        notes.append("no baseline of this scenario: tolerances measured here, from moved starts")
        recorded = _measured(scenario, result, elsewhere, threads, progress)
    baseline = as_baseline(reference.payload, recorded, reference.label)
    notes += only_status_judged(baseline.runs)
    findings = judge(baseline, payload, elsewhere)
    findings += paired_differences(findings)
    absent = [
        metric for metric in GATED if any(metric not in run["metrics"] for run in reference.payload["runs"])
    ]
    if absent:
        why = f"{reference.label} does not hold {', '.join(absent)}"
        findings.append(unjudged(scenario.name, why))
    about = {"commit": reference.commit, "date": reference.date, "against": reference.label}
    # without the claims: they are about one result, not about a difference
    certified = result.manifest.get("certified")
    return Report(scenario.name, tuple(findings), ("; ".join(notes),), certified, scenario.robot.model, about)


def as_baseline(payload: Mapping[str, Any], recorded: Sequence[RunBaseline], label: str) -> Baseline:
    """Make a baseline that is kept nowhere: the numbers of one result with the tolerances of another.

    Parameters
    ----------
    payload
        The JSON output of the runs to compare with.
    recorded
        Runs of the present scenario with their tolerances.
    label
        What the result is called.

    Raises
    ------
    CannotJudge
        No run is among both.
    """
    known = {run_key(run.controller, run.varied, run.seed): run for run in recorded}
    runs = [
        (entry, known.get(run_key(entry["controller"], entry["varied"], entry["seed"])))
        for entry in payload["runs"]
    ]
    if all(like is None for _, like in runs):
        raise CannotJudge(f"{label} has no run with the controllers, worlds and seeds of this scenario")
    # Unchecked: these tolerances were measured around other values.
    return Baseline.model_construct(runs=[_with_tolerances(entry, like) for entry, like in runs])


def _with_tolerances(entry: Mapping[str, Any], like: RunBaseline | None) -> RunBaseline:
    metrics, statuses = {}, set()
    if like is not None:
        metrics = {
            metric: number.model_copy(update={"value": entry["metrics"][metric]})
            for metric, number in like.metrics.items()
            if metric in entry["metrics"]
        }
        statuses = {like.status, *like.statuses_seen} if like.statuses_seen else set()
    return RunBaseline.model_construct(
        controller=entry["controller"],
        varied=entry["varied"],
        seed=entry["seed"],
        status=entry["status"],
        # they are said where the run ends otherwise
        statuses_seen=sorted(statuses - {entry["status"]}),
        metrics=metrics,
    )


def _recorded(source: str, scenario: Scenario, payload: Mapping[str, Any]) -> list[RunBaseline] | None:
    """Return the runs of the baseline; None where there is no sound one of exactly this scenario."""
    try:
        baseline = read(baseline_file(source, scenario), source)
    except CannotJudge:
        return None
    held = {run_key(run.controller, run.varied, run.seed) for run in baseline.runs}
    made = {run_key(run["controller"], run["varied"], run["seed"]) for run in payload["runs"]}
    return baseline.runs if baseline.scenario_id == scenario_id(scenario) and made <= held else None


def _measured(
    scenario: Scenario,
    result: experiment.Result,
    elsewhere: bool,
    threads: int | None,
    progress: Progress | None,
) -> list[RunBaseline]:
    found: dict[tuple[str, str, int], list[Neighbour]] = {}
    for beside in scenarios_beside(scenario, threads):
        if beside.key == NUDGED or (elsewhere and beside.key == TIMESTEP):
            for entry in run(beside.scenario, beside.threads, progress).json()["runs"]:
                key, kind = beside.origin(entry)
                found.setdefault(key, []).append(Neighbour(kind, entry["status"], entry["metrics"]))
    return measure(result.json(), ticks_of_runs(result), found)
