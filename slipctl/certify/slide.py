"""Locked wheels on Coulomb friction."""

from __future__ import annotations

import math

import numpy as np

from slipctl.certify.fixture import Bench, Fixture
from slipctl.certify.rig import Rig
from slipctl.certify.trace import Trace

SLIPPERY, GRIPPY = 0.2, 0.7
"""The two frictions [1]."""


def _slide(bench: Bench, degrees: float, speed: float = 2.0, duration: float = 0.9) -> Trace:
    angle = math.radians(degrees)
    rig = bench.specimen.rig(friction=SLIPPERY, locked=True)
    rig.stand(velocity=(speed * math.cos(angle), speed * math.sin(angle)))
    return rig.run(duration, work=True)


def _deceleration(bench: Bench, degrees: float) -> tuple[float, float]:
    """Return the deceleration of a slide, and μN/m with the load that the wheels carried [m/s²].

    Sliding askew the wheels carry different loads, so the robot turns, and their frictions are not parallel:
    the closed form takes the two directions from the motion.
    """
    rest, trace = bench.specimen.rest, _slide(bench, degrees)
    window = trace.since(0.5)  # pitching and rolling have died down
    gained = trace.momentum[window]
    lost = gained[0] - gained[-1]
    lasted = (len(gained) - 1) * bench.timestep
    along, left = trace.along(trace.velocity)
    at_wheel = np.stack([[along - trace.yaw_rate * y, left] for y in (rest.half_track, -rest.half_track)])
    way = at_wheel / np.sqrt((at_wheel**2).sum(axis=1))[:, None, :]
    pull = SLIPPERY * np.sqrt(((way * trace.load.T[:, None, :]).sum(axis=0) ** 2).sum(axis=0)) / rest.mass
    return float(np.hypot(lost[0], lost[1])) / lasted, float(pull[window][:-1].mean())


def wheel_load(bench: Bench) -> tuple[float, float]:
    """Return the wheels' load in a slide ahead, and that of a rigid body on springs [N]."""
    trace, rest = _slide(bench, 0.0), bench.specimen.rest
    expected = rest.sliding(SLIPPERY, 1.0, 0.0) * rest.mass / SLIPPERY
    return float(trace.load[trace.since(0.5)].sum(axis=1).mean()), expected


def longitudinal(bench: Bench) -> tuple[float, float]:
    """Return the deceleration sliding ahead, and μN/m [m/s²]."""
    return _deceleration(bench, 0.0)


def lateral(bench: Bench) -> tuple[float, float]:
    """Return the deceleration sliding sideways, and μN/m [m/s²]."""
    return _deceleration(bench, 90.0)


def diagonal(bench: Bench) -> tuple[float, float]:
    """Return the deceleration sliding at 45°, and μN/m [m/s²]."""
    return _deceleration(bench, 45.0)


def isotropy(bench: Bench) -> tuple[float, float]:
    """Return the largest ratio of decelerations over μN/m between directions, and 1."""
    ratios = []
    for degrees in (0.0, 22.5, 45.0, 67.5, 90.0):
        measured, expected = _deceleration(bench, degrees)
        ratios.append(measured / expected)
    return max(ratios) / min(ratios), 1.0


def _towed(bench: Bench, friction: float, sideways: bool) -> Trace:
    """Tow the robot, wheels locked, at a steady 1 m/s for 1.5 s."""
    rest = bench.specimen.rest
    ahead = friction * float(rest.load.sum())
    # a robot with casters behind only would fall on its nose
    way = -1.0 if len(rest.caster) and (rest.caster_place[:, 0] < 0.0).all() else 1.0

    def pull(rig: Rig, time: float) -> None:
        along = way * float(rig.data.qvel[bench.specimen.v + int(sideways)])
        force = way * (ahead + 10.0 * rest.mass * (1.0 - along))
        rig.tow((0.0, force) if sideways else (force, 0.0))

    rig = bench.specimen.rig(friction=friction, locked=True)
    return rig.stand(velocity=(0.0, way) if sideways else (way, 0.0)).run(1.5, pull)


def _airborne(bench: Bench, friction: float) -> tuple[float, float]:
    return float(
        sum((_towed(bench, friction, sideways).load <= 0.0).any(axis=1).sum() for sideways in (False, True))
    ), 0.0


def _chatter(bench: Bench, friction: float) -> tuple[float, float]:
    worst = 0.0
    for sideways in (False, True):
        trace = _towed(bench, friction, sideways)
        load = trace.load[trace.since(0.8)].sum(axis=1)
        worst = max(worst, float(load.std() / load.mean()))
    return worst, 0.0


def airborne_slippery(bench: Bench) -> tuple[float, float]:
    """Return the steps with a wheel in the air, and none."""
    return _airborne(bench, SLIPPERY)


def airborne_grippy(bench: Bench) -> tuple[float, float]:
    """Return the steps with a wheel in the air, and none."""
    return _airborne(bench, GRIPPY)


def chatter_slippery(bench: Bench) -> tuple[float, float]:
    """Return standard deviation over mean of the wheels' load, and none."""
    return _chatter(bench, SLIPPERY)


def chatter_grippy(bench: Bench) -> tuple[float, float]:
    """Return standard deviation over mean of the wheels' load, and none."""
    return _chatter(bench, GRIPPY)


def friction_work(bench: Bench) -> tuple[float, float]:
    """Return the energy lost in a slide, and what friction took [J]."""
    trace = _slide(bench, 90.0)
    first, last = (int(np.searchsorted(trace.time, t)) for t in (0.5, 0.85))
    power = trace.rubbing[first : last + 1]
    taken = -bench.timestep * float((power[:-1] + power[1:]).sum() / 2.0)
    return float(trace.energy[first] - trace.energy[last]), taken


HOPS = (
    "the load varies while a wheel slides: it hops, if steps are airborne too (slip adds to the normal force "
    "of a stiff contact: give the tyre a solref in direct format and a constant solimp), or else the robot "
    "turns or pitches, as with its mass off the axle"
)
PYRAMID = 'the pyramidal friction cone does not give μN in every direction: use cone="elliptic"'

FIXTURES = (
    Fixture("sliding_deceleration_longitudinal", "m/s²", 1e-3, True, "μ N / m", HOPS, longitudinal),
    Fixture("sliding_deceleration_lateral", "m/s²", 1e-3, True, "μ N / m", HOPS, lateral),
    Fixture("sliding_deceleration_45_deg", "m/s²", 1e-3, True, "μ N / m", PYRAMID, diagonal),
    Fixture("sliding_isotropy", "1", 5e-3, True, "the same in every direction", PYRAMID, isotropy),
    Fixture("wheel_load_sliding", "N", 5e-3, True, "rigid body on springs", HOPS, wheel_load),
    Fixture("airborne_steps_friction_0.2", "steps", 0.0, False, "towed at 1 m/s", HOPS, airborne_slippery),
    Fixture("airborne_steps_friction_0.7", "steps", 0.0, False, "towed at 1 m/s", HOPS, airborne_grippy),
    Fixture("load_chatter_friction_0.2", "1", 0.01, False, "N does not vary", HOPS, chatter_slippery),
    Fixture("load_chatter_friction_0.7", "1", 0.01, False, "N does not vary", HOPS, chatter_grippy),
    Fixture("energy_lost_sliding", "J", 5e-3, True, "∫ F·v dt of the wheels", HOPS, friction_work),
)
