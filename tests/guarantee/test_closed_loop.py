"""The theorem on simulated runs: it holds and breaks where it must, and its bounds are never beaten."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from slipctl import scenario as files
from slipctl.experiment import Result, run


def shipped(name: str, tick: float, robust: dict[str, Any] | None = None, **tables: Any) -> Result:
    """Run a shipped scenario with its robust law only."""
    raw: dict[str, Any] = files.dump(files.load(name)) | {"tick": tick} | tables
    raw["controller"] = [raw["controller"][1] | (robust or {})]
    del raw["expect"]  # its claims are about both laws
    return run(files.read(raw))


@cache
def paper(uncertainty: str, tick: float) -> dict[str, Any]:
    return shipped("paper-kinematic", tick, {"uncertainty": uncertainty}).metrics.to_pylist()[0]


@pytest.mark.parametrize("uncertainty", ["paper", "independent", "slip_ratio"])
def test_every_hypothesis_holds_on_the_papers_own_simulation(uncertainty):
    row = paper(uncertainty, 0.001)
    assert row["guarantee_fraction"] == 1.0
    assert row["first_violation"] is None
    assert row["lyapunov_fraction"] == 1.0
    assert row["slip_rate_fraction"] == (None if uncertainty == "slip_ratio" else 1.0)
    assert row["alarm_time"] is None


def test_bounds_beside_the_error_of_the_papers_law():
    """0.85 mm after 5 s; its small gain promises ε/P₁₂ = 10 mm."""
    row = paper("paper", 0.001)
    assert row["settling_time"] == pytest.approx(5.0)
    assert 1e3 * row["settled_error"] == pytest.approx(0.85, abs=0.01)
    assert 1e3 * row["error_bound"] == pytest.approx(10.0)
    assert row["error_bound_share"] == pytest.approx(row["settled_error"] / row["error_bound"])
    assert row["error_bound"] == row["error_bound_small_gain"]
    assert row["error_bound"] < row["error_bound_tight_level_set"] < row["error_bound_level_set"]


def test_the_tick_chatters_at_50_ms_and_not_at_20():
    calm, rough = paper("paper", 0.02), paper("paper", 0.05)
    assert calm["calm_tick"] == rough["calm_tick"] == pytest.approx(0.0135, rel=0.01)
    # 13.5 ms is asked for by the first two ticks only, whose ‖JᵀPe‖ is ten layers away
    assert calm["calm_fraction"] == pytest.approx(1.0 - 2 / 1000)
    assert rough["calm_fraction"] < 0.9
    assert calm["command_variation"] < 7.0
    assert rough["command_variation"] > 50.0


GRID = {
    "slip.longitudinal": [-1.0, 0.3, 1.0],
    "slip.lateral": [-1.0, 0.0, 1.0],
    "slip.yaw": [-1.0, 1.0],
}


@pytest.mark.parametrize(
    ("name", "tick", "changed"),
    [
        ("paper-kinematic", 0.005, {"uncertainty": "independent"}),
        ("paper-kinematic", 0.005, {"uncertainty": "slip_ratio", "pole": -2.0, "boundary_layer": 0.01}),
        ("paper-kinematic", 0.005, {"uncertainty": "independent", "pole": -4.0, "boundary_layer": 0.05}),
        ("paper-dynamic", 0.01, {}),
        ("paper-dynamic", 0.01, {"pole": -0.8, "boundary_layer": 0.02}),
    ],
)
def test_no_admissible_slip_beats_a_bound(name, tick, changed):
    alpha = files.dump(files.load(name))["controller"][1]["slip_bound"]
    sweep = {key: [alpha * share for share in shares] for key, shares in GRID.items()}
    rows = shipped(name, tick, changed, sweep=sweep).metrics.to_pylist()
    assert len(rows) == 18
    for row in rows:
        assert row["guarantee_fraction"] == 1.0, row
        # None where the error never leaves the boundary layer
        assert row["lyapunov_fraction"] in (None, 1.0), row
        for bound in ("small_gain", "tight_level_set", "level_set"):
            # no small gain for a dynamic law, nor with a pole of −4
            if row[f"error_bound_{bound}"] is not None:
                assert row["settled_error"] <= row[f"error_bound_{bound}"]
    if name == "paper-dynamic":  # and they are not empty
        assert max(row["error_bound_share"] for row in rows) > 0.4


def test_slip_beyond_its_bound_is_named_and_nothing_is_promised():
    slip = {"kind": "proportional", "longitudinal": 0.41, "lateral": 0.1, "yaw": 0.1}
    row = shipped("paper-kinematic", 0.005, {"uncertainty": "independent"}, slip=slip).metrics.to_pylist()[0]
    assert row["first_violation"] == "slip_bounded"
    assert row["first_violation_time"] == 0.0
    assert row["first_violation_excess"] == pytest.approx(0.41 / 0.4 - 1.0)
    assert row["guarantee_fraction"] == 0.0
    assert row["settled_guarantee_fraction"] == 0.0
    assert row["error_bound"] is None
    assert row["error_bound_tight_level_set"] > row["settled_error"]


def test_friction_takes_the_guarantee_away():
    raw = files.dump(files.load("friction-sweep"))
    raw["controller"] = [raw["controller"][1]]
    del raw["expect"]
    raw["sweep"] = {"ground.friction": [0.15, 0.8]}
    lost, kept = run(files.read(raw)).metrics.to_pylist()
    assert kept["guarantee_fraction"] >= 0.99
    assert kept["first_violation"] is None
    assert kept["alarm_time"] is None
    assert kept["slip_rate_fraction"] > 0.98
    assert lost["guarantee_fraction"] < 0.5
    assert lost["first_violation"] == "yaw_slip_bounded"
    assert 0.7 < lost["first_violation_time"] < 1.2
    assert lost["first_violation_excess"] > 0.0
    assert lost["first_violation_time"] < lost["alarm_time"] < lost["first_violation_time"] + 0.5


def test_a_sensor_that_errs_takes_the_theorem_away():
    sensing = {"position_noise": 0.001}
    row = shipped("paper-kinematic", 0.02, sensing=sensing).metrics.to_pylist()[0]
    assert row["first_violation"] == "feedback_exact"
    assert row["first_violation_time"] == 0.0
    assert row["guarantee_fraction"] < 0.01
