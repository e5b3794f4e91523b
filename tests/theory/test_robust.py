import math
import warnings
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.theory.robust import (
    UNCERTAINTIES,
    chain_gains,
    corrective_input,
    independent_bound,
    largest_calm_tick,
    lyapunov_matrix,
    norm,
    paper_bound,
    slip_ratio_bound,
)

poles = st.floats(-20.0, -0.05)
orders = st.integers(1, 4)


@given(poles, orders)
def test_every_root_of_the_chain_is_the_pole(pole, order):
    gains = chain_gains(np.array([pole]), order)[0]
    polynomial = np.concatenate([[1.0], gains[::-1]])  # sⁿ + K_n sⁿ⁻¹ + … + K₁
    np.testing.assert_allclose(polynomial, np.poly([pole] * order), rtol=1e-12)


def test_gains_of_the_paper():
    assert chain_gains(np.array([-2]), 2).dtype == float
    np.testing.assert_array_equal(chain_gains(np.array([-0.5]), 2), [[0.25, 1.0]])
    np.testing.assert_array_equal(chain_gains(np.array([-0.5]), 3), [[0.125, 0.75, 1.5]])
    np.testing.assert_allclose(chain_gains(np.array([-2.0, -3.0]), 2), [[4.0, 4.0], [9.0, 6.0]], rtol=1e-15)


@given(poles, orders)
def test_lyapunov_matrix_solves_its_equation_and_is_positive_definite(pole, order):
    gains = chain_gains(np.array([pole]), order)[0]
    matrix = lyapunov_matrix(gains)
    closed_loop = np.diag(np.ones(order - 1), 1)
    closed_loop[-1] -= gains
    residual = closed_loop.T @ matrix + matrix @ closed_loop + np.eye(order)
    scale = np.abs(closed_loop).max() * np.abs(matrix).max()
    assert np.abs(residual).max() <= 1e-11 * scale
    np.testing.assert_array_equal(matrix, matrix.T)
    np.linalg.cholesky(matrix)


@given(st.floats(0.05, 50.0), st.floats(0.05, 50.0))
def test_lyapunov_matrix_of_two_integrators_in_closed_form(k1, k2):
    """By hand: P₁₂ = 1/(2K₁), P₂₂ = (1 + 2P₁₂)/(2K₂), P₁₁ = K₂P₁₂ + K₁P₂₂."""
    p12 = 1.0 / (2.0 * k1)
    p22 = (1.0 + 2.0 * p12) / (2.0 * k2)
    expected = np.array([[k2 * p12 + k1 * p22, p12], [p12, p22]])
    np.testing.assert_allclose(lyapunov_matrix(np.array([k1, k2])), expected, rtol=1e-9)


def test_lyapunov_matrices_of_the_paper():
    kinematic = lyapunov_matrix(chain_gains(np.array([-0.5]), 2)[0])
    np.testing.assert_allclose(kinematic, [[2.625, 2.0], [2.0, 2.5]], rtol=0, atol=1e-14)
    dynamic = lyapunov_matrix(chain_gains(np.array([-0.5]), 3)[0])
    expected = [[4.2265625, 6.859375, 4.0], [6.859375, 15.875, 9.8125], [4.0, 9.8125, 6.875]]
    np.testing.assert_allclose(dynamic, expected, rtol=0, atol=1e-13)


def test_one_axis_is_all_there_is_to_the_papers_matrix():
    """P ⊗ I₂ solves the 4 × 4 equation, and JᵀPe is the weights' combination of e₁ and e₂."""
    gains = np.array([0.25, 1.0])
    matrix = np.kron(lyapunov_matrix(gains), np.eye(2))
    h = np.kron(np.eye(2, k=1), np.eye(2))
    j = np.kron([[0.0], [1.0]], np.eye(2))
    closed_loop = h - j @ np.kron(gains, np.eye(2))
    np.testing.assert_allclose(closed_loop.T @ matrix + matrix @ closed_loop, -np.eye(4), rtol=0, atol=1e-14)
    error = np.array([0.3, -0.1, 0.7, 0.2])
    np.testing.assert_allclose(j.T @ matrix @ error, 2.0 * error[:2] + 2.5 * error[2:], rtol=1e-14)


