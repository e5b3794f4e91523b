"""Run scenarios and hold them against their baselines."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipctl import experiment, shipped
from slipctl.experiment.own import OwnLaws
from slipctl.regression.baseline.file import Baseline, CannotJudge, read
from slipctl.regression.claims.judge import judge_claims
from slipctl.regression.judging.findings import Finding, judge, unjudged
from slipctl.regression.judging.origin import Origin, differences, is_elsewhere
from slipctl.regression.judging.ungated import only_status_judged
from slipctl.report.judged import update_command
from slipctl.scenario import Scenario, load, scenario_id

Progress = Callable[[int, int, str], None]


@dataclass(frozen=True)
class Report:
    """What came of one scenario.

    Attributes
    ----------
    scenario
        Its name.
    findings
        Every comparison made; a single unjudged one where there was no sound baseline.
    notes
        What is different from when the baseline was recorded and does not stop the judgement, and of which
        runs hardly anything is judged.
    certified
        As in a manifest: whether its model is certified against closed forms; None where nothing was run, or
        where the plant has no engine.
    model
        The scenario's robot model.
    recorded
        ``commit``, ``date`` and ``reason`` of the baseline; None where there is no sound one.
    """

    scenario: str
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    certified: Mapping[str, Any] | None = None
    model: str = ""
    recorded: Mapping[str, str | None] | None = None

    @property
    def failed(self) -> bool:
        """Whether a number or a status is worse than recorded."""
        return any(finding.verdict.failed for finding in self.findings)

    @property
    def judged(self) -> bool:
        """Whether every comparison could be made."""
        return all(finding.verdict.judged for finding in self.findings)


def recorded_scenarios() -> list[str]:
    """Names of the shipped scenarios that have a baseline, sorted."""
    return sorted(path.stem for path in shipped.baseline_folder().glob("*.json"))


def baseline_file(source: str, scenario: Scenario) -> Path:
    """Say where the baseline of a scenario lies.

    Parameters
    ----------
    source
        What the scenario was loaded from: the name of a shipped one, or a path. A file of one's own has its
        baseline in the folder ``baselines`` beside it.
    scenario
        The scenario.
    """
    if source in shipped.scenario_names():
        return shipped.baseline_folder() / f"{source}.json"
    return Path(source).resolve().parent / "baselines" / f"{scenario.name}.json"


def check(source: str, threads: int | None = None, progress: Progress | None = None) -> Report:
    """Run a scenario, compare it with its baseline and judge its claims.

    Without a sound baseline the claims are judged all the same.

    Raises
    ------
    ScenarioError
        The scenario cannot be read.
    KeyboardInterrupt
        It was interrupted: part of a scenario cannot be judged.
    """
    scenario = load(source)
    path = baseline_file(source, scenario)
    try:
        baseline = read(path, source)
        see_whose(baseline, scenario, path, update_command(source))
    except CannotJudge as error:
        finding = unjudged(scenario.name, str(error))
        if not scenario.expect:
            return Report(scenario.name, (finding,))
        # what is claimed needs no baseline
        return report(scenario, run(scenario, threads, progress), (finding,))
    return compare(scenario, baseline, run(scenario, threads, progress))


def see_whose(baseline: Baseline, scenario: Scenario, path: Path, command: str) -> None:
    """See that a baseline is of this very scenario.

    Parameters
    ----------
    baseline : Baseline
    scenario : Scenario
    path : pathlib.Path
        Where the baseline lies.
    command : str
        What records it again, for the message.

    Raises
    ------
    CannotJudge
        It is of another one, or of one by another name.
    """
    if baseline.scenario_id != scenario_id(scenario):
        raise CannotJudge(
            f"{scenario.name} is another scenario than the one {path} was recorded from; "
            f"record the new one: {command}"
        )
    if baseline.scenario != scenario.name:
        raise CannotJudge(
            f"baseline {path} is damaged at scenario: it says {baseline.scenario}, not {scenario.name}; "
            f"record it again: {command}"
        )


def compare(scenario: Scenario, baseline: Baseline, result: experiment.Result) -> Report:
    """Judge a result by a baseline of the same scenario."""
    now = Origin.of_manifest(result.manifest)
    findings = judge(baseline, result.json(), is_elsewhere(baseline, now))
    about = {"commit": baseline.commit, "date": baseline.date, "reason": baseline.reason}
    notes = (*differences(baseline, now), *only_status_judged(baseline.runs, scenario.expect))
    return report(scenario, result, findings, notes, about)


def report(
    scenario: Scenario,
    result: experiment.Result,
    findings: Iterable[Finding],
    notes: Iterable[str] = (),
    recorded: Mapping[str, str | None] | None = None,
) -> Report:
    """Put a report together: these findings and the scenario's claims, judged on the same result."""
    certified = result.manifest.get("certified")
    findings = (*findings, *judge_claims(scenario, result.json()))
    return Report(scenario.name, findings, tuple(notes), certified, scenario.robot.model, recorded)


def run(
    scenario: Scenario, threads: int | None, progress: Progress | None = None, laws: OwnLaws | None = None
) -> experiment.Result:
    """Run a scenario, with laws of one's own or without, keeping everything in memory.

    Raises
    ------
    KeyboardInterrupt
        It was interrupted.
    """
    result = experiment.run(scenario, out=None, record="none", threads=threads, progress=progress, laws=laws)
    if result.interrupted:
        raise KeyboardInterrupt
    return result
