"""Section V-A against its known numbers, and the sampled loop against continuous control.

The continuous loop is written here once more, with the paper's slip in it, and integrated by Radau.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipctl.simulate import Controller
from slipctl.theory.robust import UNCERTAINTIES, largest_calm_tick
from slipctl.theory.slip import NoSlip
from slipctl.tick import Array
from tests.builders import (
    PAPER_LAYER,
    PAPER_POLE,
    PAPER_SLIP,
    Errors,
    Track,
    full,
    nominal_law,
    ode_plant,
    paper_slip,
    robust_law,
    rows_of,
    table_one,
    track,
)

DURATION = 20.0
LAWS = ("nominal", "paper", "independent", "slip_ratio")


def law(name: str) -> Controller:
    pole = full(1, PAPER_POLE)
    if name == "nominal":
        return nominal_law(pole)
    return robust_law(pole, full(1, PAPER_SLIP), full(1, PAPER_LAYER), UNCERTAINTIES[name].bound)


def sampled(name: str, tick: float, duration: float = DURATION) -> Track:
    return track(ode_plant(paper_slip(), 1), law(name), rows_of(table_one(), tick, duration), tick)


def gain(name: str, alpha: float, v: float, nominal: complex, forward: float) -> float:
    """Return ρ, solved from its definition ρ = q (‖v̂‖ + ρ) + Φ."""
    if name == "nominal":
        return 0.0
    yaw_slip = alpha * v
    if name == "paper":
        q = 2.0 * alpha
        phi = alpha * v * yaw_slip + 2.0 * alpha * abs(forward) + (1.0 + alpha) * v * yaw_slip
    else:
        q = 2.0 * alpha if name == "independent" else math.sqrt(2.0) * alpha
        phi = v * yaw_slip * abs(1.0 + alpha * (1.0 + 1.0j))
    return (q * abs(nominal) + phi) / (1.0 - q)


def planned(t: float) -> tuple[complex, complex, complex]:
    """Return Table I's cubic and its derivatives, coefficients by hand."""
    return (
        complex(0.009 * t**2 - 0.0003 * t**3, 0.15 * t - 0.01125 * t**2 + 0.000375 * t**3),
        complex(0.018 * t - 0.0009 * t**2, 0.15 - 0.0225 * t + 0.001125 * t**2),
        complex(0.018 - 0.0018 * t, -0.0225 + 0.00225 * t),
    )


@functools.cache
def continuous(name: str) -> Array:
    """Return F − F_d (T + 1,), complex, every 2 ms, under continuous control."""

    def rhs(t: float, y: Array) -> list[float]:
        x, north, heading, v = y
        e = complex(math.cos(heading), math.sin(heading))
        velocity = v * (1.0 + PAPER_SLIP * (1.0 - 1.0j)) * e  # v_t forward, v_s to the right
        at = planned(t)
        e1, e2 = complex(x, north) - at[0], velocity - at[1]
        nominal = at[2] - 0.25 * e1 - 1.0 * e2
        weighted = 2.0 * e1 + 2.5 * e2
        forward = (nominal * e.conjugate()).real
        rho = gain(name, PAPER_SLIP, v, nominal, forward)
        wanted = (nominal - rho * weighted / max(abs(weighted), PAPER_LAYER)) * e.conjugate()
        return [velocity.real, velocity.imag, wanted.imag / v + PAPER_SLIP * v, wanted.real]

    times = np.linspace(0.0, DURATION, 10001)
    start = [0.0, 0.0, math.pi / 2.0, 0.15]
    solution = solve_ivp(rhs, (0.0, DURATION), start, "Radau", times, rtol=1e-10, atol=1e-12)
    plan = np.array([planned(t)[0] for t in times])
    return solution.y[0] + 1j * solution.y[1] - plan


@dataclass(frozen=True)
class Target:
    """Known numbers of Section V-A with continuous control: errors in mm, speed in m/s."""

    maximum: float
    rms: float
    final: float
    max_x: float
    max_y: float
    min_speed: float


TARGETS = {
    "nominal": Target(37.8, 17.3, 31.1, 21.8, 31.1, 0.0605),
    "paper": Target(3.95, 0.87, 0.49, 2.25, 3.27, 0.0643),
    "independent": Target(6.7, 1.40, 0.83, 3.8, 5.5, 0.0643),
    "slip_ratio": Target(14.5, 3.47, 2.3, 8.2, 12.0, 0.0643),
}


@pytest.mark.parametrize("name", LAWS)
def test_section_five_a(name):
    """At 1 ms within 2 % of the known numbers, and of continuous control within 0.2 % (robust 1 %)."""
    run = sampled(name, 0.001)
    errors, target = Errors.of(run.position_error[:, 0]), TARGETS[name]
    gap = 1e3 * np.abs(run.stack("motion", "position") - run.stack("reference", "position"))[:, 0]
    assert 1e3 * errors.maximum == pytest.approx(target.maximum, rel=0.02)
    assert 1e3 * errors.rms == pytest.approx(target.rms, rel=0.02)
    assert 1e3 * errors.final == pytest.approx(target.final, rel=0.02)
    assert gap.max(axis=0) == pytest.approx([target.max_x, target.max_y], rel=0.02)
    assert run.stack("motion", "forward_speed").min() == pytest.approx(target.min_speed, rel=0.002)
    assert not run.stack("decision", "trace", "saturated").any()

    exact = Errors.of(np.abs(continuous(name)))
    tolerance = 0.002 if name == "nominal" else 0.01
    for field in ("maximum", "rms", "final"):
        assert getattr(errors, field) == pytest.approx(getattr(exact, field), rel=tolerance), field


