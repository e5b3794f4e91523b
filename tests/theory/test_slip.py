import functools
import math
from typing import Any

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from slipctl.theory.flatness import invert_decoupling
from slipctl.theory.slip import (
    Affine,
    NoSlip,
    ProportionalSlip,
    SeriesSlip,
    SinusoidalSlip,
    measure_slip,
    slip_ratio,
    slipping_velocity,
)
from slipctl.theory.slip_terms import slip_terms
from slipctl.tick import Array, Motion, Slip

COMPONENTS = ("longitudinal", "lateral", "yaw")

rates = st.floats(-5.0, 5.0)
headings = st.floats(-math.pi, math.pi)


def lift(value) -> Array:
    return np.array([float(value)])


def slip_of(v_t, v_s, w_s) -> Slip:
    return Slip(lift(v_t), lift(v_s), lift(w_s))


def motion_of(v, w, slip, heading):
    """Return the motion of a robot that slips, by (28)."""
    c, s = np.cos(heading), np.sin(heading)
    return Motion(
        position=np.zeros((len(v), 2)),
        velocity=np.stack(slipping_velocity(v, slip, c, s), axis=-1),
        heading_vector=np.stack([c, s], axis=-1),
        heading_rate=w + slip.yaw,
        wheel_rate=np.full((len(v), 2), np.nan),  # never looked at
        wheel_angle=np.full((len(v), 2), np.nan),
        forward_speed=v,
        yaw_rate=w,
        acceleration=np.full((len(v), 2), np.nan),
    )


def moving(velocity, heading_vector, heading_rate, forward_speed, yaw_rate):
    """Return a motion of which only what the slip is measured from means anything."""
    nothing = np.full_like(velocity, np.nan)
    return Motion(
        nothing, velocity, heading_vector, heading_rate, nothing, nothing, forward_speed, yaw_rate, nothing
    )


@given(rates, rates, rates, rates, rates, headings)
def test_measured_slip_is_the_prescribed_one(v, w, v_t, v_s, w_s, heading):
    measured = measure_slip(motion_of(lift(v), lift(w), slip_of(v_t, v_s, w_s), lift(heading)))
    tolerance = 1e-15 * (1.0 + abs(v) + abs(v_t) + abs(v_s) + abs(w) + abs(w_s))
    assert measured.longitudinal[0] == pytest.approx(v_t, abs=4 * tolerance)
    assert measured.lateral[0] == pytest.approx(v_s, abs=4 * tolerance)
    assert measured.yaw[0] == pytest.approx(w_s, abs=4 * tolerance)


@pytest.mark.parametrize(
    ("heading", "pushed_to", "lateral"),
    [
        (0.0, (0.0, -0.2), 0.2),  # facing +x, pushed to −y: to the right
        (0.0, (0.0, 0.2), -0.2),
        (math.pi / 2.0, (0.2, 0.0), 0.2),  # facing +y, pushed to +x: to the right
        (math.pi, (0.0, 0.2), 0.2),
        (-math.pi / 2.0, (-0.2, 0.0), 0.2),
    ],
)
def test_lateral_slip_is_positive_to_the_right(heading, pushed_to, lateral):
    c, s = math.cos(heading), math.sin(heading)
    still = np.zeros(1)
    motion = moving(np.array([pushed_to]), np.array([[c, s]]), still, still, still)
    slip = measure_slip(motion)
    assert slip.lateral[0] == pytest.approx(lateral, abs=1e-15)
    assert slip.longitudinal[0] == pytest.approx(0.0, abs=1e-15)


def test_locked_wheels_slide_forward_with_positive_slip_and_spinning_ones_with_negative():
    still, rolling = np.zeros(1), np.ones(1)
    ahead = np.array([[1.0, 0.0]])
    east = np.array([[1.0, 0.0]])
    locked = measure_slip(moving(ahead, east, still, still, still))
    spinning = measure_slip(moving(0.0 * ahead, east, still, rolling, still))
    assert locked.longitudinal[0] == 1.0
    assert spinning.longitudinal[0] == -1.0


