"""The overhead camera: when it looks, when a fix arrives, and what it corrects."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from slipctl.sensing.sensor import MotionSensor
from slipctl.theory.slip import ProportionalSlip
from slipctl.tick import Array, Motion
from tests.builders import full
from tests.sensing.worlds import TICK, camera, drive, headings, positions, sense, sensor_of

TICKS = 80


def slipping(ticks: int = TICKS, heading: float = 0.3) -> list[Motion]:
    """Drive with slip of all three kinds."""
    times = np.arange(ticks) * TICK
    law = ProportionalSlip(full(1, -0.2), full(1, 0.15), full(1, 0.4))
    return drive(0.6 + 0.2 * np.sin(times), np.cos(2.0 * times), law, heading)


def with_camera(rows: int, seed: int = 3, **settings: float) -> MotionSensor:
    return sensor_of(1, rows, [seed], pose="odometry_camera", camera=camera(1, **settings))


def fixes(sensor: MotionSensor, motions: list[Motion]) -> NDArray[np.intp]:
    """Return the rows at which a fix arrives."""
    return np.flatnonzero([memory.fix[0] for memory in sense(sensor, motions)[0]])


def gaps(motions: list[Motion], seen: list[Motion]) -> Array:
    """Return estimated less true position, (T + 1, 2) [m]."""
    return positions(seen) - positions(motions)


@pytest.mark.parametrize("rate", [1.0, 3.0, 7.3])
def test_frames_come_at_their_rate(rate: float) -> None:
    motions = slipping(400)
    rows = fixes(with_camera(len(motions), rate=rate), motions)
    assert len(rows) == pytest.approx(rate * 400 * TICK, abs=1.0)
    assert np.diff(rows).min() >= math.floor(1.0 / (rate * TICK))
    assert np.diff(rows).max() <= math.ceil(1.0 / (rate * TICK))
    assert rows[0] > 0


def test_a_camera_faster_than_the_ticks_looks_once_a_tick() -> None:
    motions = slipping()
    assert fixes(with_camera(len(motions), rate=1.7 / TICK), motions).tolist() == list(range(1, TICKS + 1))


def test_cameras_of_different_worlds_do_not_look_at_the_same_time() -> None:
    motions = slipping()
    first = {fixes(with_camera(len(motions), seed), motions)[0] for seed in range(20)}
    assert len(first) > 3


def test_an_exact_fix_at_once_sets_the_estimate_right() -> None:
    motions = slipping()
    memories, seen = sense(with_camera(len(motions)), motions)
    fixed = np.array([memory.fix[0] for memory in memories])
    distance = np.hypot(*gaps(motions, seen).T)
    assert distance[fixed] == pytest.approx(0.0, abs=1e-14)
    np.testing.assert_allclose(headings(seen)[fixed], headings(motions)[fixed], atol=1e-14)
    # and it was wrong in the row before
    assert distance[np.flatnonzero(fixed) - 1].min() > 1e-3


def test_a_fix_corrects_its_share_of_the_error() -> None:
    motions = slipping()
    first = fixes(with_camera(len(motions)), motions)[0]
    blind = gaps(motions, sense(with_camera(len(motions), rate=0.0), motions)[1])
    seen = sense(with_camera(len(motions), gain=0.3), motions)[1]
    np.testing.assert_allclose(gaps(motions, seen)[first], 0.7 * blind[first], rtol=1e-9)
    turned = headings(seen)[first] - headings(motions)[first]
    blind_turn = headings(sense(with_camera(len(motions), rate=0.0), motions)[1])[first]
    assert turned == pytest.approx(0.7 * (blind_turn - headings(motions)[first]), rel=1e-9)


@pytest.mark.parametrize("late", [1, 2, 9])
def test_a_late_fix_arrives_late_and_carries_the_odometry_since(late: int) -> None:
    motions = slipping()
    prompt = fixes(with_camera(len(motions)), motions)
    sensor = with_camera(len(motions), delay=late * TICK)
    memories, seen = sense(sensor, motions)
    arrivals = np.flatnonzero([memory.fix[0] for memory in memories])
    assert arrivals.tolist() == [row + late for row in prompt if row + late <= TICKS]
    # from the true pose at exposure on, the estimate is what the wheels alone tell
    for row in arrivals:
        since = motions[row - late : row + 1]
        expected = sense(sensor_of(1, len(since), pose="odometry_camera", camera=camera(1, rate=0.0)), since)
        np.testing.assert_allclose(seen[row].position, expected[1][-1].position, atol=1e-13)
        np.testing.assert_allclose(seen[row].heading_vector, expected[1][-1].heading_vector, atol=1e-13)


def test_a_delay_between_ticks_waits_for_the_next_tick() -> None:
    motions = slipping()
    late = fixes(with_camera(len(motions), delay=1.2 * TICK), motions)
    assert late.tolist() == fixes(with_camera(len(motions), delay=2.0 * TICK), motions).tolist()


@settings(max_examples=30, deadline=None)
@given(
    st.floats(0.1, 1.0),
    st.floats(0.5, 30.0),
    st.integers(0, 8),
    st.integers(0, 10**6),
    st.floats(-20.0, 20.0),
)
def test_without_slip_and_noise_a_fix_has_nothing_to_correct(
    gain: float, rate: float, late: int, seed: int, heading: float
) -> None:
    times = np.arange(40) * TICK
    motions = drive(np.full(40, 0.5), 1.2 * np.cos(times), heading=heading)
    sensor = with_camera(len(motions), seed, rate=rate, delay=late * TICK, gain=gain)
    np.testing.assert_allclose(gaps(motions, sense(sensor, motions)[1]), 0.0, atol=1e-7)


def test_headings_are_corrected_the_short_way() -> None:
    """A robot turns through ±π, where the angle of the camera jumps and that of the odometry does not."""
    law = ProportionalSlip(full(1, 0.0), full(1, 0.0), full(1, 0.3))
    motions = drive(np.full(TICKS, 0.5), np.full(TICKS, 2.0), law, heading=3.0)
    sensor = with_camera(len(motions), gain=0.5)
    off = headings(sense(sensor, motions)[1]) - headings(motions)
    # 0.15 rad/s of yaw slip over a third of a second, halved at every fix
    assert 0.05 < np.abs(off).max() < 0.15


def test_noise_of_a_fix_has_its_deviation() -> None:
    ticks = 3000
    motions = drive(np.zeros(ticks), np.zeros(ticks))
    sensor = with_camera(len(motions), rate=1.0 / TICK, position_noise=0.003, heading_noise=0.01)
    seen = sense(sensor, motions)[1][1:]
    off = positions(seen) - positions(motions)[1:]
    turned = headings(seen) - headings(motions)[1:]
    np.testing.assert_allclose(off.std(axis=0), 0.003, rtol=0.06)
    assert turned.std() == pytest.approx(0.01, rel=0.06)
    assert np.abs(np.corrcoef(np.column_stack([off, turned]).T) - np.eye(3)).max() < 0.06


def test_the_share_filters_the_noise() -> None:
    """A standing robot with gain g is a first-order filter: variance g/(2 − g) of the fix's."""
    ticks = 6000
    motions = drive(np.zeros(ticks), np.zeros(ticks))
    sensor = with_camera(len(motions), rate=1.0 / TICK, position_noise=0.003, gain=0.5)
    off = gaps(motions, sense(sensor, motions)[1])[100:]
    np.testing.assert_allclose(off.std(axis=0), 0.003 * math.sqrt(0.5 / 1.5), rtol=0.08)


def test_frames_see_the_same_noise_at_any_tick() -> None:
    """So that command rates can be compared on the same luck."""
    coarse = with_camera(41, position_noise=0.01).camera
    fine = sensor_of(1, 200, [3], pose="odometry_camera", camera=camera(1, position_noise=0.01)).camera
    assert coarse is not None
    assert fine is not None
    assert coarse.noise is not None
    assert fine.noise is not None
    np.testing.assert_array_equal(coarse.noise, fine.noise[: len(coarse.noise)])
