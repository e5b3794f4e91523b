"""A law of one's own, held against what it gave when its team last looked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl import experiment
from slipctl.regression.baseline.file import Baseline, CannotJudge, read
from slipctl.regression.baseline.spread import neighbours
from slipctl.regression.check import run, see_whose
from slipctl.regression.claims.judge import judge_claims
from slipctl.regression.judging.findings import Finding, judge
from slipctl.regression.judging.origin import Origin, differences, is_elsewhere
from slipctl.regression.judging.ungated import only_status_judged
from slipctl.regression.own_law.report import OwnLawReport
from slipctl.regression.record import changes, new_baseline, try_to_write, write_with_tracks
from slipctl.scenario import Claim, Scenario, StatusIs, dump
from slipctl.scenario import read as read_scenario
from slipctl.scenario.controllers import KINDS_WITH_THEOREM

if TYPE_CHECKING:
    from slipctl.experiment.own import OwnLaw

COMMAND = 'pytest --slipctl-record "reason"'
"""What records a baseline of a law of one's own."""


def read_claims(scenario: Scenario, label: str, claims: Sequence[Mapping[str, Any]]) -> tuple[Claim, ...]:
    """Read claims about a law, or about how it compares with the listed controllers.

    Parameters
    ----------
    scenario : Scenario
    label : str
        What the law is called.
    claims : sequence of mapping
        Each as an ``[[expect]]`` of a scenario file, whose `controller` is the law unless it is given.

    Raises
    ------
    ScenarioError
        A claim is wrong.
    """
    if not claims:
        return ()
    tables = dump(scenario)
    listed = tables["controller"]
    # a listed law stands in for the own one, so that claims are read by the rules of the file format
    stand_in = next((law for law in listed if law["kind"] in KINDS_WITH_THEOREM), listed[0])
    said = [{"controller": label, **claim} for claim in claims]
    tables |= {"controller": [*listed, {**stand_in, "label": label}], "expect": said}
    return read_scenario(tables, f"the claims about {label} in {scenario.name}", scenario.name).expect


def check_law(
    scenario: Scenario,
    label: str,
    law: OwnLaw,
    path: Path,
    claims: Sequence[Claim] = (),
    threads: int | None = None,
    command: str = COMMAND,
) -> OwnLawReport:
    """Run a law beside the listed controllers and hold it against its baseline.

    Parameters
    ----------
    scenario : Scenario
    label : str
        What the law is called.
    law : OwnLaw
        See `slipctl.experiment.own`.
    path : pathlib.Path
        Of the baseline. It holds the law's runs only.
    claims : sequence of Claim
        Judged beside those of the scenario that are about every law.
    threads : int, optional
    command : str
        What records the baseline, for messages.

    Returns
    -------
    OwnLawReport

    Raises
    ------
    CannotJudge
        There is no sound baseline of this scenario.
    OwnLawError
        The law cannot be used.
    KeyboardInterrupt
        It was interrupted.
    """
    baseline = _sound(scenario, path, command)
    result = run(scenario, threads, laws={label: law})
    only = _of_law(result, label)
    now = Origin.of_manifest(result.manifest)
    findings = judge(baseline, only.json(), is_elsewhere(baseline, now))
    findings += _claimed(scenario, claims, result, only)
    notes = (*differences(baseline, now), *only_status_judged(baseline.runs, claims))
    return OwnLawReport(scenario.name, label, path, tuple(findings), result, baseline, notes)


def record_law(
    scenario: Scenario,
    label: str,
    law: OwnLaw,
    path: Path,
    reason: str,
    claims: Sequence[Claim] = (),
    threads: int | None = None,
) -> OwnLawReport:
    """Write the baseline of a law, with tolerances measured as `slipctl check --record` measures them.

    Parameters
    ----------
    scenario, label, law, path, claims, threads
        As of `check_law`.
    reason : str
        Kept in the file.

    Returns
    -------
    OwnLawReport
        Its findings are the claims.

    Raises
    ------
    CannotJudge
        From the very same start the law gave something else: nothing was recorded.
    OwnLawError
        The law cannot be used.
    OutputError
        The baseline cannot be written, which is seen before anything is run.
    OSError
        Nor can it afterwards.
    KeyboardInterrupt
        It was interrupted; the old baseline stands.
    """
    try_to_write(path)
    result = run(scenario, 1, laws={label: law})
    only = _of_law(result, label)

    def run_beside(moved: Scenario, cores: int | None) -> Mapping[str, Any]:
        return _of_law(run(moved, cores, laws={label: law}), label).json()

    beside = neighbours(scenario, run_beside, threads)
    new = new_baseline(only, beside, reason, path)
    try:
        old = read(path)
    except CannotJudge:
        old = None
    write_with_tracks(new, only, path)
    findings = tuple(_claimed(scenario, claims, result, only))
    changed = tuple(changes(old, new))
    return OwnLawReport(scenario.name, label, path, findings, result, new, (), changed)


def _sound(scenario: Scenario, path: Path, command: str) -> Baseline:
    baseline = read(path, command=command)
    see_whose(baseline, scenario, path, command)
    return baseline


def _of_law(result: experiment.Result, label: str) -> experiment.Result:
    """Return the rows of one law."""
    import pyarrow as pa

    labels = result.metrics["controller"].to_pylist()
    metrics = result.metrics.filter(pa.array([name == label for name in labels]))
    own = np.isin(result.signals["run"].to_numpy(), metrics["run"].to_numpy())
    signals = result.signals.filter(pa.array(own))
    return replace(result, metrics=metrics, in_memory=signals)


def _claimed(
    scenario: Scenario, claims: Sequence[Claim], result: experiment.Result, only: experiment.Result
) -> list[Finding]:
    """Judge the given claims, and those of the scenario that are about every law."""
    general = tuple(
        claim for claim in scenario.expect if isinstance(claim, StatusIs) and claim.controller is None
    )
    found = judge_claims(scenario.model_copy(update={"expect": general}), only.json())
    return found + judge_claims(scenario.model_copy(update={"expect": tuple(claims)}), result.json())