def test_yaw_slip_is_what_the_body_turns_more_than_the_wheels_say():
    zero = np.zeros(1)
    pair = np.zeros((1, 2))
    motion = moving(pair, np.array([[1.0, 0.0]]), np.array([0.7]), zero, np.array([0.5]))
    assert measure_slip(motion).yaw[0] == pytest.approx(0.2)


@functools.cache
def derived_terms():
    """Derive C and D of (32) from (29) by symbolic differentiation, as one numeric function."""
    t = sympy.Symbol("t")
    v, heading, v_t, v_s = functions = [sympy.Function(name)(t) for name in ("v", "h", "vt", "vs")]
    u1, u2, w_s, dv_t, dv_s = sympy.symbols("u1 u2 ws dvt dvs")
    c, s = sympy.cos(heading), sympy.sin(heading)
    first = sympy.Matrix([(v + v_t) * c + v_s * s, (v + v_t) * s - v_s * c])
    second: Any = first.diff(t).subs(
        {v.diff(t): u1, heading.diff(t): u2 + w_s, v_t.diff(t): dv_t, v_s.diff(t): dv_s}
    )
    without = sympy.Matrix([[c, -v * s], [s, v * c]])
    rest: Any = sympy.expand(second - without * sympy.Matrix([u1, u2]))
    d_matrix = rest.jacobian([u1, u2])
    c_matrix = rest.subs({u1: 0, u2: 0})
    symbols = sympy.symbols("v_ h_ vt_ vs_")
    plain: Any = dict(zip(functions, symbols, strict=True))
    return sympy.lambdify(
        [*symbols, w_s, dv_t, dv_s], [c_matrix.subs(plain), d_matrix.subs(plain)], modules="numpy"
    )


@given(rates, headings, rates, rates, rates, rates, rates)
def test_c_and_d_are_the_second_derivative_of_the_slipping_flat_output(v, heading, v_t, v_s, w_s, dv_t, dv_s):
    c_matrix, d_matrix = slip_terms(
        lift(v),
        slip_of(v_t, v_s, w_s),
        lift(dv_t),
        lift(dv_s),
        lift(math.cos(heading)),
        lift(math.sin(heading)),
    )
    c_derived, d_derived = derived_terms()(v, heading, v_t, v_s, w_s, dv_t, dv_s)
    np.testing.assert_allclose(c_matrix[0], np.ravel(c_derived), rtol=0, atol=1e-13)
    np.testing.assert_allclose(d_matrix[0], d_derived, rtol=0, atol=1e-14)


def test_c_and_d_of_a_history_are_those_of_its_instants():
    v, rate, other, heading, *slips = np.random.default_rng(4).uniform(-1.0, 1.0, (7, 2, 3))
    whole = slip_terms(v, Slip(*slips), rate, other, np.cos(heading), np.sin(heading))
    for k in range(3):
        alone = slip_terms(
            v[:, k],
            Slip(*(array[:, k] for array in slips)),
            rate[:, k],
            other[:, k],
            np.cos(heading[:, k]),
            np.sin(heading[:, k]),
        )
        np.testing.assert_array_equal(whole[0][:, k], alone[0])
        np.testing.assert_array_equal(whole[1][:, k], alone[1])


def test_c_and_d_vanish_without_slip():
    zero = np.zeros(3)
    heading = np.array([0.3, 2.0, -2.5])
    c_matrix, d_matrix = slip_terms(
        np.array([0.1, 1.0, -2.0]), Slip(zero, zero, zero), zero, zero, np.cos(heading), np.sin(heading)
    )
    assert not c_matrix.any()
    assert not d_matrix.any()


