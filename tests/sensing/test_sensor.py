"""From the true motion to what a controller sees: the rules of each source, and no hidden state."""

import dataclasses

import numpy as np
import pytest

from slipctl.sensing.sensor import MotionSensor
from slipctl.theory.slip import ProportionalSlip
from slipctl.tick import Array, Motion
from tests.builders import full, leaves
from tests.sensing.worlds import (
    TICK,
    camera,
    delays,
    drive,
    everything,
    headings,
    noise,
    positions,
    sense,
    sensor_of,
    still,
)

TICKS = 60


def slipping() -> list[Motion]:
    times = np.arange(TICKS) * TICK
    law = ProportionalSlip(full(1, -0.2), full(1, 0.15), full(1, 0.4))
    motions = drive(0.6 + 0.2 * np.sin(times), np.cos(2.0 * times), law)
    rates = np.diff([motion.velocity for motion in motions], axis=0, append=0.0) / TICK
    return [
        dataclasses.replace(motion, acceleration=rate) for motion, rate in zip(motions, rates, strict=True)
    ]


def velocities(motions: list[Motion]) -> Array:
    return np.array([motion.velocity[0] for motion in motions])


def accelerations(motions: list[Motion]) -> Array:
    known = [motion.acceleration for motion in motions if motion.acceleration is not None]
    assert len(known) == len(motions)
    return np.array(known)[:, 0]


def same(one: Motion, other: Motion) -> bool:
    """Whether two motions agree in every bit."""
    pairs = zip(leaves(one).items(), leaves(other).items(), strict=True)
    return all(a == b and x.tobytes() == y.tobytes() for (a, x), (b, y) in pairs)


def test_perfect_senses_change_no_bit() -> None:
    motions = slipping()
    for true, seen in zip(motions, sense(sensor_of(1, len(motions)), motions)[1], strict=True):
        assert same(true, seen)


def test_odometry_tells_the_wheels_speed_along_the_heading() -> None:
    motions = slipping()
    sensor = sensor_of(1, len(motions), velocity="odometry")
    for true, seen in zip(motions, sense(sensor, motions)[1], strict=True):
        np.testing.assert_array_equal(seen.velocity, true.forward_speed[:, None] * true.heading_vector)
        np.testing.assert_array_equal(seen.position, true.position)


def test_odometry_takes_the_heading_that_the_robot_believes() -> None:
    motions = slipping()
    sensor = sensor_of(
        1, len(motions), velocity="odometry", pose="odometry_camera", camera=camera(1, rate=0.0)
    )
    seen = sense(sensor, motions)[1]
    np.testing.assert_allclose(np.unwrap(np.arctan2(*velocities(seen).T[::-1])), headings(seen), atol=1e-12)
    assert abs(headings(seen)[-1] - headings(motions)[-1]) > 0.1


def test_differences_are_of_the_position_that_is_seen() -> None:
    motions = slipping()
    sensor = sensor_of(
        1,
        len(motions),
        velocity="differentiated",
        pose="odometry_camera",
        camera=camera(1, position_noise=0.01),
        noise=noise(1, position=0.002),
        delays=delays(1, pose=2 * TICK),
    )
    seen = sense(sensor, motions)[1]
    np.testing.assert_allclose(velocities(seen)[1:], np.diff(positions(seen), axis=0) / TICK, atol=1e-12)


def test_differences_of_the_true_position_are_half_a_tick_late() -> None:
    motions = slipping()
    seen = velocities(sense(sensor_of(1, len(motions), velocity="differentiated"), motions)[1])
    true = velocities(motions)
    # drive() jumps to the new wheel rates at a tick's beginning, so the tick's end shows its mean
    speed = np.hypot(*seen[2:-1].T)
    np.testing.assert_allclose(speed, np.hypot(*true[2:-1].T), rtol=5e-3)
    lag = np.unwrap(np.arctan2(*true[2:-1].T[::-1])) - np.unwrap(np.arctan2(*seen[2:-1].T[::-1]))
    turned = np.diff(headings(motions))[1:-1]
    np.testing.assert_allclose(lag, turned / 2.0, atol=1e-4)


def test_the_first_row_has_no_difference_and_takes_the_odometry() -> None:
    motions = slipping()
    seen = sense(sensor_of(1, len(motions), velocity="differentiated"), motions)[1][0]
    np.testing.assert_allclose(
        seen.velocity, motions[0].forward_speed[:, None] * motions[0].heading_vector, rtol=1e-15
    )


