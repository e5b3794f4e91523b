"""Seeded mistakes, one at a time, held against the committed baselines: each must close the gate.

It must do so on any machine: the number that got worse is worse by more than the tolerance for another engine
or family of processor.
"""

from __future__ import annotations

import functools
import importlib
import json
from typing import Any

import numpy as np
import pytest

from slipctl import regression, shipped
from slipctl.cli import main
from slipctl.cli.check import verdict
from slipctl.cli.exits import Exit
from slipctl.control import nominal_kinematic, robust_kinematic
from slipctl.regression import Finding, Number, Verdict
from slipctl.regression.baseline.file import run_key
from slipctl.regression.baseline.gated import GATED, LARGER_IS_BETTER
from slipctl.theory import robust
from tests.gate_mutants import MUTANTS

SCENARIOS = sorted({mutant.scenario for mutant in MUTANTS})


@functools.cache
def numbers(scenario: str) -> dict[tuple, Number]:
    """Return every recorded number of a scenario by its run and metric."""
    baseline = regression.read(shipped.baseline_folder() / f"{scenario}.json")
    return {
        (*run_key(run.controller, run.varied, run.seed), metric): number
        for run in baseline.runs
        for metric, number in run.metrics.items()
    }


def is_worse_anywhere(finding: Finding) -> bool:
    """Whether it is worse on every machine: a status is, a number by more than its tolerance elsewhere."""
    if finding.verdict is not Verdict.WORSE or finding.current is None:
        return finding.verdict in (Verdict.WORSE, Verdict.STATUS_CHANGED)
    assert finding.controller is not None
    assert finding.seed is not None
    run = run_key(finding.controller, finding.varied, finding.seed)
    number = numbers(finding.scenario)[(*run, finding.metric)]
    sign = -1.0 if finding.metric in LARGER_IS_BETTER else 1.0
    return sign * (float(finding.current) - float(number.value or 0.0)) > number.tolerance_elsewhere


def plant(mutant: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    owner: Any = importlib.import_module(mutant.module)
    *path, attribute = mutant.attribute.split(".")
    for name in path:
        owner = getattr(owner, name)
    monkeypatch.setattr(owner, attribute, mutant.mistake(getattr(owner, attribute)))


def test_there_are_at_least_twenty_mistakes_of_different_names():
    assert len({mutant.name for mutant in MUTANTS}) == len(MUTANTS) >= 20


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_without_a_mistake_the_gate_is_open(scenario):
    report = regression.check(scenario)
    numbers_of = [finding for finding in report.findings if finding.claim is None]
    assert {finding.verdict for finding in numbers_of} <= {Verdict.SAME, Verdict.BETTER, Verdict.CHAOTIC}
    assert verdict([report]) is Exit.GOOD


@pytest.mark.parametrize("mutant", MUTANTS, ids=lambda mutant: mutant.name)
def test_every_mistake_closes_the_gate(mutant, monkeypatch):
    plant(mutant, monkeypatch)
    report = regression.check(mutant.scenario)
    assert verdict([report]) is Exit.GATE_FAILED
    named = [finding for finding in report.findings if finding.claim is None and is_worse_anywhere(finding)]
    assert named
    assert {finding.scenario for finding in named} == {mutant.scenario}
    assert {finding.metric for finding in named} <= {"status", *GATED}


def test_the_command_names_scenario_and_metric(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    plant(MUTANTS[0], monkeypatch)
    assert main(["check", MUTANTS[0].scenario, "--json", "--artefacts", "none"]) == Exit.GATE_FAILED
    out, err = capsys.readouterr()
    worse = [entry for entry in json.loads(out)["results"] if entry["verdict"] == "worse"]
    assert {entry["scenario"] for entry in worse} == {MUTANTS[0].scenario}
    assert "rms_position_error" in {entry["metric"] for entry in worse}
    assert f"{MUTANTS[0].scenario}: nominal_kinematic" in err
    assert "rms_position_error" in err


def regrouped_input(reference, position_error, velocity_error, first_gain, second_gain):
    """Sum `nominal_input` in another order."""
    feedback = second_gain * velocity_error + first_gain * position_error
    return -feedback + reference.acceleration


def regrouped_corrective(weighted_error, robust_gain, boundary_layer):
    """Multiply `corrective_input` in another order."""
    divisor = np.maximum(np.hypot(weighted_error[..., 0], weighted_error[..., 1]), boundary_layer)
    return -(robust_gain[:, None] * weighted_error) / divisor[:, None]


@pytest.mark.parametrize("scenario", ["tyre-creep", "rest-to-rest"])
def test_a_pure_refactoring_leaves_the_gate_open(scenario, monkeypatch):
    """Another order of summation and another norm round otherwise; nothing of that may matter."""
    counted = {"nominal": 0, "corrective": 0}

    def nominal(*arguments):
        counted["nominal"] += 1
        return regrouped_input(*arguments)

    def corrective(*arguments):
        counted["corrective"] += 1
        return regrouped_corrective(*arguments)

    monkeypatch.setattr(nominal_kinematic, "nominal_input", nominal)
    monkeypatch.setattr(robust_kinematic, "nominal_input", nominal)
    monkeypatch.setattr(robust_kinematic, "corrective_input", corrective)
    report = regression.check(scenario)
    assert min(counted.values()) > 500
    moved = [f for f in report.findings if f.claim is None and f.current != f.baseline]
    assert moved, "the refactoring must round otherwise, or nothing was tested"
    assert verdict([report]) is Exit.GOOD
    assert not [f for f in report.findings if f.claim is None and f.verdict is not Verdict.SAME]


def test_the_refactored_law_is_the_same_law():
    rng = np.random.default_rng(0)
    weighted, gain, layer = rng.normal(size=(50, 2)), rng.uniform(0.1, 2.0, 50), rng.uniform(0.01, 1.0, 50)
    one, other = (f(weighted, gain, layer) for f in (regrouped_corrective, robust.corrective_input))
    assert np.allclose(one, other, rtol=1e-14, atol=0.0)
