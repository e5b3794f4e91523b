"""Ultimate bounds: closed forms, brute force, and what the theorem promises of a simulated error."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from slipctl.theory import ultimate
from slipctl.theory.robust import chain_gains, lyapunov_matrix

POLES = [-0.3, -0.5, -1.0, -2.0]


def one_axis(pole: float, order: int) -> tuple[np.ndarray, np.ndarray]:
    gains = chain_gains(np.array([pole]), order)[0]
    return gains, lyapunov_matrix(gains)


def test_lyapunov_matrices_of_the_papers_poles():
    assert one_axis(-0.5, 2)[1] == pytest.approx(np.array([[2.625, 2.0], [2.0, 2.5]]), rel=1e-12)
    expected = [[4.2265625, 6.859375, 4.0], [6.859375, 15.875, 9.8125], [4.0, 9.8125, 6.875]]
    assert one_axis(-0.5, 3)[1] == pytest.approx(np.array(expected), rel=1e-12)


def test_bounds_of_the_papers_law():
    """59.7, 25.0 and 10 mm at ε = 0.02 and ρ = 0.08."""
    gains, weights = one_axis(-0.5, 2)
    layer, gain = 0.02, 0.08
    corrected = ultimate.position_bound(weights, ultimate.level_set(weights, layer, gain))
    tight = ultimate.position_bound(weights, ultimate.tight_level_set(weights, layer, gain))
    assert 1e3 * corrected == pytest.approx(59.7, abs=0.05)
    assert 1e3 * tight == pytest.approx(25.0, abs=0.05)
    # the eigenvalues of a symmetric 2×2 matrix by hand
    largest = (2.625 + 2.5) / 2.0 + math.hypot((2.625 - 2.5) / 2.0, 2.0)
    inverse = 2.5 / (2.625 * 2.5 - 2.0**2)
    assert corrected == pytest.approx(math.sqrt(largest * layer * gain / 2.0 * inverse), rel=1e-12)
    assert ultimate.small_gain(gains, weights) == pytest.approx(0.5625, rel=1e-9)
    assert 1e3 * layer / weights[0, 1] == pytest.approx(10.0)
    assert ultimate.time_constant(weights) == pytest.approx(1.25)
    assert ultimate.time_constant(one_axis(-0.5, 3)[1]) == pytest.approx(1.4013, abs=1e-4)


@pytest.mark.parametrize("order", [2, 3])
def test_level_that_cannot_be_left_is_that_of_the_longest_axis(order):
    """λ_max of a positive definite matrix is its spectral norm."""
    _, weights = one_axis(-0.5, order)
    expected = float(np.linalg.norm(weights, 2)) * 0.02 * 0.08 / 2.0
    assert ultimate.level_set(weights, 0.02, 0.08) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("pole", POLES)
@pytest.mark.parametrize(("layer", "gain"), [(0.02, 0.08), (0.1, 1.0), (0.005, 2.0)])
def test_tight_level_is_the_largest_where_the_function_may_grow(order, pole, layer, gain):
    """Directions by chance, lengths exactly to the edge: along a ray eᵀe and ‖w‖ are powers of its length."""
    _, weights = one_axis(pole, order)
    level = ultimate.tight_level_set(weights, layer, gain)
    assert level <= ultimate.level_set(weights, layer, gain) * (1.0 + 1e-9)
    ray = np.random.default_rng(3).normal(size=(100_000, order))
    # half of the rays near the surface w = 0, where the long ones are
    ray[::2] -= np.outer(ray[::2] @ weights[-1], weights[-1]) / (weights[-1] @ weights[-1]) * 0.98
    across = np.abs(ray @ weights[-1])
    # s²|ray|² ≤ 2ρ(s across − s² across²/ε)
    longest = 2.0 * gain * across / (np.sum(ray**2, axis=1) + 2.0 * gain * across**2 / layer)
    values = longest**2 * np.einsum("ni,ij,nj->n", ray, weights, ray)
    assert values.max() <= level * (1.0 + 1e-9)
    assert values.max() > 0.97 * level


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("pole", [-0.5, -2.0])
@pytest.mark.parametrize(("layer", "gain"), [(0.02, 0.08), (0.1, 1.0)])
def test_tight_level_is_the_maximum_found_by_a_search(order, pole, layer, gain):
    """Over ‖w‖ and the direction across the row, which is a sign or an angle; no multiplier, no dual."""
    _, weights = one_axis(pole, order)
    row = weights[-1]
    frame = np.linalg.qr(np.column_stack([row, np.eye(order)[:, : order - 1]]))[0]

    def level(length: np.ndarray, angle: np.ndarray) -> np.ndarray:
        square = 2.0 * gain * (length - length**2 / layer) - length**2 / (row @ row)
        radius = np.sqrt(np.maximum(square, 0.0))
        parts = [length / np.linalg.norm(row) * np.sign(frame[:, 0] @ row), radius * np.cos(angle)]
        parts = np.broadcast_arrays(*parts, radius * np.sin(angle))[:order]
        error = np.stack(parts, axis=-1) @ frame.T
        return np.where(square > 0.0, np.einsum("...i,ij,...j->...", error, weights, error), 0.0)

    centre, width = np.array([layer / 2.0, math.pi]), np.array([layer / 2.0, math.pi])
    steps, largest = np.linspace(-1.0, 1.0, 61), 0.0
    for _ in range(12):
        lengths, angles = centre[0] + width[0] * steps[:, None], centre[1] + width[1] * steps[None, :]
        values = level(lengths, angles)
        best = np.unravel_index(np.argmax(values), values.shape)
        largest = float(values[best])
        centre, width = np.array([lengths[best[0], 0], angles[0, best[1]]]), width / 8.0
    assert ultimate.tight_level_set(weights, layer, gain) == pytest.approx(largest, rel=1e-7)


@pytest.mark.parametrize("order", [2, 3])
@pytest.mark.parametrize("scale", [1e-4, 1e4])
def test_tight_level_is_homogeneous(order, scale):
    """Errors, ε and ρ in another unit of length: V goes with its square."""
    _, weights = one_axis(-0.5, order)
    level = ultimate.tight_level_set(weights, 0.02, 0.08)
    scaled = ultimate.tight_level_set(weights, scale * 0.02, scale * 0.08)
    assert scaled == pytest.approx(scale**2 * level, rel=1e-9)


def test_nothing_is_left_without_a_layer_or_an_uncertainty():
    _, weights = one_axis(-0.5, 2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for layer, gain in ((0.0, 1.0), (0.02, 0.0), (0.0, 0.0)):
            assert ultimate.tight_level_set(weights, layer, gain) == 0.0
            assert ultimate.level_set(weights, layer, gain) == 0.0


def test_small_gain_is_for_the_kinematic_law_only():
    assert ultimate.small_gain(*one_axis(-0.5, 3)) == math.inf
    for pole in (-0.1, -0.5, -1.0, -2.0, -5.0):
        # derived for Q = I: below 1 between the poles −(1 + √2) and −1/(1 + √2)
        expected = ((pole - 1.0 / pole) / 2.0) ** 2
        assert ultimate.small_gain(*one_axis(pole, 2)) == pytest.approx(expected, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("corner", "last"), [(2.0, 1.0), (1.0, 1.0), (0.0, 1.0), (-0.5, 1.0)])
def test_small_gain_promises_nothing_without_damping_or_coupling(corner, last):
    """a = K₂ − P₁₂/P₂₂ and P₁₂ must be positive: matrices by hand, for Q = I they always are."""
    weights = np.array([[3.0, corner], [corner, last]])
    assert ultimate.small_gain(np.array([0.25, 1.0]), weights) == math.inf


def worst_case(
    pole: float, order: int, layer: float, gain: float, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate (44) with (59) from inside the level set; return V and |e₁| of many worlds over time.

    η has length ρ at all times: along w, against it, along e₁, or swinging. ρ varies below its supremum.
    """
    gains, weights = one_axis(pole, order)
    rng = np.random.default_rng(seed)
    worlds, step = 200, 2e-3
    error = rng.normal(size=(worlds, order, 2))
    size = np.einsum("nij,ik,nkj->n", error, weights, error)
    level = ultimate.tight_level_set(weights, layer, gain)
    error *= np.sqrt(level / size)[:, None, None]
    values, positions = [], []
    policy, rate = np.arange(worlds) % 4, rng.uniform(0.1, 3.0, worlds)

    def derivative(error: np.ndarray, time: float) -> np.ndarray:
        w = np.einsum("i,nij->nj", weights[-1], error)
        length = np.sqrt(np.sum(w * w, axis=1))[:, None]
        first = error[:, 0] / np.maximum(np.sqrt(np.sum(error[:, 0] ** 2, axis=1)), 1e-12)[:, None]
        swing = np.stack([np.cos(rate * time), np.sin(rate * time)], axis=1)
        along = w / np.maximum(length, 1e-12)
        eta = gain * np.choose(policy[:, None], [along, first, swing, -first])
        rho = gain * (0.75 + 0.25 * np.cos(0.7 * rate * time))[:, None]
        eta = np.minimum(1.0, rho / gain) * eta
        corrective = -rho * w / np.maximum(length, layer)
        last = -np.einsum("i,nij->nj", gains, error) + corrective + eta
        return np.concatenate([error[:, 1:], last[:, None]], axis=1)

    for k in range(round(25.0 / step)):
        time = k * step
        middle = error + step / 2.0 * derivative(error, time)
        error = error + step * derivative(middle, time + step / 2.0)
        if k % 5 == 0:
            values.append(np.einsum("nij,ik,nkj->n", error, weights, error) / level)
            positions.append(np.sqrt(np.sum(error[:, 0] ** 2, axis=1)))
    return np.array(values), np.array(positions)


