"""A path run from rest to rest: its clock, its derivatives, and the division by a rate that vanishes."""

import math

import numpy as np
import pytest

from slipctl.theory.time_scale import LEAST_RATE, PathRatio, TimeScaled, path_velocity, smooth_step
from slipctl.tick import PathTime, Reference
from tests.builders import full, table_one

TICK = 0.05
TOTAL, DURATION = 20.0, 30.0


def plan(worlds=1, tick=TICK):
    return TimeScaled(table_one(worlds), full(worlds, TOTAL), full(worlds, DURATION), tick)


def path_time(reference: Reference) -> PathTime:
    assert reference.path_time is not None
    return reference.path_time


def test_the_clock_rests_at_both_ends_and_never_goes_back():
    times = np.linspace(-1.0, DURATION + 1.0, 3201)[None]
    elapsed, rate, second, third = smooth_step(times, np.array([[DURATION]]), np.array([[TOTAL]]))
    before, after = times <= 0.0, times >= DURATION
    assert (elapsed[before] == 0.0).all()
    assert (elapsed[after] == TOTAL).all()
    for at_rest in (rate, second):
        assert (at_rest[before | after] == 0.0).all()
    assert (third[(times < 0.0) | (times > DURATION)] == 0.0).all()
    assert (np.diff(elapsed[0]) >= 0.0).all()
    assert (rate[~before & ~after] > 0.0).all()
    assert rate.max() == pytest.approx(15.0 / 8.0 * TOTAL / DURATION, rel=1e-12)


def test_the_clock_s_derivatives_are_derivatives():
    step = 1e-5
    times = np.linspace(1.0, DURATION - 1.0, 57)[None]
    totals = np.array([[DURATION]]), np.array([[TOTAL]])
    ahead, behind = smooth_step(times + step, *totals), smooth_step(times - step, *totals)
    here = smooth_step(times, *totals)
    for order in range(3):
        slope = (ahead[order] - behind[order]) / (2.0 * step)
        np.testing.assert_allclose(here[order + 1], slope, rtol=0, atol=2e-9)


def test_the_clock_s_third_derivative_jumps_at_both_ends_and_has_its_jump_there():
    """60 total/duration³ on arrival and on departure, inside of the ends; nothing beside them."""
    times = np.array([[-1e-9, 0.0, DURATION, DURATION + 1e-9]])
    third = smooth_step(times, np.array([[DURATION]]), np.array([[TOTAL]]))[3][0]
    most = 60.0 * TOTAL / DURATION**3
    np.testing.assert_allclose(third, [0.0, most, most, 0.0], rtol=1e-14)


def test_the_plan_s_derivatives_are_derivatives_by_real_time():
    step = 1e-4
    times = np.linspace(0.5, DURATION - 0.5, 59)
    here, ahead, behind = plan().at(times), plan().at(times + step), plan().at(times - step)
    for value, rate in (("position", "velocity"), ("velocity", "acceleration"), ("acceleration", "jerk")):
        slope = (getattr(ahead, value) - getattr(behind, value)) / (2.0 * step)
        np.testing.assert_allclose(getattr(here, rate), slope, rtol=0, atol=1e-9)
        assert np.abs(slope).max() > 1e-3, value


def test_the_path_is_that_of_its_own_time_and_stops_at_the_goal():
    times = np.arange(0.0, DURATION + 2.0, TICK)
    scaled = plan().at(times)
    path = path_time(scaled)
    own = table_one().at(path.elapsed[0])
    np.testing.assert_array_equal(scaled.position, own.position)
    np.testing.assert_array_equal(path.velocity, own.velocity)
    np.testing.assert_array_equal(path.acceleration, own.acceleration)
    np.testing.assert_allclose(scaled.position[0, [0, -1]], [[0.0, 0.0], [1.2, 1.5]], atol=1e-12)
    for still in (scaled.velocity, scaled.acceleration):
        assert (still[0, [0, -1]] == 0.0).all()
    assert np.hypot(path.velocity[..., 0], path.velocity[..., 1]).min() == pytest.approx(0.0937, abs=1e-4)


def test_one_tick_ahead_is_the_next_row():
    path = path_time(plan().at(np.arange(0.0, DURATION + TICK, TICK)))
    np.testing.assert_allclose(path.elapsed_after[:, :-1], path.elapsed[:, 1:], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.rate_after[:, :-1], path.rate[:, 1:], rtol=0, atol=1e-12)
    assert path.rate_after[0, -2] == 0.0


def test_worlds_with_clocks_of_their_own_do_not_mix():
    both = TimeScaled(table_one(2), np.array([20.0, 20.0]), np.array([30.0, 12.0]), TICK).at(np.arange(31.0))
    for world, duration in enumerate((30.0, 12.0)):
        one = TimeScaled(table_one(), full(1, 20.0), full(1, duration), TICK).at(np.arange(31.0))
        np.testing.assert_array_equal(both.position[world], one.position[0])
        np.testing.assert_array_equal(both.jerk[world], one.jerk[0])
        np.testing.assert_array_equal(path_time(both).rate[world], path_time(one).rate[0])


SIGMA = 0.4 - 0.4j