@pytest.mark.parametrize("seed", range(5))
def test_uncertainty_is_what_a_finite_difference_of_the_velocity_sees(seed):
    """η = D B⁻¹ v + C, (36), against (Ḟ(h) − Ḟ(−h))/(2h) − v of a motion given in closed form."""
    rng = np.random.default_rng(seed)
    v, heading = rng.uniform(0.2, 1.0), rng.uniform(-math.pi, math.pi)
    amplitude, frequency, phase = rng.uniform(0.1, 0.5, 3), rng.uniform(1.0, 3.0, 3), rng.uniform(0, 6, 3)
    flat_input = rng.uniform(-1.0, 1.0, (1, 2))

    def slip(t):
        return slip_of(*(amplitude * np.sin(frequency * t + phase)))

    facing = lift(math.cos(heading)), lift(math.sin(heading))
    u1, u2 = invert_decoupling(lift(v), facing[0], facing[1], flat_input)

    def velocity(t):
        swing = np.cos(phase[2]) - np.cos(frequency[2] * t + phase[2])  # ∫ w_s
        angle = heading + u2 * t + amplitude[2] / frequency[2] * swing
        return np.stack(slipping_velocity(v + u1 * t, slip(t), np.cos(angle), np.sin(angle)), axis=-1)

    h = 1e-5
    seen = (velocity(h) - velocity(-h)) / (2.0 * h) - flat_input
    rate = amplitude * frequency * np.cos(phase)
    c_matrix, d_matrix = slip_terms(lift(v), slip(0.0), lift(rate[0]), lift(rate[1]), facing[0], facing[1])
    uncertainty = d_matrix[0] @ np.array([u1[0], u2[0]]) + c_matrix[0]
    np.testing.assert_allclose(uncertainty, seen[0], rtol=0, atol=1e-8)
    assert np.hypot(*uncertainty) > 0.05


def test_norm_of_e_is_the_slip_ratio():
    """(50): ‖D B⁻¹‖ = √(v_t² + v_s²)/|v|."""
    v, v_t, v_s, heading = 0.5, 0.1, -0.3, 1.1
    c, s = math.cos(heading), math.sin(heading)
    d_matrix = slip_terms(lift(v), slip_of(v_t, v_s, 0.0), lift(0.0), lift(0.0), lift(c), lift(s))[1][0]
    inverse = np.linalg.inv([[c, -v * s], [s, v * c]])
    assert np.linalg.norm(d_matrix @ inverse, 2) == pytest.approx(math.hypot(v_t, v_s) / v, rel=1e-12)
    assert slip_ratio(lift(v_t), lift(v_s), lift(v))[0] == pytest.approx(math.hypot(v_t, v_s) / v, rel=1e-15)


def test_slip_ratio_stays_finite_at_standstill_and_ignores_the_sign_of_the_speed():
    ratio = slip_ratio(np.array([0.03, 0.03]), np.array([0.04, 0.04]), np.array([0.0, -0.5]))
    np.testing.assert_allclose(ratio, [1.0, 0.1], rtol=1e-15)


def test_slip_laws():
    v = np.array([0.1, -0.2])
    still = NoSlip(2).affine(3.0).at(v)
    assert not np.any([still.longitudinal, still.lateral, still.yaw])
    fractions = (np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.array([0.5, 0.6]))
    proportional = ProportionalSlip(*fractions).affine(99.0).at(v)
    np.testing.assert_array_equal(proportional.longitudinal, [0.1 * 0.1, 0.2 * -0.2])
    np.testing.assert_array_equal(proportional.lateral, [0.3 * 0.1, 0.4 * -0.2])
    np.testing.assert_array_equal(proportional.yaw, [0.5 * 0.1, 0.6 * -0.2])
    swinging = SinusoidalSlip(*fractions, period=np.array([4.0, 8.0]))
    quarter = swinging.affine(1.0).at(v)  # a quarter of the first period, an eighth of the second
    np.testing.assert_allclose(quarter.lateral, [0.03, -0.08 * math.sqrt(0.5)], rtol=1e-15)
    np.testing.assert_allclose(quarter.longitudinal, [0.01, -0.04 * math.sqrt(0.5)], rtol=1e-15)
    np.testing.assert_allclose(quarter.yaw, [0.05, -0.12 * math.sqrt(0.5)], rtol=1e-15)
    assert not swinging.affine(0.0).at(v).lateral.any()


def test_fractions_that_do_not_change_have_no_rate():
    fractions = (np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.array([0.5, 0.6]))
    for law in (NoSlip(2), ProportionalSlip(*fractions)):
        for rate in (law.affine_rate(3.0).fraction, law.affine_rate(3.0).offset, law.affine(3.0).offset):
            for name in COMPONENTS:
                still = getattr(rate, name)
                assert still.shape == (2,)
                assert not still.any()