def test_an_accelerometer_on_a_slope_feels_gravity() -> None:
    """At rest on a slope that falls towards x, it reads what holds the robot: uphill."""
    gravity = np.array([[1.7, 0.0]])
    sensor = sensor_of(1, 1, acceleration="imu", gravity=gravity)
    heading = np.array([[0.6, 0.8]])
    seen = sense(sensor, [still(1, heading_vector=heading)])[1][0]
    np.testing.assert_allclose(accelerations([seen]), -gravity, atol=1e-15)


def test_an_accelerometer_on_the_level_tells_the_acceleration() -> None:
    motions = slipping()
    seen = sense(sensor_of(1, len(motions), acceleration="imu"), motions)[1]
    np.testing.assert_allclose(accelerations(seen), accelerations(motions), atol=1e-14)


def test_an_accelerometer_is_turned_by_the_heading_that_the_robot_believes() -> None:
    motions = slipping()
    sensor = sensor_of(
        1, len(motions), acceleration="imu", pose="odometry_camera", camera=camera(1, rate=0.0)
    )
    seen = sense(sensor, motions)[1]
    error = headings(seen)[30] - headings(motions)[30]
    assert abs(error) > 0.05
    c, s = np.cos(error), np.sin(error)
    turned = np.array([[c, -s], [s, c]]) @ accelerations(motions)[30]
    np.testing.assert_allclose(accelerations(seen)[30], turned, atol=1e-12)


def test_an_accelerometer_needs_an_acceleration() -> None:
    with pytest.raises(ValueError, match="acceleration"):
        sensor_of(1, 1, acceleration="imu").start(still(1, acceleration=None))


def test_the_model_source_tells_no_acceleration() -> None:
    sensor = sensor_of(1, 1, acceleration="model", noise=noise(1, acceleration=1.0))
    assert sense(sensor, [still(1)])[1][0].acceleration is None


def stacked(worlds: list[list[Motion]]) -> list[Motion]:
    """Return the motions of several robots as one batch."""
    return [
        Motion(
            *(
                np.concatenate([getattr(motion, field.name) for motion in motions])
                for field in dataclasses.fields(Motion)
            )
        )
        for motions in zip(*worlds, strict=True)
    ]


def test_a_batch_of_one_equals_its_row() -> None:
    mirrored = [
        dataclasses.replace(
            motion, wheel_angle=motion.wheel_angle[:, ::-1], wheel_rate=motion.wheel_rate[:, ::-1]
        )
        for motion in slipping()
    ]
    worlds = [slipping(), mirrored, slipping()[::-1]]
    seeds = [4, 8, 15]
    together = sense(everything(3, seeds, TICKS + 1), stacked(worlds))
    for row, (motions, seed) in enumerate(zip(worlds, seeds, strict=True)):
        memories, alone = sense(everything(1, [seed], TICKS + 1), motions)
        for k in range(TICKS + 1):
            batch, single = leaves(together[1][k]), leaves(alone[k])
            assert all(batch[name][row].tobytes() == single[name][0].tobytes() for name in single)
            assert together[0][k].fix[row] == memories[k].fix[0]


def test_a_measurement_goes_on_from_any_memory_and_changes_none() -> None:
    """Memories are values: old ones stay valid, and the same one gives the same bits."""
    motions = slipping()
    sensor = everything(1, [23], len(motions))
    memories, seen = sense(sensor, motions)
    for k in (10, 30):
        kept = {name: np.copy(leaf) for name, leaf in leaves(memories[k]).items()}
        memory = memories[k]
        for row in range(k + 1, len(motions)):
            memory, sight = sensor.measure(memory, row, motions[row])
            assert same(sight, seen[row])
        assert all(np.array_equal(leaf, kept[name]) for name, leaf in leaves(memories[k]).items())


def test_settings_say_what_is_sensed() -> None:
    """Every imperfection of `everything` shows: none of its switches is dead."""
    motions = slipping()
    full_sensor = everything(1, [5], len(motions))

    def view(sensor: MotionSensor) -> list[Motion]:
        return sense(sensor, motions)[1]

    for change in (
        {"camera": None},
        {"velocity_source": "true"},
        {"acceleration_source": "true"},
        {"heading_noise": None},
        {"yaw_rate_noise": None},
        {"gravity": np.array([[0.5, 0.0]])},
        *({name: dataclasses.replace(getattr(full_sensor, name), noise=None)} for name in CHANNELS),
        *(
            {name: dataclasses.replace(getattr(full_sensor, name), delay=np.zeros(1, dtype=np.int64))}
            for name in CHANNELS
        ),
    ):
        other = view(dataclasses.replace(full_sensor, **change))
        assert not all(same(one, two) for one, two in zip(view(full_sensor), other, strict=True)), change


CHANNELS = ("pose", "velocity", "acceleration")
