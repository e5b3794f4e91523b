"""Wheels below and at the friction limit: creep, break-away, traction, curves."""

from __future__ import annotations

import math

import numpy as np

from slipctl.certify.fixture import Bench, Fixture
from slipctl.certify.rig import Rig
from slipctl.certify.specimen import ROUGH
from slipctl.certify.trace import Trace
from slipctl.theory.robot import GRAVITY

FRICTION = 0.2
"""On which the limits are sought: no caster of the Magellan Pro lifts before the wheels slide [1]."""

LARGEST_SLIP = 2.5
"""Speed of the spinning wheels over the floor at which traction is read at the latest [m/s]: the speed limit
of a scenario that names none. Slip adds to the wheels' load, 0.16 % for every m/s here."""


def _threshold(bench: Bench, sideways: bool) -> float:
    """Return the slope [rad] on which the weight pulls as hard as the wheels' load can hold."""
    rest = bench.specimen.rest
    low, high = 0.0, math.pi / 4.0
    for _ in range(60):
        slope = (low + high) / 2.0
        down, pull = GRAVITY * math.cos(slope), GRAVITY * math.sin(slope)
        # a robot held on a slope leans as one that is accelerated uphill
        loads = rest.loads(0.0 if sideways else pull, pull if sideways else 0.0, gravity=down)
        held = FRICTION * float(loads[:2].sum()) / rest.mass
        if sideways:
            held = rest.sideways(FRICTION, loads)
        low, high = (slope, high) if pull < held else (low, slope)
    return (low + high) / 2.0


def _hold(bench: Bench, slope: float, sideways: bool, duration: float) -> Trace:
    """Stand on a slope, wheels locked; the friction holds for 0.5 s, then it is what is asked for."""
    downhill = -math.pi / 2.0 if sideways else math.pi
    rig = bench.specimen.rig(ROUGH, slope, downhill, locked=True).stand()
    rig.run(0.5)
    rig.friction = FRICTION
    return rig.run(duration)


