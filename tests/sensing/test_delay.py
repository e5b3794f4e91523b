"""Late signals are late by exactly their delay."""

from dataclasses import replace

import numpy as np
import pytest

from slipctl.sensing.delay import DelayLine, ticks_until, whole_ticks
from slipctl.tick import Array, Motion
from tests.builders import full
from tests.sensing.worlds import TICK, delays, noise, sense, sensor_of, still


def numbered(count: int, worlds: int = 1) -> list[Motion]:
    """Return motions whose every signal tells the row."""
    return [
        still(
            worlds,
            position=np.full((worlds, 2), float(k)),
            velocity=np.full((worlds, 2), 100.0 + k),
            acceleration=np.full((worlds, 2), 200.0 + k),
            heading_vector=np.tile([np.cos(0.01 * k), np.sin(0.01 * k)], (worlds, 1)),
        )
        for k in range(count)
    ]


def values(motions: list[Motion], name: str, world: int = 0) -> Array:
    return np.array([getattr(motion, name)[world] for motion in motions])


@pytest.mark.parametrize("late", [1, 2, 7])
@pytest.mark.parametrize("signal", ["pose", "velocity", "acceleration"])
def test_a_signal_comes_exactly_so_many_ticks_late(signal: str, late: int) -> None:
    motions = numbered(30)
    sensor = sensor_of(1, len(motions), delays=delays(1, **{signal: late * TICK}))
    seen = sense(sensor, motions)[1]
    delayed = {"pose": ("position", "heading_vector")}.get(signal, (signal,))
    for name in ("position", "heading_vector", "velocity", "acceleration"):
        true, sensed = values(motions, name), values(seen, name)
        if name in delayed:
            np.testing.assert_array_equal(sensed[late:], true[:-late])
            np.testing.assert_array_equal(sensed[:late], np.repeat(true[:1], late, axis=0))
        else:
            np.testing.assert_array_equal(sensed, true)


def test_worlds_have_their_own_delays() -> None:
    motions = numbered(20, worlds=3)
    late = replace(delays(3), pose=np.array([0.0, 1.0, 4.0]) * TICK)
    seen = sense(sensor_of(3, len(motions), delays=late), motions)[1]
    for world, ticks in enumerate((0, 1, 4)):
        np.testing.assert_array_equal(values(seen, "position", world)[4:, 0], np.arange(4.0, 20.0) - ticks)


def test_a_delayed_signal_is_delayed_with_its_noise() -> None:
    motions = [still(1)] * 20
    here, late = (
        sense(sensor_of(1, 20, noise=noise(1, velocity=1.0), delays=delays(1, velocity=seconds)), motions)[1]
        for seconds in (0.0, 3 * TICK)
    )
    np.testing.assert_array_equal(values(late, "velocity")[3:], values(here, "velocity")[:-3])


def test_pushing_leaves_the_old_line_alone() -> None:
    line = DelayLine.filled(np.zeros((2, 1)), 3)
    later = line.push(np.ones((2, 1)))
    assert not line.past.any()
    assert later.past[:, 0, 0].tolist() == [1.0, 0.0, 0.0, 0.0]


def test_seconds_become_ticks() -> None:
    # 0.15 s in ticks of 0.05 s is 2.9999999999999996 in floating point
    seconds = np.array([0.0, 0.05, 0.15, 0.35])
    assert whole_ticks(seconds, 0.05).tolist() == [0, 1, 3, 7]
    assert ticks_until(seconds, 0.05).tolist() == [0, 1, 3, 7]
    assert ticks_until(full(1, 0.051), 0.05).tolist() == [2]
