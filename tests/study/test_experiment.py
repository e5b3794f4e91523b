"""Section VI over seeds: what is counted, on runs whose answer is known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from slipctl import scenario as files
from slipctl.experiment import assemble, run
from slipctl.study.experiment import bootstrap, comparison, experiment_runs, fix_errors, summary
from slipctl.study.experiment_table import text_lines

TABLES: dict[str, Any] = {
    "name": "short",
    "tick": 0.05,
    "duration": 3.0,
    "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
    "plant": {"kind": "kinematic_ode"},
    "slip": {"kind": "proportional", "longitudinal": -0.3, "lateral": 0.0, "yaw": 0.0},
    "reference": {"kind": "line", "speed": 0.5, "distance": 1.5},
    "sensing": {"pose": "odometry_camera", "velocity": "odometry", "camera_rate": 3.0},
    "controller": [
        {"kind": "nominal_kinematic", "pole": -1.0, "label": "first"},
        {"kind": "nominal_kinematic", "pole": -2.0, "label": "second"},
    ],
}


def short(**tables: Any) -> files.Scenario:
    """Return a straight line with longitudinal slip under an exact camera, or what the tables make of it."""
    return files.read(TABLES | tables)


def made_up(**numbers: list[float]) -> pa.Table:
    """Return runs of two laws, `first` and `second`, with numbers by seed and zero for all others."""
    names = ("rms_position_error", "moving_position_error", "late_y_error", "late_y_seen")
    rows = []
    for index, label in enumerate(("first", "second")):
        for seed in range(3):
            row = {"tick": 0.1, "camera_gain": 1.0, "controller": label, "seed": seed}
            rows.append(row | {name: numbers.get(name, [0.0] * 6)[3 * index + seed] for name in names})
    return pa.Table.from_pylist(rows)


def test_the_interval_of_a_median_holds_it_as_often_as_it_says() -> None:
    rng = np.random.default_rng(5)
    intervals = [bootstrap(rng.standard_normal(20)) for _ in range(150)]
    held = np.mean([lower <= 0.0 <= upper for lower, upper in intervals])
    # the percentile interval of a median is a little cautious
    assert 0.88 <= held <= 1.0
    width = np.mean([upper - lower for lower, upper in intervals])
    # standard error of a normal median: 1.2533/sqrt(20) = 0.28
    assert width == pytest.approx(2.0 * 1.96 * 0.28, rel=0.25)


def test_equal_values_leave_no_doubt() -> None:
    assert bootstrap(np.full(7, 0.3)) == (0.3, 0.3)


def test_medians_are_over_seeds() -> None:
    rows = summary(made_up(rms_position_error=[1.0, 5.0, 2.0, 7.0, 9.0, 8.0]))
    assert [(row["controller"], row["rms_position_error"], row["runs"]) for row in rows] == [
        ("first", 2.0, 3),
        ("second", 8.0, 3),
    ]
    assert rows[0]["lower"] >= 1.0
    assert rows[0]["upper"] <= 5.0


def test_laws_are_compared_at_the_same_seed() -> None:
    (row,) = comparison(made_up(rms_position_error=[1.0, 5.0, 2.0, 0.5, 6.0, 1.5]))
    assert row["rms_difference"] == pytest.approx(-0.5)
    assert row["better"] == pytest.approx(2 / 3)
    assert (row["controller"], row["against"]) == ("second", "first")


def test_the_counter_example_is_counted_at_the_same_and_at_different_seeds() -> None:
    (row,) = comparison(made_up(late_y_error=[1.0, 2.0, 3.0, 0.9, 2.5, 0.1], late_y_seen=[3.0] * 5 + [4.0]))
    # same seed: only 2.5 > 2; different seeds: 2.5 > 1 of six pairs
    assert row["counter_example"] == pytest.approx(1 / 3)
    assert row["counter_example_apart"] == pytest.approx(1 / 6)
    assert row["counter_example_seen"] == pytest.approx(2 / 6)


def test_fixes_remove_what_the_wheels_missed() -> None:
    """On a straight line with 30 % less way than the wheels roll, all errors are known."""
    scenario = short()
    result = run(scenario)
    signals = result.run_signals(0)
    fixes = fix_errors(signals, assemble.read_robot(scenario).geometry)
    time = signals["time"].to_numpy()
    x = signals["motion.position.x"].to_numpy()
    rows = np.searchsorted(time, fixes["time"] - 1e-9)
    way = np.diff(x[[0, *rows]])
    # the robot goes 0.7 of what the wheels roll
    np.testing.assert_allclose(fixes["drift"], way * 0.3 / 0.7, rtol=1e-6)
    np.testing.assert_allclose(fixes["position_after"], 0.0, atol=1e-12)
    before = (x[rows - 1] - x[[0, *rows[:-1]]]) * 0.3 / 0.7
    np.testing.assert_allclose(fixes["position_before"], before, rtol=1e-6)
    assert len(rows) == 9


def test_runs_cover_the_grid_and_tell_their_numbers() -> None:
    runs = experiment_runs(seeds=(1, 2), ticks=(0.1, 0.05), gains=(1.0, 0.5), scenario=short(duration=6.0))
    keys = {(row["tick"], row["camera_gain"], row["seed"], row["controller"]) for row in runs.to_pylist()}
    assert len(keys) == runs.num_rows == 16
    full, half = (
        next(row for row in summary(runs) if row["tick"] == 0.05 and row["camera_gain"] == gain)
        for gain in (1.0, 0.5)
    )
    assert full["fix_helped"] == 1.0
    assert full["position_after"] < 1e-9 < half["position_after"] < half["position_before"]
    assert full["odometry_error"] > 0.5
    assert full["moving_position_error"] > 0.0
    # too short for what happens between 15 and 20 s
    assert full["late_y_error"] is None
    assert comparison(runs)[0]["counter_example"] is None


def test_lines_say_the_numbers() -> None:
    runs = experiment_runs(seeds=(1, 2), ticks=(0.1,), gains=(0.5,), scenario=short())
    medians, compared = summary(runs), comparison(runs)
    lines = text_lines(medians, compared)
    assert lines[0].startswith("commands at 10 Hz, a fix corrects 50%, 2 seeds")
    for row in medians:
        line = next(line for line in lines if line.startswith(row["controller"]))
        assert f"{1e3 * row['rms_position_error']:.2f} [" in line
    assert any("second less first" in line for line in lines)
    assert not any("nan" in line for line in lines)
    assert all(math.isfinite(value) for row in medians for value in row.values() if isinstance(value, float))
