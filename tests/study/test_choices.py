"""What the paper leaves open: starts, chatter thresholds and bounds of linear laws."""

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl.study import choices
from slipctl.study.runs import StudyRun, closed_loop, controller_tables, edited, medians, run_all


def first_row(name, **options):
    scenario = edited(files.load(name), {"duration": 0.02, "tick": 0.01})
    start = choices.matched_start(scenario) if options.pop("matched") else None
    return next(iter(closed_loop(scenario, start=start).values()))


@pytest.mark.parametrize("name", ["paper-kinematic", "paper-dynamic"])
def test_a_matched_start_moves_as_planned_although_it_slips(name):
    matched, planned = (first_row(name, matched=matched) for matched in (True, False))
    for signal in ("velocity", "acceleration") if name == "paper-dynamic" else ("velocity",):
        wanted = matched.pair(f"reference.{signal}")[0]
        np.testing.assert_allclose(matched.pair(f"motion.{signal}")[0], wanted, atol=1e-12)
    assert np.abs(planned.pair("motion.velocity")[0] - planned.pair("reference.velocity")[0]).max() > 0.04
    assert np.abs(matched["slip.longitudinal"][0]) > 0.02


def test_only_proportional_slip_has_a_matched_start():
    with pytest.raises(ValueError, match="proportional"):
        choices.matched_start(edited(files.load("wet-slope"), {"duration": 0.1}))


def synthetic(gain):
    """A run that never leaves v = 0.1 with v_t = v_s = 0.4 v."""
    ones = np.ones(10)
    columns = {
        "decision.robust_gain": gain * ones,
        "slip.longitudinal": 0.04 * ones,
        "slip.lateral": 0.04 * ones,
        "motion.forward_speed": 0.1 * ones,
        "reference.acceleration.x": 0.03 * ones,
        "reference.acceleration.y": 0.04 * ones,
    }
    return StudyRun("robust", "completed", {}, columns)


def test_the_calm_tick_is_that_of_the_theory():
    """2 Re(1+σ)/|1+σ|² · ε/(P₂₂ρ) with P₂₂ = 2.5 at poles −0.5."""
    expected = 2.0 * 1.4 / (1.4**2 + 0.4**2) * 0.02 / (2.5 * 0.08)
    found = choices.calm_ticks(synthetic(0.08), 0.02, -0.5)
    assert found == pytest.approx({"calm_tick": expected, "late_calm_tick": expected})


def test_a_linear_law_is_bounded_at_every_pole():
    """Sup‖η‖ = (0.4·0.05 + 1.4·0.4·0.01)/(1 − 1.2707·0.4), over p²."""
    low, high = choices.linear_bounds(synthetic(0.0), complex(0.4, 0.0), 0.4)
    uncertainty = (0.4 * 0.05 + 1.4 * 0.4 * 0.1**2) / (1.0 - 1.2707 * 0.4)
    assert (low["pole"], high["pole"]) == (-0.5, -4.0)
    assert low["bound_mm"] == pytest.approx(1e3 * uncertainty / 0.25)
    assert high["bound_mm"] == pytest.approx(1e3 * uncertainty / 16.0)


def test_the_bound_of_the_linear_law_holds_on_its_run():
    scenario = edited(files.load("paper-kinematic"), {"tick": 0.01})
    tables = controller_tables(scenario)["nominal_kinematic"]
    laws = [{**tables, "label": f"p{-pole:g}".replace(".", "-"), "pole": pole} for pole in (-0.5, -4.0)]
    runs = run_all(edited(scenario, {}, laws)).values()
    for run, bound in zip(runs, choices.linear_bounds(next(iter(runs)), 0.4 - 0.4j, 0.4), strict=True):
        late = 1e3 * run["error.position"][run["time"] > 10.0].max()
        assert 0.01 * bound["bound_mm"] < late < bound["bound_mm"]


def test_edited_scenarios_lose_and_gain_keys():
    scenario = files.load("paper-kinematic")
    changed = files.dump(edited(scenario, {"slip.yaw": None, "slip.lateral": -0.1, "tick": 0.02}))
    assert (changed["slip"]["yaw"], changed["slip"]["lateral"], changed["tick"]) == (0.0, -0.1, 0.02)
    assert files.dump(scenario)["slip"]["lateral"] == 0.4
    with pytest.raises(files.ScenarioError, match="tick"):
        edited(scenario, {"tick": -1.0})


def test_a_run_of_its_own_loop_is_that_of_the_command():
    scenario = edited(files.load("paper-kinematic"), {"duration": 0.2, "tick": 0.01})
    ours, theirs = closed_loop(scenario), run_all(scenario)
    assert list(ours) == list(theirs)
    for label, run in ours.items():
        for column in ("time", "motion.position.x", "decision.robust_input.y"):
            np.testing.assert_array_equal(run[column], theirs[label][column])
        assert run.summary() == theirs[label].summary()


def test_medians_are_over_seeds():
    scenario = edited(files.load("paper-kinematic"), {"duration": 0.2, "tick": 0.01, **choices.NOISE})
    alone = [medians(scenario, [seed])["robust_kinematic"]["rms_position_error"] for seed in (1, 2, 3)]
    assert len(set(alone)) == 3
    together = medians(scenario, [1, 2, 3])["robust_kinematic"]["rms_position_error"]
    assert together == sorted(alone)[1]


def test_the_shipped_laws_are_those_that_the_sections_show():
    """`starts` and `feedback` take them from the sections' runs instead of running them again."""
    expected = {
        "paper-kinematic": ("robust_kinematic", "paper"),
        "paper-dynamic": ("robust_dynamic", "proportional"),
    }
    for name, law in expected.items():
        nominal, robust = files.dump(files.load(name))["controller"]
        assert (robust["kind"], robust["uncertainty"]) == law
        assert nominal["kind"].startswith("nominal")
