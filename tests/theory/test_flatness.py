import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.theory.flatness import apply_decoupling, flat_to_state, invert_decoupling, state_to_flat

speeds = st.floats(1e-3, 10.0)
headings = st.floats(-math.pi + 1e-9, math.pi)
rates = st.floats(-20.0, 20.0)
components = st.floats(-10.0, 10.0)
ULPS = 64 * np.finfo(float).eps


def wrapped(angle):
    return np.abs(np.angle(np.exp(1j * np.asarray(angle))))


@given(speeds, headings, rates, rates)
def test_state_survives_the_way_there_and_back(v, heading, u1, u2):
    velocity, acceleration = state_to_flat(*(np.array([value]) for value in (v, heading, u1, u2)))
    back = flat_to_state(velocity, acceleration)
    scale = abs(u1) + v * abs(u2)
    assert back[0][0] == pytest.approx(v, rel=ULPS)
    assert wrapped(back[1][0] - heading) <= ULPS
    assert back[2][0] == pytest.approx(u1, abs=ULPS * (scale + 1e-12))
    assert back[3][0] == pytest.approx(u2, abs=ULPS * (scale / v + 1e-12))


@given(speeds, headings, components, components)
def test_flat_output_survives_the_way_there_and_back(speed, direction, x2, y2):
    velocity = np.array([[speed * math.cos(direction), speed * math.sin(direction)]])
    acceleration = np.array([[x2, y2]])
    back_velocity, back_acceleration = state_to_flat(*flat_to_state(velocity, acceleration))
    np.testing.assert_allclose(back_velocity, velocity, rtol=0, atol=ULPS * speed)
    np.testing.assert_allclose(back_acceleration, acceleration, rtol=0, atol=ULPS * (abs(x2) + abs(y2)))


@pytest.mark.parametrize("quadrant", [1, 2, 3, 4])
def test_heading_keeps_its_quadrant_on_the_forward_branch(quadrant):
    """The printed (9) answers a quadrant II heading with one in quadrant IV."""
    heading = (quadrant - 0.7) * math.pi / 2.0
    velocity = 0.3 * np.array([[math.cos(heading), math.sin(heading)]])
    speed, answered, *_ = flat_to_state(velocity, np.zeros((1, 2)))
    assert speed[0] == pytest.approx(0.3)
    assert wrapped(answered[0] - heading) < 1e-15
    printed = math.atan(velocity[0, 1] / velocity[0, 0])
    assert (wrapped(printed - heading) > 1.0) == (quadrant in (2, 3))


@given(speeds, headings, components, components)
def test_decoupling_and_its_inverse_are_the_identity(v, heading, x2, y2):
    c, s = np.array([math.cos(heading)]), np.array([math.sin(heading)])
    flat_input = np.array([[x2, y2]])
    inputs = invert_decoupling(np.array([v]), c, s, flat_input)
    np.testing.assert_allclose(
        apply_decoupling(np.array([v]), c, s, *inputs), flat_input, rtol=0, atol=ULPS * (abs(x2) + abs(y2))
    )


@given(speeds, headings, components, components)
def test_inverse_decoupling_agrees_with_the_printed_inputs(v, heading, x2, y2):
    """(13) at the heading of the flat velocity is (10)."""
    c, s = np.array([math.cos(heading)]), np.array([math.sin(heading)])
    acceleration = np.array([[x2, y2]])
    *_, u1, u2 = flat_to_state(v * np.stack([c, s], axis=-1), acceleration)
    w1, w2 = invert_decoupling(np.array([v]), c, s, acceleration)
    scale = abs(x2) + abs(y2)
    np.testing.assert_allclose(u1, w1, rtol=0, atol=ULPS * scale)
    np.testing.assert_allclose(u2, w2, rtol=0, atol=ULPS * scale / v)


def test_decoupling_is_the_printed_matrix():
    """B of (12), written out: first column (cos θ, sin θ), second column v (−sin θ, cos θ)."""
    v, heading = 0.7, 2.2
    c, s = math.cos(heading), math.sin(heading)
    one, zero = np.ones(1), np.zeros(1)
    at = (np.array([v]), np.array([c]), np.array([s]))
    np.testing.assert_array_equal(apply_decoupling(*at, one, zero), [[c, s]])
    np.testing.assert_array_equal(apply_decoupling(*at, zero, one), [[-v * s, v * c]])


def test_left_turn_has_positive_yaw_rate():
    """Heading east and accelerating north at v = 0.5: w = 1/0.5."""
    v, heading, u1, u2 = flat_to_state(np.array([[0.5, 0.0]]), np.array([[0.0, 1.0]]))
    assert (v[0], heading[0], u1[0], u2[0]) == (0.5, 0.0, 0.0, 2.0)


def test_standstill_is_the_singularity_and_says_so():
    """In its values, not in warnings: 0/0 where nothing accelerates, 1/0 where the robot sets off."""
    accelerations = np.array([[1.0, 1.0], [0.0, 0.0]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        speed, _, u1, u2 = flat_to_state(np.array([[0.0, 0.0], [0.0, 0.0]]), accelerations)
        crawling = flat_to_state(np.array([[1e-200, 0.0]]), np.array([[0.0, 1.0]]))
    assert not speed.any()
    assert not np.isfinite(u1).any()
    assert not np.isfinite(u2).any()
    assert crawling[3][0] == np.inf


def test_leading_axes_may_be_any():
    rng = np.random.default_rng(0)
    velocity, acceleration = rng.normal(size=(2, 5, 3, 2))
    speed, heading, u1, u2 = flat_to_state(velocity, acceleration)
    one = flat_to_state(velocity[4, 2], acceleration[4, 2])
    assert speed.shape == heading.shape == (5, 3)
    assert [speed[4, 2], heading[4, 2], u1[4, 2], u2[4, 2]] == list(one)
    back = state_to_flat(speed, heading, u1, u2)
    np.testing.assert_allclose(back[0], velocity, rtol=0, atol=1e-13)
    np.testing.assert_allclose(back[1], acceleration, rtol=0, atol=1e-12)
