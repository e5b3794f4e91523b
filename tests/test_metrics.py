"""Metrics against closed forms on recordings made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from slipctl.metrics import UNITS, measure, measure_worlds
from slipctl.recording import Columns

ROWS = 101


def by_hand(**changed: np.ndarray) -> Columns:
    """Return two worlds: the first all zeros and ones, the second as the test wants it."""
    zero = np.zeros((2, ROWS))
    columns: Columns = {
        "error.position": zero.copy(),
        "error.cross_track": zero.copy(),
        "error.heading": zero.copy(),
        "decision.robust_input.x": zero.copy(),
        "decision.robust_input.y": zero.copy(),
        "decision.yaw_rate": zero.copy(),
        "decision.saturated": np.zeros((2, ROWS), dtype=bool),
        "slip.ratio": zero.copy(),
        "motion.forward_speed": zero + 1.0,
    }
    for name, values in changed.items():
        columns[name.replace("__", ".")][1] = values
    return columns


def test_a_ramp_has_the_rms_max_and_final_value_of_a_ramp():
    ramp = np.linspace(0.0, 3.0, ROWS)
    metrics = measure(by_hand(error__position=ramp, error__cross_track=-ramp), 1, ROWS - 1)
    # the mean square of 0, 1, …, n is n(2n+1)/6
    expected = 3.0 * math.sqrt((2 * 100 + 1) / (6 * 100))
    assert metrics["rms_position_error"] == pytest.approx(expected, rel=1e-12)
    assert metrics["rms_cross_track_error"] == pytest.approx(expected, rel=1e-12)
    assert metrics["max_position_error"] == 3.0
    assert metrics["final_position_error"] == 3.0


def test_rows_after_the_last_one_do_not_count():
    error = np.where(np.arange(ROWS) <= 10, 0.5, 1e9)
    metrics = measure(by_hand(error__position=error), 1, 10)
    assert metrics["rms_position_error"] == 0.5
    assert metrics["max_position_error"] == 0.5
    assert metrics["final_position_error"] == 0.5


def test_command_variation_is_the_total_variation_of_the_yaw_rate_command():
    zigzag = np.where(np.arange(ROWS) % 2 == 0, 0.0, 0.25)
    assert measure(by_hand(decision__yaw_rate=zigzag), 1, ROWS - 1)["command_variation"] == 25.0


def test_command_variation_of_a_torque_law_is_that_of_the_right_wheel():
    columns = by_hand()
    del columns["decision.yaw_rate"]
    climbing = np.stack([np.zeros(ROWS), np.linspace(0.0, 3.0, ROWS)])
    columns |= {"wheel.torque_command.left": -7.0 * climbing, "wheel.torque_command.right": climbing}
    assert measure(columns, 1, ROWS - 1)["command_variation"] == pytest.approx(3.0, rel=1e-12)


def test_robust_input_is_the_rms_of_its_norm():
    metrics = measure(
        by_hand(decision__robust_input__x=np.full(ROWS, 3.0), decision__robust_input__y=np.full(ROWS, -4.0)),
        1,
        100,
    )
    assert metrics["rms_robust_input"] == 5.0


def test_slip_saturation_and_speed():
    slip = np.arange(ROWS) / 100.0
    saturated = np.arange(ROWS) < 25
    speed = 1.0 - np.arange(ROWS) / 50.0
    metrics = measure(
        by_hand(slip__ratio=slip, decision__saturated=saturated, motion__forward_speed=speed), 1, ROWS - 1
    )
    assert metrics["max_slip_ratio"] == 1.0
    assert metrics["median_slip_ratio"] == 0.5
    assert metrics["saturation_fraction"] == 25 / 101
    assert metrics["min_forward_speed"] == -1.0


def test_guarantee_counts_ticks_not_rows_and_is_null_without_a_theorem():
    columns = by_hand()
    assert measure(columns, 1, ROWS - 1)["guarantee_fraction"] is None
    held = np.zeros((2, ROWS), dtype=bool)
    held[1, :30] = True
    held[1, -1] = True  # the last row has no tick
    assert measure(columns | {"guarantee.held": held}, 1, ROWS - 1)["guarantee_fraction"] == 0.30
    assert measure(columns | {"guarantee.held": held}, 1, 20)["guarantee_fraction"] == 1.0
    assert measure(columns | {"guarantee.held": held}, 1, 1)["guarantee_fraction"] == 1.0
    assert measure(columns | {"guarantee.held": held}, 1, 0)["guarantee_fraction"] is None


def test_values_that_are_not_finite_are_null_and_every_metric_is_there():
    metrics = measure(by_hand(error__position=np.full(ROWS, math.nan)), 1, ROWS - 1)
    assert metrics["rms_position_error"] is None
    assert metrics["max_position_error"] is None
    assert metrics["rms_cross_track_error"] == 0.0
    assert list(metrics) == list(UNITS)


def test_a_world_has_the_same_numbers_in_any_company():
    rng = np.random.default_rng(5)
    columns = {
        name: rng.normal(size=(7, 1234)) if values.dtype != bool else rng.random((7, 1234)) < 0.5
        for name, values in by_hand().items()
    }
    for world in range(7):
        alone = {name: values[world : world + 1].copy() for name, values in columns.items()}
        assert measure(columns, world, 1200) == measure(alone, 0, 1200)


def test_sums_of_long_runs_round_alike_alone_and_in_company():
    rows, worlds = 20_001, 5
    rng = np.random.default_rng(4)
    columns: Columns = {
        name: rng.lognormal(sigma=3.0, size=(worlds, rows))
        for name in by_hand()
        if name != "decision.saturated"
    }
    columns["decision.saturated"] = rng.random((worlds, rows)) < 0.3
    columns["guarantee.held"] = rng.random((worlds, rows)) < 0.7
    last_rows = [rows - 1, 12_345, rows - 1, 7, 0]
    together = measure_worlds(columns, last_rows)
    for world, last in enumerate(last_rows):
        assert together[world] == measure(columns, world, last)
        # and as numpy sums one contiguous row
        error = columns["error.position"][world, : last + 1].copy()
        assert together[world]["rms_position_error"] == math.sqrt(np.mean(error * error))
        assert together[world]["median_slip_ratio"] == np.median(columns["slip.ratio"][world, : last + 1])
        flags = columns["decision.saturated"][world, : last + 1]
        assert together[world]["saturation_fraction"] == flags.mean()


@pytest.mark.parametrize("last_row", [0, 1, 2, 99, 100])
def test_the_median_is_that_of_numpy(last_row):
    ratio = np.random.default_rng(last_row).uniform(0.0, 2.0, ROWS)
    told = measure(by_hand(slip__ratio=ratio), 1, last_row)["median_slip_ratio"]
    assert told == np.median(ratio[: last_row + 1])
    ratio[last_row // 2] = np.nan
    assert measure(by_hand(slip__ratio=ratio), 1, last_row)["median_slip_ratio"] is None