def _slides(bench: Bench, slope: float, sideways: bool) -> bool:
    """Return whether it gets faster: creep at a constant speed is not sliding."""
    trace = _hold(bench, slope, sideways, 0.6)
    speed = np.hypot(trace.momentum[:, 0], trace.momentum[:, 1])
    middle = len(speed) // 2
    lasted = 0.5 * 0.6
    return bool(
        speed[middle + middle // 2 :].mean() - speed[middle // 2 : middle].mean() > 2e-4 * GRAVITY * lasted
    )


def _break_away(bench: Bench, sideways: bool) -> tuple[float, float]:
    expected = _threshold(bench, sideways)
    low, high = 0.4 * expected, 2.0 * expected
    for _ in range(14):
        slope = (low + high) / 2.0
        low, high = (low, slope) if _slides(bench, slope, sideways) else (slope, high)
    return math.degrees((low + high) / 2.0), math.degrees(expected)


def break_away_longitudinal(bench: Bench) -> tuple[float, float]:
    """Return the slope on which locked wheels let go, facing uphill, and the closed form [deg]."""
    return _break_away(bench, False)


def break_away_lateral(bench: Bench) -> tuple[float, float]:
    """Return the slope on which the wheels let go sideways, and the closed form [deg]."""
    return _break_away(bench, True)


def _creep(bench: Bench, share: float) -> tuple[float, float]:
    worst = 0.0
    for sideways in (False, True):
        slope = share * _threshold(bench, sideways)
        trace = _hold(bench, slope, sideways, 0.8)
        half = trace.since(trace.time[0] + 0.5)
        way = trace.position[half][-1] - trace.position[half][0]
        worst = max(worst, float(np.hypot(way[0], way[1])) / (trace.time[-1] - trace.time[half][0]))
    return 1e3 * worst, 0.0


def creep_half(bench: Bench) -> tuple[float, float]:
    """Return the faster of the creeps downhill at half the threshold, and none [mm/s]."""
    return _creep(bench, 0.5)


def creep_near(bench: Bench) -> tuple[float, float]:
    """Return the faster of the creeps downhill at 0.9 of the threshold, and none [mm/s]."""
    return _creep(bench, 0.9)


def _traction(bench: Bench, share: float) -> tuple[float, float]:
    """Return the acceleration with torques of `share` times the limit, and the closed form [m/s²]."""
    rest = bench.specimen.rest
    limit = rest.grip_limit(FRICTION)
    torque = rest.torque(share * limit)
    ramp = 0.2  # not at once: the body would rock for long
    end = 0.8
    expected = share * limit
    if share > 1.0:
        expected = rest.spinning(FRICTION, torque)
        away = (
            rest.radius / rest.wheel_inertia * (torque - 0.5 * rest.mass * expected * rest.radius) - expected
        )
        # the wheels begin to spin within the ramp
        end = min(end, ramp + LARGEST_SLIP / away - 0.5 * ramp * (1.0 - 1.0 / share))

    def pull(rig: Rig, time: float) -> None:
        rig.drive(share * limit * min(1.0, time / ramp))

    trace = bench.specimen.rig(FRICTION, free=True).stand().run(end, pull)
    gained = trace.momentum[trace.since(max(ramp, 0.6 * end)), 0]
    return float(gained[-1] - gained[0]) / ((len(gained) - 1) * bench.timestep), expected


def traction_half(bench: Bench) -> tuple[float, float]:
    """Return the acceleration at half the limit torque, and half the limit [m/s²]."""
    return _traction(bench, 0.5)


def traction_near(bench: Bench) -> tuple[float, float]:
    """Return the acceleration at 0.9 of the limit torque, and 0.9 of the limit [m/s²]."""
    return _traction(bench, 0.9)


def traction_beyond(bench: Bench) -> tuple[float, float]:
    """Return the acceleration at 1.2 times the limit torque, and the limit [m/s²]."""
    return _traction(bench, 1.2)


def traction_far_beyond(bench: Bench) -> tuple[float, float]:
    """Return the acceleration at twice the limit torque, and the limit [m/s²]."""
    return _traction(bench, 2.0)


def _circle(bench: Bench, speed: float, radius: float, friction: float, duration: float) -> Trace:
    """Drive a circle with the wheels' rates held, 0.4 s on rough ground first."""
    rates = (speed, speed / radius)
    rig = bench.specimen.rig(ROUGH).stand(rolling=rates)

    def hold(rig: Rig, time: float) -> None:
        rig.data.qvel[bench.specimen.axles] = rig.rates(*rates)

    rig.run(0.4, hold)
    rig.friction = friction
    return rig.run(duration, hold)


def lateral_limit(bench: Bench) -> tuple[float, float]:
    """Return the largest v²/R that a circle is held at, by bisection of the speed, and μN/m [m/s²]."""
    rest = bench.specimen.rest
    radius = 8.0 * rest.half_track
    expected = FRICTION * GRAVITY
    for _ in range(20):
        expected = rest.sideways(FRICTION, rest.loads(0.0, expected))
    low, high = 0.5 * expected, 1.5 * expected
    for _ in range(11):
        middle = (low + high) / 2.0
        trace = _circle(bench, math.sqrt(middle * radius), radius, FRICTION, 0.8)
        slip = np.abs(trace.along(trace.velocity)[1])
        early, late = slip[trace.since(0.6)][:200].mean(), slip[trace.since(1.0)][:200].mean()
        low, high = (low, middle) if late - early > 2e-3 * middle * 0.4 else (middle, high)
    return (low + high) / 2.0, expected


def curve_slip(bench: Bench) -> tuple[float, float]:
    """Return the lateral slip in a steady curve well inside the grip, and v·w/b_t [mm/s]."""
    radius = 4.0 * bench.specimen.rest.half_track
    trace = _circle(bench, 0.5, radius, ROUGH, 1.0)
    window = trace.since(1.0)
    slip = -trace.along(trace.velocity)[1][window].mean()
    return 1e3 * float(slip), 1e3 * 0.5 * (0.5 / radius) / bench.specimen.slip_rate


STICKS = "stick creeps in proportion to 1/impratio: raise impratio"
CURVES = (
    "MuJoCo leaves J̇v out of contacts, so curves cost slip v·w/b_t: raise b_t (solreffriction in direct "
    "format) towards 1/timestep; more than that is two contacts a wheel that scrub"
)
HOPS = "the contact that should pull hops: soften the tyre (solref in direct format, constant solimp)"
EDGES = (
    "the wheels let go elsewhere than their load says: rigid casters that share it by chance, two contacts a "
    "wheel, or a hopping or pyramidal contact"
)

FIXTURES = (
    Fixture("break_away_longitudinal", "deg", 3e-3, True, "m g sin φ = μ N", EDGES, break_away_longitudinal),
    Fixture("break_away_lateral", "deg", 3e-3, True, "m g sin φ = μ N", EDGES, break_away_lateral),
    Fixture("creep_at_0.5_of_threshold", "mm/s", 0.01, False, "none", STICKS, creep_half),
    Fixture("creep_at_0.9_of_threshold", "mm/s", 0.01, False, "none", STICKS, creep_near),
    Fixture("traction_at_0.5_of_limit", "m/s²", 5e-3, True, "2τ / r / (m + 2J/r²)", STICKS, traction_half),
    Fixture("traction_at_0.9_of_limit", "m/s²", 5e-3, True, "2τ / r / (m + 2J/r²)", STICKS, traction_near),
    Fixture("traction_at_1.2_of_limit", "m/s²", 5e-3, True, "μ N / m", HOPS, traction_beyond),
    Fixture("traction_at_2_of_limit", "m/s²", 5e-3, True, "μ N / m", HOPS, traction_far_beyond),
    Fixture("lateral_limit", "m/s²", 0.01, True, "μ N / m", EDGES, lateral_limit),
    Fixture("curve_slip_floor", "mm/s", 0.02, True, "v w / b_t", CURVES, curve_slip),
)
