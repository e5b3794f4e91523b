"""The numbers that the README and the baselines stand on, with the reason for every tolerance."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl import shipped
from slipctl.experiment import Result, run
from slipctl.regression.claims.judge import judge_claims
from slipctl.regression.judging.findings import Verdict


@cache
def result_of(name: str) -> Result:
    return run(name)


def metric(name: str, controller: str, key: str, **varied: float) -> float:
    """Return one metric of one run of a shipped scenario; its last key part names the varied one."""
    for row in result_of(name).metrics.to_pylist():
        told = {swept.rsplit(".", 1)[-1]: row[swept] for swept in result_of(name).varied}
        if row["controller"] == controller and told == varied:
            assert row["status"] == "completed"
            return row[key]
    raise AssertionError(f"{name} has no run of {controller} with {varied}")


@pytest.mark.parametrize("name", shipped.scenario_names())
def test_every_shipped_scenario_runs_as_it_stands(name):
    worlds = files.worlds(files.load(name))
    result = result_of(name)
    assert result.metrics.num_rows == len(worlds) * len(worlds[0].scenario.controller)
    for row in result.metrics.to_pylist():
        assert row["status"] == "completed"
        assert row["rms_position_error"] <= row["max_position_error"]


CLAIMING = [name for name in shipped.scenario_names() if files.load(name).expect]


@pytest.mark.parametrize("name", CLAIMING)
def test_every_claim_of_a_shipped_scenario_holds(name):
    findings = judge_claims(files.load(name), result_of(name).json())
    assert findings
    assert [str(finding) for finding in findings if finding.verdict is not Verdict.CLAIM_HELD] == []
    # a price or an interval that is claimed leaves a margin, so that another processor changes nothing
    for finding in findings:
        if finding.metric not in ("status", "guarantee_fraction"):
            required, measured = finding.baseline, finding.current
            assert isinstance(required, float)
            assert isinstance(measured, float)
            low, high = finding.interval or (measured, measured)
            assert max(required / high, low / required) > 1.02


def test_where_the_robust_law_loses_the_files_say_so():
    """Of the laws of one scenario, the one that a claim says is better."""
    losses = {
        name
        for name in CLAIMING
        for claim in files.load(name).expect
        if isinstance(claim, files.Better) and claim.controller.startswith("nominal")
    }
    assert losses == {"friction-sweep", "tyre-creep", "ice-stripes", "slope-torque"}


PAPER = {
    # targets in mm, derived independently of this code from the paper's equations under continuous control
    ("nominal_kinematic", "paper"): (17.3, 37.8, 31.1),
    ("robust_kinematic", "paper"): (0.87, 3.95, 0.49),
    ("robust_kinematic", "independent"): (1.40, 6.7, 0.83),
    ("robust_kinematic", "slip_ratio"): (3.47, 14.5, 2.3),
}


@pytest.fixture(scope="module")
def paper():
    """Return RMS, max and final error in mm of Section V-A, by law and bound, in one grid."""
    raw = files.dump(files.load("paper-kinematic"))
    del raw["expect"]  # its claims are about the laws by their kinds
    robust = raw["controller"][1]
    raw["controller"] = [raw["controller"][0]] + [
        robust | {"label": bound, "uncertainty": bound} for bound in ("paper", "independent", "slip_ratio")
    ]
    table = run(files.read(raw)).metrics.to_pylist()
    return {
        (row["kind"], row["controller"] if row["kind"] == "robust_kinematic" else "paper"): [
            1e3 * row[name] for name in ("rms_position_error", "max_position_error", "final_position_error")
        ]
        for row in table
    }


@pytest.mark.parametrize("case", PAPER)
def test_section_five_a_of_the_paper(paper, case):
    """2 %: the targets are rounded to three digits, and a tick of 1 ms is not continuous control."""
    rms, largest, final = paper[case]
    assert rms == pytest.approx(PAPER[case][0], rel=0.02)
    assert largest == pytest.approx(PAPER[case][1], rel=0.02)
    assert final == pytest.approx(PAPER[case][2], rel=0.02)


GRIPPING = [0.2, 0.25, 0.3, 0.5, 0.8]


@pytest.mark.parametrize("friction", GRIPPING)
def test_robust_beats_nominal_where_there_is_grip(friction):
    """The intervals are those of an independent prototype, which saw 1.3–1.5 mm against 0.7–0.8 mm."""
    nominal = metric("friction-sweep", "nominal_kinematic", "rms_position_error", friction=friction)
    robust = metric("friction-sweep", "robust_kinematic", "rms_position_error", friction=friction)
    assert 1.2e-3 < nominal < 1.6e-3
    assert 0.6e-3 < robust < 0.9e-3
    for key in ("max_position_error", "final_position_error"):
        assert metric("friction-sweep", "robust_kinematic", key, friction=friction) < metric(
            "friction-sweep", "nominal_kinematic", key, friction=friction
        )


def test_the_robust_term_loses_control_where_the_nominal_law_still_holds():
    """At μ 0.15 the floor gives 1.18 m/s² and the path needs 1.06: what is left is not enough for Δv."""
    assert metric("friction-sweep", "nominal_kinematic", "max_position_error", friction=0.15) < 0.01
    for key, least in (("rms_position_error", 0.5), ("max_position_error", 1.0)):
        assert metric("friction-sweep", "robust_kinematic", key, friction=0.15) > least
    assert metric("friction-sweep", "robust_kinematic", "max_slip_ratio", friction=0.15) > 1.0


@pytest.mark.parametrize("friction", [0.05, 0.08, 0.1])
def test_nobody_follows_a_path_that_needs_more_friction_than_there_is(friction):
    """Chaotic runs: only the order of magnitude means anything."""
    for controller in ("nominal_kinematic", "robust_kinematic"):
        assert metric("friction-sweep", controller, "rms_position_error", friction=friction) > 0.3


def test_guarantee_holds_where_there_is_grip_and_fails_with_it():
    assert metric("friction-sweep", "robust_kinematic", "guarantee_fraction", friction=0.8) >= 0.99
    assert metric("friction-sweep", "robust_kinematic", "guarantee_fraction", friction=0.15) < 0.5


def test_film_on_a_slope_is_sustained_slip():
    """Bounds wide enough for another processor: the film makes the run anything but chaotic."""
    for controller in ("nominal_kinematic", "robust_kinematic"):
        assert 0.2 < metric("wet-slope", controller, "median_slip_ratio") < 0.5
    assert 0.015 < metric("wet-slope", "nominal_kinematic", "rms_position_error") < 0.020
    assert metric("wet-slope", "robust_kinematic", "rms_position_error") < 0.003
    assert metric("wet-slope", "robust_kinematic", "final_position_error") < 0.001
    assert metric("wet-slope", "robust_kinematic", "max_position_error") < 0.012


def test_tyres_creep_on_a_flat_dry_floor_and_stiffness_decides_who_wins():
    slips = [
        metric("tyre-creep", "nominal_kinematic", "median_slip_ratio", creep_stiffness=stiffness)
        for stiffness in (100.0, 200.0, 500.0, 2000.0)
    ]
    assert slips == sorted(slips, reverse=True)
    assert 0.04 < slips[1] < 0.10
    for stiffness in (200.0, 500.0, 2000.0):
        for key in ("rms_position_error", "max_position_error", "final_position_error"):
            assert metric("tyre-creep", "robust_kinematic", key, creep_stiffness=stiffness) < 0.5 * metric(
                "tyre-creep", "nominal_kinematic", key, creep_stiffness=stiffness
            )
    # the softest tyre cannot give what Δv asks for: the same RMS, and a worse worst
    soft = {
        controller: metric("tyre-creep", controller, "max_position_error", creep_stiffness=100.0)
        for controller in ("nominal_kinematic", "robust_kinematic")
    }
    assert soft["robust_kinematic"] > 1.3 * soft["nominal_kinematic"]


def test_prescribed_slip_through_real_contacts_is_the_papers():
    """17.3 mm is the ODE's value; the belt adds the servo and the contact."""
    assert metric("belt", "nominal_kinematic", "rms_position_error") == pytest.approx(0.0173, abs=0.0005)
    assert metric("belt", "robust_kinematic", "rms_position_error") < 0.002
    ratio = metric("belt", "nominal_kinematic", "median_slip_ratio")
    assert ratio == pytest.approx(0.4 * np.sqrt(2.0), rel=0.002)


def test_a_gripping_floor_hardly_slips_on_the_papers_path():
    raw = files.dump(files.load("belt")) | {"ground": {"friction": 0.8}}
    del raw["slip"]
    result = run(files.read(raw))
    for index in range(2):
        signals = result.run_signals(index)
        for name in ("slip.longitudinal", "slip.lateral"):
            values = signals[name].to_numpy()
            assert np.sqrt(np.mean(values**2)) < 0.05e-3
            # the first ticks settle the servos; nothing later comes near a millimetre per second
            assert np.abs(values[50:]).max() < 0.2e-3