@pytest.mark.parametrize("name", LAWS)
def test_sampled_control_converges_to_continuous_control_with_first_order(name):
    """Halving the tick halves the distance to Radau's path, everywhere along it."""
    exact = continuous(name)[::4]
    distance = []
    for tick in (0.008, 0.004, 0.002):
        run = sampled(name, tick)
        error = (run.stack("motion", "position") - run.stack("reference", "position"))[
            :: round(0.008 / tick), 0
        ]
        distance.append(np.abs(error[:, 0] + 1j * error[:, 1] - exact).max())
    orders = np.log2(np.array(distance[:-1]) / distance[1:])
    assert (np.abs(orders - 1.0) < 0.15).all(), orders


def test_robot_points_past_its_path_by_the_angle_that_its_slip_makes():
    """Tracking means that Ḟ points along Ḟ_d, so the heading leads by atan(v_s/(v + v_t)): Fig. 6."""
    run = sampled("paper", 0.01)
    after = run.stack("motion", "heading_vector")[500:, 0], run.stack("reference", "velocity")[500:, 0]
    facing, along = (vector[:, 0] + 1j * vector[:, 1] for vector in after)
    offset = np.angle(facing / along)
    expected = math.atan(PAPER_SLIP / (1.0 + PAPER_SLIP))
    assert expected == pytest.approx(0.278, abs=5e-4)
    assert offset.mean() == pytest.approx(expected, abs=0.002)
    assert np.abs(offset - expected).max() < 0.006


def test_slip_and_inputs_are_those_of_the_figures():
    """Fig. 3: v_t from 0.060 to 0.026 m/s. Fig. 7: v̂ and Δv."""
    run = sampled("paper", 0.005)
    slip = run.stack("slip", "longitudinal")[:, 0]
    assert slip[0] == slip.max() == pytest.approx(0.060, rel=1e-12)
    assert slip.min() == pytest.approx(0.026, abs=5e-4)
    for other in ("lateral", "yaw"):
        np.testing.assert_allclose(run.stack("slip", other)[:, 0], slip, rtol=0, atol=1e-12)
    nominal, robust = (
        np.hypot(*run.stack("decision", "trace", name)[:, 0].T) for name in ("nominal_input", "robust_input")
    )
    assert nominal.max() == nominal[0] == pytest.approx(0.0926, rel=0.002)
    assert robust.max() == robust[0] == pytest.approx(0.78, rel=0.005)
    assert robust[1000:].max() == pytest.approx(0.0115, rel=0.01)


def test_slow_ticks_make_the_boundary_layer_chatter():
    """Total variation of the commanded yaw rate: 5.9 rad/s at 20 ms, 81 at 50 ms; nominal 1 at both."""
    ticks = {"paper": (0.02, 0.05), "nominal": (0.02, 0.05)}
    variation = {
        (name, tick): np.abs(
            np.diff(sampled(name, tick).stack("decision", "command", "yaw_rate")[:, 0])
        ).sum()
        for name, each in ticks.items()
        for tick in each
    }
    assert variation["paper", 0.02] == pytest.approx(5.9, rel=0.02)
    assert variation["paper", 0.05] == pytest.approx(81.0, rel=0.02)
    for tick in ticks["nominal"]:
        assert variation["nominal", tick] == pytest.approx(1.0, rel=0.02)

    gains = sampled("paper", 0.02).stack("decision", "trace", "robust_gain")[250:, 0]
    sigma = np.array([PAPER_SLIP * (1.0 - 1.0j)])
    calm = largest_calm_tick(full(1, PAPER_LAYER), gains.max(keepdims=True), full(1, 2.5), sigma)[0]
    assert 0.02 < calm < 0.05


@pytest.mark.parametrize("name", LAWS)
def test_without_slip_only_the_hold_is_left_of_the_error(name):
    """All that remains is of first order in the tick, and the corrective term does no harm."""
    maximum = []
    for tick in (0.02, 0.01):
        run = track(ode_plant(NoSlip(1), 1), law(name), rows_of(table_one(), tick, DURATION), tick)
        maximum.append(Errors.of(run.position_error[:, 0]).maximum)
    assert maximum[1] < 1e-4
    assert maximum[0] / maximum[1] == pytest.approx(2.0, abs=0.1 if name == "nominal" else 0.6)


def test_discontinuous_law_is_tighter_and_chatters():
    """(47) against (59) at 5 ms: smaller error after the start, far more switching."""
    pole, alpha, tick = full(1, PAPER_POLE), full(1, PAPER_SLIP), 0.005
    found = {}
    for layer in (0.0, PAPER_LAYER):
        run = track(
            ode_plant(paper_slip(), 1),
            robust_law(pole, alpha, full(1, layer)),
            rows_of(table_one(), tick, 10.0),
            tick,
        )
        turn = run.stack("decision", "command", "yaw_rate")[1000:, 0]
        found[layer] = run.position_error[1000:, 0].max(), np.abs(np.diff(turn)).sum()
    assert found[0.0][0] < found[PAPER_LAYER][0] < 1e-3
    assert found[0.0][1] > 100.0 * found[PAPER_LAYER][1]
