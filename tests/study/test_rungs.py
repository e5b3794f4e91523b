"""Three rungs, and gaps taken apart without a rest."""

import json
from dataclasses import replace

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl.cli import main
from slipctl.experiment import assemble
from slipctl.plants.ode import KinematicOde
from slipctl.study import rungs
from slipctl.study.corrected import CorrectedOde, measure_differences
from slipctl.study.rungs_table import table
from slipctl.study.runs import closed_loop, edited
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import ProportionalSlip

LAW = "robust_kinematic"


def short(name, duration=1.0, **values):
    return edited(files.load(name), {"duration": duration, **values})


@pytest.fixture(scope="module")
def wet():
    return rungs.study(short("wet-slope"))


@pytest.fixture(scope="module")
def belt():
    return rungs.study(short("belt"))


def rung(result, law, name, key="rungs"):
    (own,) = (entry for entry in result["controllers"] if entry["controller"] == law)
    return next(entry for entry in own[key] if entry["rung"] == name)


def test_slip_of_the_ground_gives_three_rungs_and_prescribed_slip_two(wet, belt):
    assert [entry["rung"] for entry in wet["controllers"][0]["rungs"]] == [
        "emergent",
        "prescribed",
        "analytic",
    ]
    assert [entry["rung"] for entry in belt["controllers"][0]["rungs"]] == ["prescribed", "analytic"]
    assert [entry["controller"] for entry in wet["controllers"]] == ["nominal_kinematic", "robust_kinematic"]


@pytest.mark.parametrize("law", ["nominal_kinematic", "robust_kinematic"])
@pytest.mark.parametrize(
    ("which", "name"), [("wet", "emergent"), ("wet", "prescribed"), ("belt", "prescribed")]
)
def test_the_causes_explain_the_whole_gap(law, which, name, request):
    """With every cause in, the model repeats the contacts a hundred times closer than without."""
    entry = rung(request.getfixturevalue(which), law, name)
    assert entry["status"] == "completed"
    assert entry["gap"] > 2e-5
    assert entry["moved"]["rest"] < 0.01 * entry["gap"]
    assert entry["moved"]["servo"] + entry["moved"]["contact"] + entry["moved"]["tick"] > 0.9 * entry["gap"]


@pytest.mark.parametrize("which", ["wet", "belt"])
def test_the_parts_lead_from_the_analytic_error_to_that_of_the_rung(which, request):
    result = request.getfixturevalue(which)
    for law in result["controllers"]:
        analytic = law["rungs"][-1]
        for entry in law["rungs"][:-1]:
            total = analytic["rms_position_error"] + sum(entry["parts"].values())
            assert total == pytest.approx(entry["rms_position_error"], rel=1e-9)


def test_a_series_is_its_own_slip_at_the_ticks(wet):
    """The slip that is replayed was measured on the emergent rung: no contact differs from it there."""
    assert rung(wet, LAW, "emergent")["moved"]["contact"] < 1e-12
    assert rung(wet, LAW, "prescribed")["moved"]["contact"] > 1e-6


@pytest.mark.parametrize("law", ["nominal_kinematic", "robust_kinematic"])
def test_the_part_of_the_tick_shrinks_with_the_tick(wet, law):
    whole = rung(wet, law, "emergent")["moved"]["tick"]
    assert rung(wet, law, "emergent", "rungs_at_half_the_tick")["moved"]["tick"] < 0.8 * whole


def ode(fraction):
    law = ProportionalSlip(*(np.array([part * fraction]) for part in (1.0, -0.5, 2.0)))
    return KinematicOde(MAGELLAN_PRO, law, np.array([50.0]))


def test_the_difference_of_two_slip_laws_is_found_and_put_in():
    scenario, assumed = short("paper-kinematic", tick=0.01), ode(0.1)
    run = closed_loop(scenario, only=LAW, plant=ode(0.3))[LAW]
    worlds = files.worlds(scenario)
    start = assemble.start(worlds, assemble.references(worlds))
    found = measure_differences(run.columns, assumed, start, 0.01)
    speed = run["motion.forward_speed"]
    expected = 0.2 * speed[:, None] * np.array([1.0, -0.5, 2.0])
    np.testing.assert_allclose(found.slip_at, expected, atol=1e-12)
    np.testing.assert_allclose(found.slip_over, (expected[1:] + expected[:-1]) / 2.0, atol=2e-5)
    np.testing.assert_allclose(found.wheels_at, 0.0, atol=1e-12)
    np.testing.assert_allclose(found.wheels_over, 0.0, atol=1e-9)

    def gap(differences):
        again = closed_loop(scenario, only=LAW, plant=CorrectedOde(assumed, differences, 0.01))[LAW]
        return np.abs(again.pair("motion.position") - run.pair("motion.position")).max()

    assert gap(found) < 1e-6
    assert gap(found.without_slip()) > 1e-4
    assert gap(replace(found, wheels_over=found.wheels_over + np.array([0.01, 0.0]))) > 1e-5


@pytest.mark.parametrize(
    ("scenario", "key"),
    [
        ("friction-sweep", "sweep"),
        ("paper-experiment", "sensing"),
    ],
)
def test_what_has_no_rungs_is_refused(scenario, key, capsys):
    assert main(["study", "rungs", scenario]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert f"{scenario}: {key}: found" in err


@pytest.mark.parametrize("name", ["belt-torque", "paper-dynamic"])
def test_a_torque_drive_has_its_gaps_whole(name):
    result = rungs.study(short(name, 0.3, tick=0.004))
    for law in result["controllers"]:
        prescribed, analytic = law["rungs"]
        assert (prescribed["rung"], analytic["rung"]) == ("prescribed", "analytic")
        assert 1e-8 < prescribed["gap"] < 1e-4
        assert prescribed["parts"] == {}
    lines = table(result)
    assert "not told for a torque drive" in "\n".join(lines)


def test_an_ode_without_slip_has_no_rungs():
    scenario = edited(files.load("paper-kinematic"), {"slip": None, "duration": 0.1})
    with pytest.raises(files.ScenarioError, match=r"plant\.kind"):
        rungs.study(scenario)


def test_an_unknown_scenario_ends_with_exit_2(capsys):
    assert main(["study", "rungs", "wet-slop"]) == 2
    assert 'did you mean "wet-slope"' in capsys.readouterr().err


def test_the_table_says_what_json_says(wet, monkeypatch, capsys):
    monkeypatch.setattr(rungs, "study", lambda scenario, progress: wet)
    assert main(["study", "rungs", "wet-slope", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == wet
    assert main(["study", "rungs", "wet-slope"]) == 0
    lines = capsys.readouterr().out.splitlines()
    entries = [(law["controller"], entry) for law in wet["controllers"] for entry in law["rungs"]]
    assert len(entries) == 6
    for line, (label, entry) in zip(lines[3:9], entries, strict=True):
        cells = line.split()
        assert cells[:2] == [label, entry["rung"]]
        numbers = [float(cell) for cell in cells[2:]]
        expected = [
            entry[name] for name in ("rms_position_error", "max_position_error", "final_position_error")
        ]
        expected += [entry["gap"], *entry["parts"].values()] if entry["gap"] is not None else []
        np.testing.assert_allclose(numbers, 1e3 * np.array(expected), atol=5.1e-4)
    assert any("the servo moves the path most" in line for line in lines[9:])
