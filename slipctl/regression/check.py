"""Run scenarios and hold them against their baselines, or record new ones."""

from __future__ import annotations

import datetime
import subprocess
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from slipctl import experiment, shipped
from slipctl.regression.baseline import Baseline, CannotJudge, read, write
from slipctl.regression.judge import Finding, Verdict, judge
from slipctl.regression.tolerance import NUDGE, measure
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
        What is different from when the baseline was recorded and does not stop the judgement.
    certified
        As in a manifest: whether its model is certified against closed forms; None where nothing was run, or
        where the plant has no engine.
    model
        The scenario's robot model.
    """

    scenario: str
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    certified: Mapping[str, Any] | None = None
    model: str = ""

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
    """Run a scenario and compare it with its baseline.

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
        if baseline.scenario_id != scenario_id(scenario):
            raise CannotJudge(
                f"{scenario.name} is another scenario than the one {path} was recorded from; "
                f"record the new one: slipctl check {source} --update --reason '…'"
            )
    except CannotJudge as error:
        return Report(scenario.name, (_unjudged(scenario.name, str(error)),))
    result = _run(scenario, threads, progress)
    payload = result.json()
    return _report(scenario, result, judge(baseline, payload), _differences(baseline, payload))


def update(
    source: str, reason: str, threads: int | None = None, progress: Progress | None = None
) -> tuple[Report, Path]:
    """Record a baseline, its tolerances measured from two more runs whose start is moved by `NUDGE`.

    Returns
    -------
    Report
        The new numbers against the old baseline, if there was a sound one.
    Path
        The file that was written.

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
    result = _run(scenario, threads, progress)
    payload = result.json()
    nudged = [_run(_nudged(scenario, offset), threads, progress).json() for offset in (NUDGE, -NUDGE)]
    new = Baseline(
        scenario=payload["scenario"],
        scenario_id=payload["scenario_id"],
        model_id=payload["model_id"],
        versions=payload["versions"],
        machine={name: result.manifest["machine"][name] for name in ("system", "architecture", "processor")},
        commit=_commit(),
        date=datetime.datetime.now(datetime.UTC).date().isoformat(),
        reason=reason,
        runs=measure(payload, nudged),
    )
    try:
        old = read(path)
        report = _report(scenario, result, judge(old, payload), _differences(old, payload))
    except CannotJudge as error:
        notes = (f"nothing to compare with: {error}",) if path.exists() else ()
        report = _report(scenario, result, (), notes)
    write(new, path)
    return report, path


def _report(
    scenario: Scenario, result: experiment.Result, findings: Iterable[Finding], notes: Iterable[str]
) -> Report:
    certified = result.manifest.get("certified")
    return Report(scenario.name, tuple(findings), tuple(notes), certified, scenario.robot.model)


def _run(scenario: Scenario, threads: int | None, progress: Progress | None) -> experiment.Result:
    result = experiment.run(scenario, out=None, record="none", threads=threads, progress=progress)
    if result.interrupted:
        raise KeyboardInterrupt
    return result


def _nudged(scenario: Scenario, offset: float) -> Scenario:
    # A swept offset would replace the nudge: then the other direction is moved.
    key = "y_offset" if any(axis.key == "start.x_offset" for axis in scenario.sweep) else "x_offset"
    start = scenario.start.model_copy(update={key: getattr(scenario.start, key) + offset})
    return scenario.model_copy(update={"start": start})


def _unjudged(name: str, why: str) -> Finding:
    return Finding(name, None, {}, None, None, None, None, None, Verdict.UNJUDGED, why)


def _differences(baseline: Baseline, payload: Mapping[str, Any]) -> list[str]:
    """Say what else is not as it was when the baseline was recorded."""
    changed = []
    if baseline.model_id != payload["model_id"]:
        changed.append(f"model {baseline.model_id} then, {payload['model_id']} now")
    for name in dict.fromkeys([*baseline.versions, *payload["versions"]]):
        then, now = baseline.versions.get(name), payload["versions"].get(name)
        if then != now:
            changed.append(f"{name} {then or 'absent'} then, {now or 'absent'} now")
    return [f"{'; '.join(changed)}: judged all the same"] if changed else []


def _commit() -> str | None:
    """Git commit of this checkout, marked where files were changed; None outside one."""
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return None
    command = ["git", "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return None
    return answer.stdout.strip() or None
