"""Section V-B against its known numbers, and the sampled loop against continuous control.

The continuous loop is written here once more, from (31) with v and w as states, and integrated by Radau.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipctl.simulate import Controller
from slipctl.theory.reference import Plan, PointToPoint
from slipctl.theory.slip import NoSlip, ProportionalSlip, SinusoidalSlip, SlipLaw
from slipctl.tick import Array
from tests.builders import PAPER_POLE, Errors, Track, at_origin, full, paper_slip, rows_of, track
from tests.dynamic import (
    BOUNDS,
    DYNAMIC_LAYER,
    DYNAMIC_SLIP,
    dynamic_plant,
    nominal_dynamic,
    quintic_table_one,
    robust_dynamic,
)

LAWS = ("nominal", "paper", "proportional")


def law(name: str, worlds: int = 1) -> Controller:
    pole = full(worlds, PAPER_POLE)
    if name == "nominal":
        return nominal_dynamic(pole)
    return robust_dynamic(pole, full(worlds, DYNAMIC_LAYER), BOUNDS[name](full(worlds, DYNAMIC_SLIP)))


@dataclass(frozen=True)
class Case:
    """A path and a slip, once for the package and once for the continuous loop."""

    plan: Plan
    ends: tuple[tuple[float, ...], tuple[float, ...]]
    duration: float
    slip_law: SlipLaw
    period: float | None

    def fractions(self, t: float) -> tuple[complex, complex, float, float]:
        """Return (v_t − i v_s)/v, its rate, w_s/v and its rate; all three amplitudes are `DYNAMIC_SLIP`."""
        factor, rate = 1.0, 0.0
        if self.period is not None:
            frequency = 2.0 * math.pi / self.period
            factor, rate = math.sin(frequency * t), frequency * math.cos(frequency * t)
        both, yaw = DYNAMIC_SLIP * (1.0 - 1.0j), DYNAMIC_SLIP
        return factor * both, rate * both, factor * yaw, rate * yaw

    @functools.cached_property
    def coefficients(self) -> Array:
        """Return the quintic (6,), complex, constant first, from its six end conditions."""
        rows, values = [], []
        for t, (x, y, heading, v, w, a) in zip((0.0, self.duration), self.ends, strict=True):
            powers = np.arange(6.0)
            e = complex(math.cos(heading), math.sin(heading))
            rows += [t**powers, powers * t ** np.maximum(powers - 1, 0)]
            rows += [powers * (powers - 1) * t ** np.maximum(powers - 2, 0)]
            values += [complex(x, y), v * e, (a + 1j * v * w) * e]
        return np.linalg.solve(np.array(rows), np.array(values))

    def planned(self, t: float) -> list[complex]:
        """Return F_d and three derivatives."""
        polynomial = np.polynomial.Polynomial(self.coefficients)
        return [complex(polynomial.deriv(k)(t)) if k else complex(polynomial(t)) for k in range(4)]


SECTION_FIVE_B = Case(
    quintic_table_one(),
    ((0.0, 0.0, math.pi / 2.0, 0.15, 0.0, 0.0), (1.2, 1.5, math.pi / 2.0, 0.15, 0.0, 0.0)),
    20.0,
    paper_slip(1, DYNAMIC_SLIP),
    None,
)
_ENDS = ((0.3, -0.2, 0.4, 0.4, 0.3, 0.05), (2.5, 1.5, 1.2, 0.5, -0.25, -0.06))
SWINGING = Case(
    PointToPoint(np.array([_ENDS[0]]), np.array([_ENDS[1]]), full(1, 6.0), at_origin(1)),
    _ENDS,
    6.0,
    SinusoidalSlip(*(full(1, DYNAMIC_SLIP) for _ in range(3)), period=full(1, 3.7)),
    3.7,
)
CASES = {"section_five_b": SECTION_FIVE_B, "swinging": SWINGING}


@functools.cache
def sampled(case: str, name: str, tick: float) -> Track:
    one = CASES[case]
    references = rows_of(one.plan, tick, one.duration)
    return track(dynamic_plant(one.slip_law, 1), law(name), references, tick)


def gain(name: str, v: float, w: float, mu1: float, nominal: complex, jerk: float) -> float:
    """Return ρ, solved from its definition ρ = q (‖v̂‖ + ρ) + ‖(along, across)‖."""
    a, v, w, mu1 = DYNAMIC_SLIP, abs(v), abs(w), abs(mu1)
    if name == "nominal":
        return 0.0
    if name == "paper":
        along = a * mu1 * w + a * v * w**2
        across = a * v * w**2 + (1.0 + a) * v * a * mu1 + a * abs(jerk) + 2.0 * a * w * mu1
        return (a * abs(nominal) + along + across) / (1.0 - a)
    kb, most = a / (1.0 - a), w + a * v
    rate = (mu1 + a * v * most) / (1.0 - a)
    q = kb * math.sqrt(1.0 + (1.0 - 2.0 * a) ** 2)
    along = a * rate * most + a * v * most**2 + v * (most**2 - w**2)
    mixed = 2.0 * (a + a**2 / (1.0 + a)) * w * mu1
    across = kb * v * w**2 + mixed + kb * a * rate * most + a * v * most**2 + 2.0 * mu1 * a * v
    return (q * abs(nominal) + math.hypot(along, across)) / (1.0 - q)


@functools.cache
def continuous(case: str, name: str) -> Array:
    """Return F − F_d (T + 1,), complex, every 2 ms, under continuous control."""
    one = CASES[case]

    def rhs(t: float, y: Array) -> list[float]:
        x, north, heading, v, w, mu1 = y
        e = complex(math.cos(heading), math.sin(heading))
        sigma, sigma_rate, yaw, yaw_rate = one.fractions(t)
        turn = w + yaw * v
        v_s = -sigma.imag * v
        v_rate = (mu1 - sigma_rate.real * v - v_s * turn) / (1.0 + sigma.real)  # (31d) solved for v̇
        velocity = (1.0 + sigma) * v * e
        acceleration = (sigma_rate * v + (1.0 + sigma) * v_rate + 1j * turn * (1.0 + sigma) * v) * e
        at = one.planned(t)
        e1, e2, e3 = complex(x, north) - at[0], velocity - at[1], acceleration - at[2]
        nominal = at[3] - 0.125 * e1 - 0.75 * e2 - 1.5 * e3
        weighted = 4.0 * e1 + 9.8125 * e2 + 6.875 * e3
        drift = (-v * w**2 + 2j * w * mu1) * e
        rho = gain(name, v, w, mu1, nominal, ((nominal - drift) * e.conjugate()).real)
        flat_input = nominal - rho * weighted / max(abs(weighted), DYNAMIC_LAYER)
        bars = (flat_input - drift) * e.conjugate()
        w_rate = bars.imag / v - (yaw_rate * v + yaw * v_rate)  # (31f)
        return [velocity.real, velocity.imag, turn, v_rate, w_rate, bars.real]

    times = np.linspace(0.0, one.duration, round(one.duration * 500.0) + 1)
    x, y, heading, v, w, a = one.ends[0]
    solution = solve_ivp(
        rhs, (0.0, one.duration), [x, y, heading, v, w, a], "Radau", times, rtol=1e-9, atol=1e-12
    )
    assert solution.success
    return solution.y[0] + 1j * solution.y[1] - np.array([one.planned(t)[0] for t in times])


@dataclass(frozen=True)
class Target:
    """Known numbers of Section V-B with continuous control: errors in mm, speed in m/s."""

    maximum: float
    rms: float
    final: float
    max_x: float
    max_y: float
    min_speed: float


TARGETS = {
    "nominal": Target(100.4, 54.4, 8.0, 66.9, 75.4, 0.0630),
    "paper": Target(74.3, 28.9, 0.16, 48.5, 56.3, 0.0585),
    "proportional": Target(64.6, 22.9, 0.09, 42.2, 48.9, 0.0631),
}


@pytest.mark.parametrize("name", LAWS)
def test_section_five_b(name):
    """At 1 ms within 2 % of the known numbers; the smallest have one or two digits."""
    run = sampled("section_five_b", name, 0.001)
    errors, target = Errors.of(run.position_error[:, 0]), TARGETS[name]
    gap = 1e3 * np.abs(run.stack("motion", "position") - run.stack("reference", "position"))[:, 0]
    assert 1e3 * errors.maximum == pytest.approx(target.maximum, rel=0.02)
    assert 1e3 * errors.rms == pytest.approx(target.rms, rel=0.02)
    assert 1e3 * errors.final == pytest.approx(target.final, rel=0.02, abs=0.005)
    assert gap.max(axis=0) == pytest.approx([target.max_x, target.max_y], rel=0.02)
    assert run.stack("motion", "forward_speed").min() == pytest.approx(target.min_speed, rel=0.002)
    torque = run.stack("decision", "command", "wheel_torque_end")
    assert 0.03 < np.abs(torque).max() < 0.06  # Fig. 12
    assert not run.stack("decision", "trace", "saturated").any()


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("name", LAWS)
def test_control_at_one_millisecond_is_almost_continuous(case, name):
    """Nominal within 0.2 %, robust within 1 %."""
    errors = Errors.of(sampled(case, name, 0.001).position_error[:, 0])
    exact = Errors.of(np.abs(continuous(case, name)))
    for field in ("maximum", "rms", "final"):
        tolerance = 0.002 if name == "nominal" else 0.01
        assert getattr(errors, field) == pytest.approx(getattr(exact, field), rel=tolerance), field
    assert exact.maximum > 5e-3


@pytest.mark.parametrize("name", LAWS)
def test_sampled_control_converges_to_continuous_control_with_first_order(name):
    """Halving the tick halves the distance to Radau's path, everywhere along it.

    On the whole only for the robust laws: the edges of their ρ and of the layer are met at other instants.
    """
    exact = continuous("swinging", name)[::4]
    distance = []
    for tick in (0.008, 0.004, 0.002, 0.001):
        run = sampled("swinging", name, tick)
        error = run.stack("motion", "position") - run.stack("reference", "position")
        error = error[:: round(0.008 / tick), 0]
        distance.append(np.abs(error[:, 0] + 1j * error[:, 1] - exact).max())
    orders = np.log2(np.array(distance[:-1]) / distance[1:])
    assert orders.mean() == pytest.approx(1.0, abs=0.01 if name == "nominal" else 0.2), orders
    assert (orders > 0.5).all()


@pytest.mark.parametrize("name", ["paper", "proportional"])
def test_robot_points_past_its_path_by_the_angle_that_its_slip_makes(name):
    """Tracking means that Ḟ points along Ḟ_d, so the heading leads by atan(v_s/(v + v_t)): Fig. 10."""
    run = sampled("section_five_b", name, 0.001)
    facing = run.stack("motion", "heading_vector")[10_000:, 0]
    along = run.stack("reference", "velocity")[10_000:, 0]
    offset = np.angle((facing[:, 0] + 1j * facing[:, 1]) / (along[:, 0] + 1j * along[:, 1]))
    expected = math.atan(DYNAMIC_SLIP / (1.0 + DYNAMIC_SLIP))
    assert expected == pytest.approx(0.227, abs=5e-4)
    assert offset.mean() == pytest.approx(expected, abs=0.0015)
    assert np.abs(offset - expected).max() < 0.003


@functools.cache
def excess(name: str) -> Array:
    """Return the largest ‖η_k‖/ρ_k of V-B for all eight signs of v_t, v_s and w_s; + + + is the paper's."""
    tick = 0.004
    signs = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0], indexing="ij")).reshape(3, 8)
    slip = ProportionalSlip(*(DYNAMIC_SLIP * signs))
    run = track(dynamic_plant(slip, 8), law(name, 8), rows_of(quintic_table_one(8), tick, 20.0), tick)
    flat_input = run.stack("decision", "trace", "nominal_input") + run.stack(
        "decision", "trace", "robust_input"
    )
    uncertainty = np.diff(run.stack("motion", "acceleration"), axis=0) / tick - flat_input[:-1]
    ratio = np.hypot(uncertainty[..., 0], uncertainty[..., 1])
    return (ratio / run.stack("decision", "trace", "robust_gain")[:-1]).max(axis=0)


def test_paper_gain_is_exceeded_on_the_papers_path():
    """Not for the paper's own signs, but for four others, by up to 5 %."""
    found = excess("paper")
    assert found[-1] < 0.8
    assert ((found > 1.005) & (found < 1.06)).sum() == 4
    assert found.max() == pytest.approx(1.05, abs=0.005)


def test_proportional_gain_is_never_exceeded_on_the_papers_path():
    found = excess("proportional")
    assert (found < 1.0).all()
    assert found.max() > 0.9


@pytest.mark.parametrize("name", LAWS)
def test_without_slip_only_the_hold_is_left_of_the_error(name):
    """All that remains is of first order in the tick, and the corrective term does no harm."""
    maximum = []
    for tick in (0.008, 0.004):
        run = track(dynamic_plant(NoSlip(1), 1), law(name), rows_of(quintic_table_one(), tick, 10.0), tick)
        maximum.append(run.position_error.max())
    assert maximum[1] < 1e-4
    assert maximum[0] / maximum[1] == pytest.approx(2.0, abs=0.1 if name == "nominal" else 0.6)
