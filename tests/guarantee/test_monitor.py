"""The slip monitor: late by 40 to 60 ms on a loss of grip, silent under noise."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from slipctl.guarantee import verdict, with_guarantee
from slipctl.guarantee.monitor import low_pass, measured_ratio
from slipctl.guarantee.path_time import in_path_time
from slipctl.recording import Columns
from tests.guarantee.recordings import hypotheses

ALPHA, SPEED, TICK, JUMP = 0.4, 0.15, 0.005, 2.0
ROWS = 4001


def drive(after: float, noise: float = 0.0, seed: int = 0) -> Columns:
    """Return a drive along +y with slip at its bound, and from `JUMP` on with `after` times as much.

    With noise as a motion sensor has it: 5 mm/s on each axis and 3 mrad on the heading, times `noise`.
    """
    rng = np.random.default_rng(seed)
    time = np.arange(ROWS)[None, :] * TICK
    share = np.where(time >= JUMP, after, 1.0) * ALPHA
    along, right = (1.0 + share) * SPEED, share * SPEED
    heading = np.full((1, ROWS), math.pi / 2)
    velocity = {
        "x": along * np.cos(heading) + right * np.sin(heading),
        "y": along * np.sin(heading) - right * np.cos(heading),
    }
    zero = np.zeros((1, ROWS))
    columns = {f"motion.velocity.{axis}": values for axis, values in velocity.items()}
    columns |= {f"reference.velocity.{axis}": values.copy() for axis, values in velocity.items()}
    for name in ("position", "velocity"):
        for seen in ("motion", "reference"):
            for axis in ("x", "y"):
                columns.setdefault(f"{seen}.{name}.{axis}", zero.copy())
    for name in ("nominal_input", "robust_input", "weighted_error"):
        columns |= {f"decision.{name}.{axis}": zero.copy() for axis in ("x", "y")}
    columns |= {
        "motion.forward_speed": np.full((1, ROWS), SPEED),
        "slip.longitudinal": share * SPEED,
        "slip.lateral": share * SPEED,
        "slip.yaw": zero.copy(),
        "decision.robust_gain": zero + 1e9,
        "error.position": zero.copy(),
    }
    if noise:
        for axis in ("x", "y"):
            sensed = velocity[axis] + rng.normal(0.0, noise * 5e-3, (1, ROWS))
            columns[f"sensed.velocity.{axis}"] = sensed
        columns["sensed.heading"] = heading + rng.normal(0.0, noise * 3e-3, (1, ROWS))
    return columns


def alarm_time(columns: Columns, **changed: Any) -> float | None:
    fields: dict[str, Any] = {"slip_bound": np.array([ALPHA])} | changed
    wanted = hypotheses(**fields)
    told = verdict(with_guarantee(columns, wanted, TICK), wanted, 0, ROWS - 1, TICK)["alarm_time"]
    assert told is None or isinstance(told, float)
    return told


def test_low_pass_is_the_exact_one_for_held_values():
    step = np.where(np.arange(200) >= 50, 1.0, 0.0)[None, :]
    time = (np.arange(200) - 49) * 0.01
    expected = np.where(time > 0.0, 1.0 - np.exp(-time / 0.15), 0.0)
    assert low_pass(step, 0.01)[0] == pytest.approx(expected, abs=1e-12)
    assert low_pass(np.full((2, 5), 0.7), 0.01) == pytest.approx(np.full((2, 5), 0.7))


@pytest.mark.parametrize("after", [1.27, 1.35])
def test_a_jump_of_the_slip_is_told_within_40_to_60_ms(after):
    """By about a third beyond its bound; the low-pass alone says when it passes the margin."""
    told = alarm_time(drive(after))
    assert told is not None
    gap = math.sqrt(2.0) * ALPHA * (after - 1.0)
    late = -0.15 * math.log(1.0 - 0.05 / gap)
    assert told - JUMP == pytest.approx(late, abs=TICK)
    assert 0.040 - TICK <= told - JUMP <= 0.060


@pytest.mark.parametrize("seed", range(5))
def test_noise_raises_no_false_alarm_and_hides_no_jump(seed):
    assert alarm_time(drive(1.0, noise=1.0, seed=seed)) is None
    told = alarm_time(drive(1.4, noise=1.0, seed=seed))
    assert told is not None
    assert 0.0 < told - JUMP < 0.08
    # the margin is what noise needs: three times as much breaks through it
    assert alarm_time(drive(1.0, noise=4.0, seed=seed)) is not None


def test_the_monitor_sees_what_the_sensors_say():
    columns = drive(1.3, noise=1e-9)
    truth = {name: values for name, values in columns.items() if not name.startswith("sensed.")}
    assert measured_ratio(columns) == pytest.approx(measured_ratio(truth), abs=1e-8)
    columns["sensed.velocity.y"] = columns["sensed.velocity.y"] + 0.1
    assert alarm_time(truth) is not None
    assert alarm_time(columns) == 0.0


def test_the_limit_follows_the_bound():
    mild = drive(1.3)
    assert alarm_time(mild) is not None
    assert alarm_time(mild, uncertainty="paper") is None  # |v_t| + |v_s| ≤ 2α|v| lets |σ| reach 2α
    assert alarm_time(mild, lateral_slip_bound=np.array([0.1])) is None


@pytest.mark.parametrize("tick", [0.001, 0.01, 0.1])
def test_low_pass_has_the_same_bits_for_few_worlds_and_for_many(tick):
    rng = np.random.default_rng(3)
    values = np.abs(rng.normal(size=(5, 600))) * 10.0 ** rng.uniform(-9.0, 3.0, (5, 600))
    values[3, 100], values[4, 200] = np.inf, np.nan
    with np.errstate(invalid="ignore"):
        many = low_pass(values, tick)
        alone = np.concatenate([low_pass(values[world : world + 1], tick) for world in range(5)])
    np.testing.assert_array_equal(alone, many)


def test_a_recorded_ratio_counts_in_real_time_only():
    """A slow robot: the recorded ratio is one of at least 0.05 m/s, that in path time one of ṽ = 0.2 m/s."""
    cells = {"motion.forward_speed": 0.02, "slip.longitudinal": 0.008, "slip.lateral": 0.006, "slip.yaw": 0.0}
    columns = {name: np.full((1, 3), value) for name, value in cells.items()}
    recorded = columns | {"slip.ratio": np.full((1, 3), 0.2)}
    for seen in (columns, recorded):
        np.testing.assert_allclose(measured_ratio(in_path_time(seen)), np.full((1, 3), 0.2), rtol=1e-14)
    path = {"reference.path_rate": 0.1, "decision.path_speed": 0.2}
    for name in ("motion.velocity", "decision.path_velocity", "reference.path_velocity"):
        path |= {f"{name}.{axis}": 0.02 for axis in "xy"}
    path |= {f"reference.path_acceleration.{axis}": 0.0 for axis in "xy"}
    in_its_time = in_path_time(recorded | {name: np.full((1, 3), value) for name, value in path.items()})
    np.testing.assert_allclose(measured_ratio(in_its_time), np.full((1, 3), 0.5), rtol=1e-14)
