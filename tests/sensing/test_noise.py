"""Noise belongs to a world: to its seed, and to nothing else."""

from itertools import combinations

import numpy as np
import pytest

from slipctl.sensing.noise import Stream, phases, white
from slipctl.sensing.sensor import MotionSensor
from slipctl.tick import Array, Motion
from tests.builders import full
from tests.sensing.worlds import camera, everything, noise, sense, sensor_of, still

ROWS = 4000


def drawn(
    seeds: list[int], stream: Stream = Stream.POSITION, count: int = ROWS, components: int = 2
) -> Array:
    values = white(seeds, stream, full(len(seeds), 2.0), count, components)
    assert values is not None
    return values


def test_white_noise_is_white_and_has_its_deviation() -> None:
    values: Array = drawn([5])[:, 0]
    assert values.mean() == pytest.approx(0.0, abs=4.0 * 2.0 / np.sqrt(values.size))
    assert values.std() == pytest.approx(2.0, rel=0.03)
    for lag in (1, 2, 10):
        assert correlation(values[lag:, 0], values[:-lag, 0]) == pytest.approx(0.0, abs=0.06)
    assert correlation(values[:, 0], values[:, 1]) == pytest.approx(0.0, abs=0.06)


def correlation(one: Array, other: Array) -> float:
    return float(np.mean(one * other) / (one.std() * other.std()))


def test_streams_and_seeds_are_independent() -> None:
    columns = [drawn([seed], stream)[:, 0, 0] for stream in Stream for seed in (0, 1)]
    assert max(abs(correlation(one, other)) for one, other in combinations(columns, 2)) < 0.07


def test_a_world_draws_the_same_in_any_company_and_for_any_time() -> None:
    together = drawn([7, 3, 9])
    np.testing.assert_array_equal(together[:, 1], drawn([3])[:, 0])
    np.testing.assert_array_equal(together[:100], drawn([7, 3, 9], count=100))
    np.testing.assert_array_equal(phases([7, 3])[1:], phases([3]))


def test_no_noise_is_not_drawn() -> None:
    assert white([1, 2], Stream.POSITION, full(2, 0.0), ROWS, 2) is None


def test_worlds_have_their_own_deviations() -> None:
    values = white([4, 4], Stream.VELOCITY, np.array([0.0, 0.5]), ROWS, 2)
    assert values is not None
    assert not values[:, 0].any()
    assert values[:, 1].std() == pytest.approx(0.5, rel=0.03)


def seen_at_rest(sensor: MotionSensor) -> list[Motion]:
    return sense(sensor, [still(1)] * ROWS)[1]


@pytest.mark.parametrize("signal", ["position", "velocity", "acceleration"])
def test_a_signal_gets_its_noise_and_no_other(signal: str) -> None:
    seen = seen_at_rest(sensor_of(1, ROWS, noise=noise(1, **{signal: 0.02})))
    for name in ("position", "velocity", "acceleration", "heading_vector", "heading_rate", "wheel_angle"):
        off = np.array([getattr(motion, name)[0] - getattr(still(1), name)[0] for motion in seen])
        if name == signal:
            np.testing.assert_allclose(off.std(axis=0), 0.02, rtol=0.05)
        else:
            assert not off.any()


def test_the_heading_gets_its_noise() -> None:
    seen = seen_at_rest(sensor_of(1, ROWS, noise=noise(1, heading=0.1)))
    vectors = np.array([motion.heading_vector[0] for motion in seen])
    np.testing.assert_allclose(np.hypot(*vectors.T), 1.0, atol=1e-14)
    assert np.arctan2(*vectors.T[::-1]).std() == pytest.approx(0.1, rel=0.05)


def test_the_gyro_gets_its_noise() -> None:
    seen = seen_at_rest(sensor_of(1, ROWS, noise=noise(1, yaw_rate=0.03)))
    assert np.std([motion.heading_rate[0] for motion in seen]) == pytest.approx(0.03, rel=0.05)


def test_switching_a_noise_on_changes_no_other() -> None:
    alone = seen_at_rest(sensor_of(1, ROWS, noise=noise(1, velocity=0.1)))
    both = seen_at_rest(
        sensor_of(
            1,
            ROWS,
            noise=noise(1, velocity=0.1, position=0.1),
            pose="odometry_camera",
            camera=camera(1, position_noise=0.1),
        )
    )
    for one, other in zip(alone[:50], both[:50], strict=True):
        np.testing.assert_array_equal(one.velocity, other.velocity)


def test_a_sensor_draws_nothing_after_it_is_built() -> None:
    """Two controllers that do different things meet the same noise."""
    sensor = everything(1, [11], 50)
    noise_before = sensor.pose.noise
    first = sense(sensor, [still(1)] * 50)[1]
    moved = still(1, position=np.array([[3.0, 4.0]]))
    second = sense(sensor, [moved] * 50)[1]
    assert noise_before is sensor.pose.noise
    for one, other in zip(first, second, strict=True):
        np.testing.assert_allclose(other.position - one.position, [[3.0, 4.0]], atol=1e-14)
