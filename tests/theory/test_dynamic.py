"""The dynamic model in numbers: flat maps there and back, slip terms on the exact plant, wheel torques."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from slipctl.theory.dynamic import Inertia, drift, invert_dynamics, slip_terms
from slipctl.theory.flatness import apply_decoupling, flat_to_state
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.robust import chain_gains, lyapunov_matrix
from slipctl.theory.robust_dynamic import largest_calm_dynamic_tick
from slipctl.theory.slip import SinusoidalSlip
from slipctl.tick import Array, Slip

values = st.floats(-2.0, 2.0)
speeds = st.floats(0.1, 2.0)
headings = st.floats(-math.pi, math.pi)
PAPER = Inertia(MAGELLAN_PRO, mass=18.2, yaw_inertia=0.39375)


def one(number: float) -> Array:
    return np.array([float(number)])


def lift(*numbers: float) -> Any:
    return tuple(np.array([float(number)]) for number in numbers)


@given(speeds, values, values, headings, values, values)
def test_state_of_the_flat_output_comes_back(v, w, mu1, angle, jerk, spin):
    """(v, θ, μ₁, w, μ̄₁, μ̄₂) to Ḟ, F̈, F⃛ by (22)–(25), and back by (9), (10) and the corrected (27)."""
    cosine, sine = lift(math.cos(angle), math.sin(angle))
    velocity = np.stack([v * cosine, v * sine], axis=-1)
    second = apply_decoupling(one(v), cosine, sine, one(mu1), one(w))
    a = drift(one(v), one(w), one(mu1), cosine, sine)
    third = a + apply_decoupling(one(v), cosine, sine, one(jerk), one(spin))
    back_v, back_angle, back_mu1, back_w = flat_to_state(velocity, second)
    scale = 1e-13 * (1.0 + np.abs(third).max()) / min(v, 1.0) ** 2
    assert back_v[0] == pytest.approx(v, abs=scale)
    assert math.remainder(back_angle[0] - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=scale)
    assert back_mu1[0] == pytest.approx(mu1, abs=scale)
    assert back_w[0] == pytest.approx(w, abs=scale)
    there: tuple[Array, Array] = (np.cos(back_angle), np.sin(back_angle))
    back = invert_dynamics(back_v, *there, third, drift(back_v, back_w, back_mu1, *there))
    assert back[0][0] == pytest.approx(jerk, abs=100.0 * scale)
    assert back[1][0] == pytest.approx(spin, abs=100.0 * scale / v)


def test_drift_on_a_circle_is_the_jerk_of_a_circle():
    """F = R (cos φ, sin φ) with φ̇ = w has F⃛ = R w³ (sin φ, −cos φ) and needs no input."""
    radius, w, phi = 1.5, -0.7, 0.4
    v, heading = radius * abs(w), phi - math.pi / 2.0  # clockwise
    a = drift(one(v), one(w), one(0.0), one(math.cos(heading)), one(math.sin(heading)))
    np.testing.assert_allclose(
        a, [[radius * w**3 * math.sin(phi), -radius * w**3 * math.cos(phi)]], rtol=1e-13
    )


def test_drift_of_a_robot_that_speeds_up_in_a_bend_points_into_the_bend():
    """2wμ₁ to the left: Coriolis."""
    np.testing.assert_allclose(
        drift(one(0.5), one(0.4), one(0.3), one(1.0), one(0.0)), [[-0.5 * 0.16, 2.0 * 0.4 * 0.3]]
    )


# slip terms against the third derivative of positions

AMPLITUDES, PERIOD = (0.3, -0.25, 0.6), 1.7


def exact_plant(mu1, mu1_rate, spin):
    """Integrate (31) with sinusoidal slip, written out with complex numbers.

    States F, θ, v, w; v̇_t = f ′v + f v̇ with f the swinging fraction, so (31d) gives v̇.
    """
    a_t, a_s, a_w = AMPLITUDES
    frequency = 2.0 * math.pi / PERIOD

    def rhs(t, state):
        _, _, angle, v, w = state
        swing, swing_rate = math.sin(frequency * t), frequency * math.cos(frequency * t)
        turn = w + a_w * swing * v
        v_rate = (mu1 + mu1_rate * t - a_t * swing_rate * v - a_s * swing * v * turn) / (1.0 + a_t * swing)
        ws_rate = a_w * (swing_rate * v + swing * v_rate)
        velocity = ((1.0 + a_t * swing) - 1j * a_s * swing) * v * np.exp(1j * angle)
        return [velocity.real, velocity.imag, turn, v_rate, spin - ws_rate]

    return rhs


@pytest.mark.parametrize("seed", range(4))
def test_slip_terms_are_what_finite_differences_of_the_acceleration_see(seed):
    """F⃛ − A − B μ̄ on the exact plant, F⃛ as a difference of F̈ = d/dt Ḟ; the printed C misses by far more."""
    rng = np.random.default_rng(seed)
    mu1, mu1_rate, spin = rng.uniform(-0.6, 0.6, 3)
    at = rng.uniform(0.3, 0.6)
    rhs = exact_plant(mu1, mu1_rate, spin)
    start = [0.0, 0.0, rng.uniform(-3.0, 3.0), rng.uniform(0.4, 0.8), rng.uniform(-0.8, 0.8)]
    run = solve_ivp(rhs, (0.0, 1.0), start, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
    step = 2e-3
    states = {k: run.sol(at + k * step) for k in (-3, -2, -1, 0, 1, 2, 3)}
    velocity = {k: np.array(rhs(at + k * step, state)[:2]) for k, state in states.items()}
    weights = {-3: 1 / 90, -2: -3 / 20, -1: 3 / 2, 0: -49 / 18, 1: 3 / 2, 2: -3 / 20, 3: 1 / 90}
    third = sum(weight * velocity[k] for k, weight in weights.items()) / step**2

    _, _, angle, v, w = states[0]
    push = mu1 + mu1_rate * at
    facing: tuple[Array, Array] = lift(math.cos(angle), math.sin(angle))
    law = SinusoidalSlip(*lift(*AMPLITUDES), period=np.array([PERIOD]))
    slips = {k: law.affine(at + k * step).at(np.array([state[3]])) for k, state in states.items()}
    lateral = {k: slip.lateral[0] for k, slip in slips.items()}
    rate_weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    rate = sum(u * (lateral[k] - lateral[-k]) for k, u in rate_weights.items()) / step
    acceleration = sum(weight * lateral[k] for k, weight in weights.items()) / step**2
    yaw_rate_of_slip = sum(u * (slips[k].yaw[0] - slips[-k].yaw[0]) for k, u in rate_weights.items()) / step

    expected = (
        third
        - (
            drift(one(v), one(w), one(push), *facing)
            + apply_decoupling(one(v), *facing, one(mu1_rate), one(spin))
        )[0]
    )
    c_matrix, d_matrix = slip_terms(
        one(v), one(w), one(push), slips[0], one(rate), one(acceleration), *facing
    )
    got = c_matrix[0] + d_matrix[0] @ [mu1_rate, spin]
    np.testing.assert_allclose(got, expected, rtol=0, atol=2e-7)

    wrong = printed_c(v, w, slips[0], (rate, acceleration, yaw_rate_of_slip), angle)
    assert np.hypot(*(wrong + d_matrix[0] @ [mu1_rate, spin] - expected)) > 1e-2


def printed_c(v, w, slip, rates, angle):
    """C as printed below (61), which takes θ̇ for w."""
    v_t, v_s = slip.longitudinal[0], slip.lateral[0]
    lateral_rate, lateral_acceleration, yaw_rate = rates
    along = lateral_rate * w - v_t * w**2
    across = -(v_s * w**2 + (v + v_t) * yaw_rate + lateral_acceleration)
    c, s = math.cos(angle), math.sin(angle)
    return np.array([along * c - across * s, along * s + across * c])


def test_slip_terms_vanish_without_slip():
    zero = np.zeros(3)
    heading = np.array([0.3, 2.0, -2.5])
    c_matrix, d_matrix = slip_terms(
        np.array([0.1, 1.0, -2.0]),
        np.array([0.5, -1.0, 2.0]),
        np.array([0.2, 0.3, -0.4]),
        Slip(zero, zero, zero),
        zero,
        zero,
        np.cos(heading),
        np.sin(heading),
    )
    assert not c_matrix.any()
    assert not d_matrix.any()


def test_norm_of_e_is_the_longitudinal_slip_ratio():
    """(75): ‖D B⁻¹‖ = |v_t|/|v|; lateral slip plays no part, unlike in (50)."""
    v, angle = 0.5, 1.1
    c, s = math.cos(angle), math.sin(angle)
    slip = Slip(one(-0.15), one(0.3), one(0.2))
    d_matrix = slip_terms(one(v), one(0.2), one(0.1), slip, one(0.3), one(-0.4), one(c), one(s))[1][0]
    inverse = np.linalg.inv([[c, -v * s], [s, v * c]])
    assert np.linalg.norm(d_matrix @ inverse, 2) == pytest.approx(0.15 / 0.5, rel=1e-12)


def test_a_history_is_as_good_as_an_instant():
    """Arrays (N, T) give what every column gives alone."""
    rng = np.random.default_rng(4)
    v, w, mu1, rate, second, angle, *slips = rng.uniform(-1.0, 1.0, (9, 2, 3))
    cosine, sine = np.cos(angle), np.sin(angle)

    def everything(at: Any) -> tuple[Array, ...]:
        slip = Slip(*(array[at] for array in slips))
        known = v[at], w[at], mu1[at]
        return (
            drift(*known, cosine[at], sine[at]),
            *slip_terms(*known, slip, rate[at], second[at], cosine[at], sine[at]),
            PAPER.torques(mu1[at], rate[at], np.stack([v[at], w[at]], axis=-1)),
            MAGELLAN_PRO.wheel_rates(v[at], w[at]),
        )

    for k in range(3):
        for all_of_it, one_of_it in zip(everything(...), everything(np.s_[:, k]), strict=True):
            np.testing.assert_array_equal(all_of_it[:, k], one_of_it)


# wheel torques

bodies = st.builds(
    Inertia,
    st.just(MAGELLAN_PRO),
    st.floats(1.0, 50.0),
    st.floats(0.05, 5.0),
    st.floats(0.0, 0.1),
    st.floats(0.0, 0.5),
)
pairs = st.tuples(st.floats(-20.0, 20.0), st.floats(-20.0, 20.0))


@given(bodies, values, values, pairs)
def test_accelerations_of_torques_are_the_accelerations(body, push, spin, rate):
    rates = np.array([rate])
    got = body.accelerations(body.torques(one(push), one(spin), rates), rates)
    assert got[0][0] == pytest.approx(push, abs=1e-12)
    assert got[1][0] == pytest.approx(spin, abs=1e-10)


@given(bodies, pairs, pairs)
def test_torques_of_accelerations_are_the_torques(body, torque, rate):
    rates = np.array([rate])
    got = body.torques(*body.accelerations(np.array([torque]), rates), rates)
    np.testing.assert_allclose(got, [torque], rtol=0, atol=1e-12)


def test_torques_by_hand():
    """τ = (r/2)(m μ₁ ± I_z μ₂/b): 0.3 m/s² takes 0.04125·5.46 N·m per wheel, 0.2 rad/s² ∓0.04125·0.4849."""
    straight = PAPER.torques(one(0.3), one(0.0), np.zeros((1, 2)))
    np.testing.assert_allclose(straight, [[0.225225, 0.225225]], rtol=1e-12)
    turning = PAPER.torques(one(0.0), one(0.2), np.zeros((1, 2)))
    each = 0.04125 * 0.39375 * 0.2 / 0.1624
    np.testing.assert_allclose(turning, [[-each, each]], rtol=1e-12)  # the right wheel pushes: to the left


def test_wheel_inertia_counts_twice_at_the_rim():
    """Power balance: a wheel that rolls at v/r carries J v²/(2r²), and b w/r on the spot."""
    body = Inertia(MAGELLAN_PRO, 18.2, 0.39375, wheel_inertia=0.02)
    v, w, r, b = 0.7, 1.3, 0.0825, 0.1624
    rolling = 18.2 * v**2 / 2.0 + 2.0 * 0.02 * (v / r) ** 2 / 2.0
    turning = 0.39375 * w**2 / 2.0 + 2.0 * 0.02 * (b * w / r) ** 2 / 2.0
    assert body.effective_mass * v**2 / 2.0 == pytest.approx(rolling, rel=1e-14)
    assert body.effective_yaw_inertia * w**2 / 2.0 == pytest.approx(turning, rel=1e-14)
    assert (PAPER.effective_mass, PAPER.effective_yaw_inertia) == (18.2, 0.39375)


@pytest.mark.parametrize("rates", [(2.0, 2.0), (-2.0, 2.0), (3.0, -1e-9), (0.0, 5.0), (5.0, 0.0)])
def test_joint_friction_is_added_against_the_rotation_of_each_wheel(rates):
    rubbing = Inertia(MAGELLAN_PRO, 18.2, 0.39375, joint_friction=0.07)
    extra = rubbing.torques(one(0.3), one(0.2), np.array([rates])) - PAPER.torques(
        one(0.3), one(0.2), np.array([rates])
    )
    np.testing.assert_allclose(extra, [[0.07 * np.sign(rate) for rate in rates]], rtol=0, atol=1e-15)


def test_every_world_has_the_joint_friction_of_its_own():
    """As many worlds as wheels, and more."""
    for friction in (np.array([0.1, 0.2]), np.array([0.1, 0.0, 0.3])):
        worlds = len(friction)
        push, spin, rates = np.full(worlds, 0.3), np.full(worlds, 0.2), np.tile([4.0, -2.0], (worlds, 1))
        body = Inertia(MAGELLAN_PRO, 18.2, 0.39375, joint_friction=friction)
        torques = body.torques(push, spin, rates)
        extra = torques - PAPER.torques(push, spin, rates)
        np.testing.assert_allclose(extra, np.stack([friction, -friction], -1), rtol=0, atol=1e-15)
        back = body.accelerations(torques, rates)
        np.testing.assert_allclose(back, [push, spin], rtol=0, atol=1e-13)


def test_friction_alone_slows_a_rolling_robot():
    rubbing = Inertia(MAGELLAN_PRO, 18.2, 0.39375, joint_friction=0.07)
    push, spin = rubbing.accelerations(np.zeros((1, 2)), np.array([[5.0, 5.0]]))
    assert push[0] == pytest.approx(-2.0 * 0.07 / (0.0825 * 18.2), rel=1e-13)
    assert spin[0] == 0.0


@pytest.mark.parametrize("rates", [(0.0, 5.0), (-5.0, 0.0), (0.0, 0.0)])
def test_an_axle_that_stands_does_not_rub(rates):
    rubbing, torque = Inertia(MAGELLAN_PRO, 18.2, 0.39375, joint_friction=0.07), np.array([0.4, 0.9])
    got = rubbing.accelerations(torque[None], np.array([rates]))
    driving = (torque - 0.07 * np.sign(np.array(rates)))[None]
    np.testing.assert_allclose(got, PAPER.accelerations(driving, np.array([rates])), rtol=1e-14)


@pytest.mark.parametrize("slip", [0.0, 0.4 - 0.4j, -0.3 + 0.1j, -0.4 - 0.4j, -0.3])
def test_calm_tick_of_the_dynamic_law_is_that_of_its_fastest_direction(slip):
    """A tick scales ë by 1 − h λ P₃₃ρ/ε with λ = 1 along the heading and |1+σ|²/Re(1+σ) across it."""
    layer, rho, corner = 0.02, 0.35, 6.875
    ticks = largest_calm_dynamic_tick(one(layer), one(rho), one(corner), np.array([slip + 0.0j]))
    assert ticks.dtype == float
    tick = ticks[0]
    rates = np.array([1.0, abs(1.0 + slip) ** 2 / (1.0 + slip.real)]) * corner * rho / layer
    for share in (0.9, 1.0, 1.1):
        factor = np.abs(1.0 - share * tick * rates).max()
        assert np.sign(round(factor - 1.0, 12)) == np.sign(round(share - 1.0, 12))


def test_gains_and_lyapunov_matrix_of_section_five_b():
    gains = chain_gains(np.array([-0.5]), 3)
    np.testing.assert_array_equal(gains, [[0.125, 0.75, 1.5]])
    matrix = lyapunov_matrix(gains[0])
    expected = [[4.2265625, 6.859375, 4.0], [6.859375, 15.875, 9.8125], [4.0, 9.8125, 6.875]]
    np.testing.assert_allclose(matrix, expected, rtol=0, atol=1e-13)
    # (74), all six rows of it: JᵀPe = 4 e₁ + 9.8125 e₂ + 6.875 e₃
    whole = np.kron(matrix, np.eye(2))
    j = np.kron([[0.0], [0.0], [1.0]], np.eye(2))
    closed_loop = np.kron(np.eye(3, k=1), np.eye(2)) - j @ np.kron(gains, np.eye(2))
    np.testing.assert_allclose(closed_loop.T @ whole + whole @ closed_loop, -np.eye(6), rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.linalg.eigvals(closed_loop).real, -0.5, atol=1e-4)