@pytest.mark.parametrize(("pole", "order"), [(-0.5, 2), (-2.0, 2), (-0.5, 3)])
def test_no_admissible_uncertainty_beats_a_bound(pole, order):
    """The worst policy comes near enough that the bounds are not empty."""
    layer, gain = 0.05, 0.3
    gains, weights = one_axis(pole, order)
    values, positions = worst_case(pole, order, layer, gain, seed=order)
    assert values.max() <= 1.0 + 1e-6
    bound = ultimate.position_bound(weights, ultimate.tight_level_set(weights, layer, gain))
    assert positions.max() <= bound * (1.0 + 1e-6)
    settled = positions[len(positions) * 3 // 5 :]
    assert settled.max() > 0.02 * bound
    if order == 2:
        assert ultimate.small_gain(gains, weights) < 1.0
        assert settled.max() <= layer / weights[0, 1]
        assert settled.max() > 0.15 * layer / weights[0, 1]


@pytest.mark.parametrize("order", [2, 3])
def test_tight_levels_of_many_worlds_are_those_of_each_alone(order):
    rng = np.random.default_rng(order)
    _, weights = one_axis(-0.8, order)
    layers, gains = rng.uniform(0.001, 0.2, 30), rng.uniform(0.01, 4.0, 30)
    layers[3], gains[5] = 0.0, 0.0
    together = ultimate.tight_level_sets(weights, layers, gains)
    alone = [
        ultimate.tight_level_set(weights, layer, gain) for layer, gain in zip(layers, gains, strict=True)
    ]
    assert together.tolist() == alone
    assert together[3] == together[5] == 0.0
    assert np.count_nonzero(together) == 28