def moving(rate, heading, path_speed):
    """Return Ḟ and heading vector of a robot whose slip ratio is SIGMA."""
    facing = np.exp(1j * np.array([heading]))
    velocity = rate * path_speed * (1.0 + SIGMA) * facing
    return tuple(np.stack([np.real(number), np.imag(number)], -1) for number in (velocity, facing))


def as_complex(pair):
    return complex(pair[0, 0], pair[0, 1])


def test_a_ratio_is_the_velocity_seen_from_the_robot_in_units_of_its_speed():
    """Facing +y at ṽ = 0.5: (−0.2, 0.4) m/s is 0.8 along and 0.4 to the left; facing back, −0.4 and −0.2."""
    velocity = np.array([[-0.2, 0.4], [0.2, 0.1]])
    ratio = PathRatio(velocity, np.array([[0.0, 1.0], [-1.0, 0.0]]), full(2, 0.5))
    np.testing.assert_array_equal(ratio.value, [[0.8, 0.4], [-0.4, -0.2]])


def test_the_rate_of_the_path_is_told_where_its_time_passes():
    velocity, facing = moving(0.3, 1.1, 0.12)
    held = PathRatio.of(np.array([[1.0, 0.0]]))
    found, ratio = path_velocity(velocity, facing, full(1, 0.3), full(1, 0.12), held)
    np.testing.assert_allclose(found, velocity / 0.3, rtol=1e-15)
    assert as_complex(ratio.value) == pytest.approx(1.0 + SIGMA, rel=1e-12)


def test_the_threshold_itself_still_tells():
    velocity, facing = moving(LEAST_RATE, 1.1, 0.12)
    held = PathRatio.of(np.array([[1.0, 0.0]]))
    found, ratio = path_velocity(velocity, facing, full(1, LEAST_RATE), full(1, 0.12), held)
    np.testing.assert_allclose(found, velocity / LEAST_RATE, rtol=1e-15)
    assert as_complex(ratio.value) == pytest.approx(1.0 + SIGMA, rel=1e-12)


@pytest.mark.parametrize("path_speed", [0.0, -0.1])
def test_a_robot_that_is_not_asked_to_move_forward_tells_its_rate_but_no_ratio(path_speed):
    velocity, facing = np.array([[0.03, -0.02]]), moving(0.3, 1.1, 0.0)[1]
    held = PathRatio.of(np.array([[1.4, -0.4]]))
    found, ratio = path_velocity(velocity, facing, full(1, 0.3), full(1, path_speed), held)
    np.testing.assert_allclose(found, velocity / 0.3, rtol=1e-15)
    np.testing.assert_array_equal(ratio.value, [[1.4, -0.4]])


@pytest.mark.parametrize("rate", [0.0, 0.5 * LEAST_RATE])
def test_the_ratio_is_held_where_the_path_s_time_hardly_passes(rate):
    """Turned with the robot, scaled with ṽ; whatever the velocity says, even what a lagging servo leaves."""
    nonsense, facing = np.array([[0.3, -0.2]]), moving(0.0, -2.0, 0.0)[1]
    held = PathRatio.of(np.array([[1.4, -0.4]]))
    found, ratio = path_velocity(nonsense, facing, full(1, rate), full(1, 0.07), held)
    expected = 0.07 * (1.4 - 0.4j) * np.exp(-2.0j)
    assert as_complex(found) == pytest.approx(complex(expected), rel=1e-12)
    np.testing.assert_array_equal(ratio.value, [[1.4, -0.4]])


def test_each_world_is_told_or_held_for_itself():
    velocity = np.array([[0.03, -0.02], [0.05, 0.01], [0.02, 0.04]])
    facing = np.array([[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]])
    rates, speeds = np.array([0.3, 0.001, 0.5]), np.array([0.1, 0.2, 0.15])
    held = np.array([[1.4, -0.4], [1.2, 0.3], [0.9, 0.1]])
    found, ratio = path_velocity(velocity, facing, rates, speeds, PathRatio.of(held))
    for world in range(3):
        row = slice(world, world + 1)
        seen = velocity[row], facing[row], rates[row], speeds[row]
        alone = path_velocity(*seen, PathRatio.of(held[row]))
        np.testing.assert_array_equal(found[row], alone[0])
        np.testing.assert_array_equal(ratio.value[row], alone[1].value)


def test_no_jump_where_holding_begins():
    """On either side of the threshold a robot whose slip ratio does not change looks the same."""
    ratio = PathRatio.of(np.array([[1.0, 0.0]]))
    looks = []
    for rate in (LEAST_RATE * 1.001, LEAST_RATE * 0.999):
        velocity, facing = moving(rate, 0.4, 0.1)
        found, ratio = path_velocity(velocity, facing, full(1, rate), full(1, 0.1), ratio)
        looks.append(as_complex(found))
    assert looks[0] == pytest.approx(looks[1], rel=1e-12)


def test_holding_takes_a_negligible_share_of_the_path():
    """With equal durations 6e-5 of the path's time at each end, as the docstring says."""
    one = np.ones((1, 1))
    shares = math.sqrt(LEAST_RATE / 30.0) + np.linspace(0.0, 1e-3, 1001)[None]
    elapsed, rate, _, _ = smooth_step(shares, one, one)
    held = np.count_nonzero(rate < LEAST_RATE)
    assert 0 < held < shares.size
    assert elapsed[0, held] == pytest.approx(6e-5, abs=0.5e-5)