components = st.floats(-10.0, 10.0)
gain_values = st.floats(0.0, 5.0)
layers = st.floats(1e-4, 1.0)


def corrective(w, rho, layer):
    return corrective_input(np.array([w]), np.array([rho]), np.array([layer]))[0]


@given(components, components, gain_values, layers)
def test_corrective_input_is_never_longer_than_its_gain(w1, w2, rho, layer):
    assert math.hypot(*corrective((w1, w2), rho, layer)) <= rho * (1.0 + 1e-14)
    assert math.hypot(*corrective((w1, w2), rho, 0.0)) <= rho * (1.0 + 1e-14)


@given(st.floats(0.0, 2.0 * math.pi), st.floats(1.0, 50.0), gain_values, layers)
def test_corrective_input_outside_the_layer_is_the_discontinuous_law(direction, times, rho, layer):
    w = times * layer * np.array([math.cos(direction), math.sin(direction)])
    expected = -rho * w / math.hypot(*w)
    np.testing.assert_allclose(corrective(w, rho, layer), expected, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(corrective(w, rho, 0.0), expected, rtol=1e-12, atol=1e-14)


@given(st.floats(0.0, 2.0 * math.pi), st.floats(0.0, 1.0), gain_values, layers)
def test_corrective_input_inside_the_layer_is_linear(direction, share, rho, layer):
    w = share * layer * np.array([math.cos(direction), math.sin(direction)])
    np.testing.assert_allclose(corrective(w, rho, layer), -rho * w / layer, rtol=1e-12, atol=1e-14)


def test_corrective_input_is_continuous_at_the_edge_of_the_layer():
    layer, rho = 0.02, 0.8
    inside, outside = (corrective((layer * (1.0 + side), 0.0), rho, layer) for side in (-1e-9, 1e-9))
    assert abs(inside[0] - outside[0]) < 1e-8
    assert inside[0] == pytest.approx(-rho)


def test_corrective_input_vanishes_at_zero_in_both_laws():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        answer = corrective_input(np.zeros((2, 2)), np.ones(2), np.array([0.0, 0.02]))
    np.testing.assert_array_equal(answer, np.zeros((2, 2)))


def test_a_world_without_an_error_changes_nothing_beside_it():
    """One without layer and error has nothing to be divided by; its neighbours are as if they were alone."""
    weighted, rho = np.array([[0.3, 0.4], [0.0, 0.0], [0.03, -0.04]]), np.array([1.0, 2.0, 0.5])
    answer = corrective_input(weighted, rho, np.array([0.0, 0.0, 0.2]))
    np.testing.assert_allclose(answer, [[-0.6, -0.8], [0.0, 0.0], [-0.075, 0.1]], rtol=1e-15)
    for world in (0, 2):
        row = slice(world, world + 1)
        alone = corrective_input(weighted[row], rho[row], np.array([0.0, 0.0, 0.2])[row])
        assert alone.tobytes() == answer[row].tobytes()


def test_discontinuous_law_in_a_direction_and_its_opposite():
    np.testing.assert_allclose(corrective((3e-9, 4e-9), 2.0, 0.0), [-1.2, -1.6], rtol=1e-15)
    np.testing.assert_allclose(corrective((-3e-9, -4e-9), 2.0, 0.0), [1.2, 1.6], rtol=1e-15)


def test_a_bound_takes_slip_bounds_of_any_shape_and_precision():
    slip_bound = np.array([[0.25, 0.375], [0.125, 0.0]])
    known = np.full((2, 2), 0.1), np.full((2, 2), 0.05), np.full((2, 2), -0.03)
    for bound in (paper_bound, independent_bound, slip_ratio_bound):
        answer = bound(slip_bound, *known)
        short: Any = slip_bound.astype(np.float32)  # as exact: powers of two
        assert bound(short, *known).tolist() == answer.tolist()
        for at in np.ndindex(2, 2):
            alone = bound(slip_bound[at][None], *(array[at][None] for array in known))
            assert alone[0] == answer[at]


def test_closed_forms_of_the_uncertainty_bounds():
    """α = 0.4, v = 0.1, ‖v̂‖ = 0.05, t·v̂ = −0.03, by hand.

    paper: Φ = 0.4·0.1·0.04 + 0.8·0.03 + 1.4·0.1·0.04 = 0.0312, ρ = (0.8·0.05 + 0.0312)/0.2 = 0.356.
    The others: Φ₀ = 0.004 √(0.16 + 1.96), with q = 0.8 and 0.4 √2.
    """
    at = tuple(np.array([value]) for value in (0.4, 0.1, 0.05, -0.03))
    phi = 0.004 * math.sqrt(2.12)
    assert paper_bound(*at)[0] == pytest.approx(0.356, rel=1e-13)
    assert independent_bound(*at)[0] == pytest.approx((0.04 + phi) / 0.2, rel=1e-13)
    q = 0.4 * math.sqrt(2.0)
    assert slip_ratio_bound(*at)[0] == pytest.approx((q * 0.05 + phi) / (1.0 - q), rel=1e-13)


@given(st.floats(0.0, 0.49), st.floats(-3.0, 3.0), st.floats(0.0, 10.0), st.floats(-1.0, 1.0))
def test_gain_is_the_fixed_point_of_its_own_definition(alpha, v, nominal, share):
    """(56) and (57): ρ = q (‖v̂‖ + ρ) + Φ, with Φ written out here once more."""
    forward = share * nominal
    at = tuple(np.array([value]) for value in (alpha, v, nominal, forward))
    zeta = alpha * abs(v)  # bound on |w_s|
    turning = math.hypot(zeta * alpha * abs(v), zeta * (1.0 + alpha) * abs(v))
    paper_phi = alpha * abs(v) * zeta + 2.0 * alpha * abs(forward) + (1.0 + alpha) * abs(v) * zeta
    for bound, q, phi in (
        (paper_bound, 2.0 * alpha, paper_phi),
        (independent_bound, math.sqrt(4.0 * alpha**2), turning),
        (slip_ratio_bound, math.sqrt(2.0) * alpha, turning),
    ):
        rho = bound(*at)[0]
        assert rho == pytest.approx(q * (nominal + rho) + phi, rel=1e-9, abs=1e-12)
        assert bound(at[0], -at[1], *at[2:])[0] == rho


def test_largest_slip_bound_is_where_a_bound_loses_its_sign():
    """At its largest slip bound a gain has lost its meaning; just below it is still positive."""
    for uncertainty in UNCERTAINTIES.values():
        below = np.array([uncertainty.largest_slip_bound - 1e-6])
        beyond = np.array([uncertainty.largest_slip_bound + 1e-6])
        rest = (np.array([0.1]), np.array([0.05]), np.array([0.03]))
        assert uncertainty.bound(below, *rest)[0] > 1e3
        assert uncertainty.bound(beyond, *rest)[0] < -1e3


@pytest.mark.parametrize("slip", [0.0, 0.4 - 0.4j, -0.3 + 0.1j, -0.4 - 0.4j])
def test_calm_tick_is_the_stability_limit_of_the_sampled_layer(slip):
    """Inside the layer, a tick scales e₂ by 1 − h (1+σ) P₂₂ρ/ε, of modulus one at the largest calm tick."""
    layer, rho, corner = 0.02, 0.35, 2.5
    tick = largest_calm_tick(np.array([layer]), np.array([rho]), np.array([corner]), np.array([slip]))[0]
    for share in (0.9, 1.0, 1.1):
        factor = abs(1.0 - share * tick * (1.0 + slip) * corner * rho / layer)
        assert np.sign(round(factor - 1.0, 12)) == np.sign(round(share - 1.0, 12))


def test_calm_tick_without_gain_is_infinite():
    assert (
        largest_calm_tick(np.array([0.02]), np.zeros(1), np.array([2.5]), np.zeros(1, dtype=complex))[0]
        == np.inf
    )


def test_calm_tick_says_nothing_on_the_way_to_infinity():
    """Without a layer and without a gain it is 0/0; neither division warns."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ticks = largest_calm_tick(
            np.array([0.02, 0.0]), np.zeros(2), np.full(2, 2.5), np.zeros(2, dtype=complex)
        )
    assert ticks[0] == np.inf


def test_norm():
    np.testing.assert_array_equal(norm(np.array([[3.0, 4.0], [-5.0, 12.0]])), [5.0, 13.0])
