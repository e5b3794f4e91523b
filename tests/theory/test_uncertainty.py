"""Monte Carlo against the exact plant: is ‖η‖ ≤ ρ, and how much slack is there?"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from slipctl.theory.robust import UNCERTAINTIES, independent_bound, paper_bound, slip_ratio_bound
from slipctl.tick import Array

Complex = Any  # arrays; numpy's stubs do not follow which operations are complex

SAMPLES = 100_000


@dataclass(frozen=True)
class States:
    """What a law knows; the heading is 0, so that complex numbers are (forward, left)."""

    alpha: Array
    v: Array
    nominal: Complex  # v̂

    @property
    def known(self) -> Any:
        """The arguments of an uncertainty bound."""
        return self.alpha, self.v, np.abs(self.nominal), self.nominal.real

    def bounded_by(self, name: str) -> Array:
        return UNCERTAINTIES[name].bound(*self.known)


def states(rng: np.random.Generator, alphas: tuple[float, float]) -> States:
    """Return speeds and nominal inputs over several decades, a third of them in the axes and diagonals."""
    direction = rng.uniform(-math.pi, math.pi, SAMPLES)
    direction[::3] = rng.integers(0, 8, len(direction[::3])) * math.pi / 4.0
    return States(
        alpha=rng.uniform(*alphas, SAMPLES),
        v=10.0 ** rng.uniform(-3.0, 0.5, SAMPLES),
        nominal=10.0 ** rng.uniform(-3.0, 1.0, SAMPLES) * np.exp(1j * direction),
    )


def corrective(rng: np.random.Generator, nominal: Complex, rho: Array) -> Complex:
    """Return admissible Δv, ‖Δv‖ ≤ ρ: anything, or all of it along v̂ or along a diagonal."""
    anything = (
        rho * np.sqrt(rng.uniform(0.0, 1.0, SAMPLES)) * np.exp(2j * math.pi * rng.uniform(size=SAMPLES))
    )
    along = rho * np.exp(1j * np.angle(nominal))
    diagonal = rho * np.exp(1j * (math.pi / 4.0) * (1.0 + 2.0 * rng.integers(0, 4, SAMPLES)))
    return np.choose(rng.integers(0, 3, SAMPLES), [anything, along, diagonal])


def uncertainty(v: Array, flat_input: Complex, slip: Complex, slip_rate: Complex, yaw_slip: Array) -> Complex:
    """Return η = F̈ − v_cmd of the plant (29) exactly, as forward + i left.

    With s = v_t − i v_s the velocity is (v + s) E, so F̈ = (ū₁ + ṡ + i (ū₂ + w_s) (v + s)) E.
    """
    u1, u2 = flat_input.real, flat_input.imag / v
    return u1 + slip_rate + 1j * (u2 + yaw_slip) * (v + slip) - flat_input


def signs(rng: np.random.Generator) -> Array:
    return rng.choice([-1.0, 1.0], SAMPLES)


def partly(rng: np.random.Generator) -> Array:
    """Return factors in [−1, 1], half of them at an end."""
    return np.where(rng.uniform(size=SAMPLES) < 0.5, signs(rng), rng.uniform(-1.0, 1.0, SAMPLES))


def independent_ratio(rng: np.random.Generator, law: str, alphas: tuple[float, float]) -> Array:
    """Return ‖η‖/ρ where every slip component and rate takes any value within its own bound."""
    at = states(rng, alphas)
    rho = at.bounded_by(law)
    flat_input = at.nominal + corrective(rng, at.nominal, rho)
    limit, rate_limit = at.alpha * at.v, at.alpha * np.abs(flat_input.real)
    slip = limit * (partly(rng) - 1j * partly(rng))
    slip_rate = rate_limit * (partly(rng) - 1j * partly(rng))
    return np.abs(uncertainty(at.v, flat_input, slip, slip_rate, limit * partly(rng))) / rho


def constant_ratio(rng: np.random.Generator, law: str, alphas: tuple[float, float]) -> Array:
    """Return ‖η‖/ρ where v_t and v_s are constant fractions of v, at most α, so that ṡ = σū₁."""
    at = states(rng, alphas)
    rho = at.bounded_by(law)
    flat_input = at.nominal + corrective(rng, at.nominal, rho)
    sigma = at.alpha * (partly(rng) - 1j * partly(rng))
    yaw_slip = at.alpha * at.v * partly(rng)
    return np.abs(uncertainty(at.v, flat_input, sigma * at.v, sigma * flat_input.real, yaw_slip)) / rho


def paper_ratio(rng: np.random.Generator, law: str, alphas: tuple[float, float]) -> Array:
    """Return ‖η‖/ρ for the slip that the paper simulates: v_t = v_s = w_s = αv, (83) and (84)."""
    at = states(rng, alphas)
    rho = at.bounded_by(law)
    flat_input = at.nominal + corrective(rng, at.nominal, rho)
    sigma = at.alpha * (1.0 - 1.0j)
    return np.abs(uncertainty(at.v, flat_input, sigma * at.v, sigma * flat_input.real, at.alpha * at.v)) / rho


ANY = (0.01, 0.49)


@pytest.mark.parametrize(
    ("law", "sample", "alphas", "least"),
    [
        ("independent", independent_ratio, ANY, 0.999),
        ("independent", constant_ratio, ANY, 0.97),
        ("independent", paper_ratio, ANY, 0.97),
        ("slip_ratio", constant_ratio, (0.01, 0.7), 0.999),
        ("slip_ratio", paper_ratio, (0.01, 0.7), 0.999),
        ("paper", independent_ratio, ANY, 0.97),
        ("paper", paper_ratio, ANY, 0.97),
        # at the slip bound of Section V-A
        ("independent", independent_ratio, (0.4, 0.4), 0.999),
        ("slip_ratio", paper_ratio, (0.4, 0.4), 0.999),
        ("paper", independent_ratio, (0.4, 0.4), 0.85),
        ("paper", paper_ratio, (0.4, 0.4), 0.70),
    ],
)
def test_gain_covers_the_uncertainty_without_much_to_spare(law, sample, alphas, least):
    """Supremum of ‖η‖/ρ over admissible states: at most 1, and near it, so that ρ is not too large."""
    ratio = sample(np.random.default_rng(1), law, alphas)
    assert ratio.max() <= 1.0 + 1e-9
    assert ratio.max() > least


def test_slip_ratio_form_is_not_valid_for_independent_slip_rates():
    """There ‖η‖ reaches √2 ρ: 2α against √2 α in front of ‖v̂‖ + ρ."""
    ratio = independent_ratio(np.random.default_rng(1), "slip_ratio", ANY)
    assert ratio.max() == pytest.approx(math.sqrt(2.0), abs=1e-4)


def test_forms_are_ordered_so_that_the_papers_holds_wherever_the_independent_one_does():
    """Slack in (51), ‖E‖ ≤ 2α where √2 α would do, pays for the Δv that the paper's slip rates leave out.

    2α‖v̂‖ + (1 + 2α) αv² + 2α|t·v̂| ≥ 2α‖v̂‖ + αv² √(α² + (1+α)²), each over 1 − 2α; the slip-ratio form is
    below both.
    """
    at = states(np.random.default_rng(2), ANY)
    paper, independent, slip_ratio = (
        bound(*at.known) for bound in (paper_bound, independent_bound, slip_ratio_bound)
    )
    assert (paper > independent).all()
    assert (independent > slip_ratio).all()


def test_sampler_would_notice_a_gain_that_is_two_per_cent_short():
    for law, sample in (("independent", independent_ratio), ("slip_ratio", constant_ratio)):
        assert (sample(np.random.default_rng(1), law, ANY) / 0.98).max() > 1.01