def test_swinging_fractions_change_at_their_derivative():
    """Central differences of a sine at this step err by less than 1e-8."""
    law = SinusoidalSlip(
        np.array([0.1, 0.2]), np.array([0.3, 0.4]), np.array([0.5, 0.6]), period=np.array([4.0, 8.0])
    )
    step = 1e-4
    for time in (0.0, 0.7, 5.3):
        rate, ahead, behind = law.affine_rate(time), law.affine(time + step), law.affine(time - step)
        for name in COMPONENTS:
            slope = (getattr(ahead.fraction, name) - getattr(behind.fraction, name)) / (2.0 * step)
            np.testing.assert_allclose(getattr(rate.fraction, name), slope, rtol=0, atol=1e-8)
            assert getattr(rate.offset, name).shape == (2,)
            assert not getattr(rate.offset, name).any()
    assert law.affine_rate(0.0).fraction.lateral[0] == pytest.approx(0.3 * math.pi / 2.0, rel=1e-14)


KNOTS = np.array([0.5, 1.0, 2.5, 4.0])
TABLES = np.random.default_rng(11).uniform(-0.5, 0.5, (3, 2, 4))
SERIES = SeriesSlip(KNOTS, *TABLES)


@given(st.floats(-1.0, 6.0), rates)
def test_a_series_is_linear_between_its_samples_and_held_at_its_ends(time, v):
    slip = SERIES.affine(time).at(np.full(2, v))
    for name, table in zip(COMPONENTS, TABLES, strict=True):
        expected = [np.interp(time, KNOTS, row) for row in table]
        np.testing.assert_allclose(getattr(slip, name), expected, rtol=0, atol=1e-15)


@pytest.mark.parametrize("sample", range(4))
def test_a_series_meets_its_samples(sample):
    slip = SERIES.affine(float(KNOTS[sample])).offset
    assert SERIES.affine(float(KNOTS[sample])).fraction.yaw.shape == (2,)
    for name, table in zip(COMPONENTS, TABLES, strict=True):
        np.testing.assert_allclose(getattr(slip, name), table[:, sample], rtol=0, atol=1e-16)


@pytest.mark.parametrize(
    ("time", "piece"),
    [(0.4, None), (0.5, 0), (0.7, 0), (1.0, 1), (2.4, 1), (2.5, 2), (3.9, 2), (4.0, None), (4.1, None)],
)
def test_the_rate_of_a_series_is_the_slope_to_the_right_and_none_beyond_the_ends(time, piece):
    rate = SERIES.affine_rate(time)
    for name, table in zip(COMPONENTS, TABLES, strict=True):
        slopes = np.diff(table, axis=1) / np.diff(KNOTS)
        expected = np.zeros(2) if piece is None else slopes[:, piece]
        np.testing.assert_allclose(getattr(rate.offset, name), expected, rtol=1e-15)
        assert getattr(rate.fraction, name).shape == (2,)
        assert not getattr(rate.fraction, name).any()


def test_a_series_of_two_samples_is_a_ramp():
    ramp = SeriesSlip(np.array([1.0, 3.0]), *(np.array([[0.0, factor]]) for factor in (1.0, 2.0, -4.0)))
    for time, share in ((0.0, 0.0), (1.0, 0.0), (1.5, 0.25), (3.0, 1.0), (9.0, 1.0)):
        slip = ramp.affine(time).offset
        assert (slip.longitudinal[0], slip.lateral[0], slip.yaw[0]) == (share, 2.0 * share, -4.0 * share)


@pytest.mark.parametrize("law", [ProportionalSlip(*TABLES[:, :, 0]), SERIES, NoSlip(2)])
def test_instants_together_are_each_instant_bit_for_bit(law):
    instants = [law.affine(time) for time in (0.7, 0.7, 1.9)]
    speeds = np.array([[0.3, -0.0], [0.4, 1.1], [-0.5, 0.0]])
    together = Affine.together(instants).at(speeds)
    for k, (one, speed) in enumerate(zip(instants, speeds, strict=True)):
        for name in COMPONENTS:
            assert getattr(together, name)[k].tobytes() == getattr(one.at(speed), name).tobytes()
