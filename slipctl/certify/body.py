"""The robot itself: mass, inertia, centre of mass, rolling radius, casters."""

from __future__ import annotations

import math

import numpy as np

from slipctl.certify.fixture import Bench, Fixture
from slipctl.certify.rest import Rest
from slipctl.certify.rig import Rig
from slipctl.certify.specimen import ROUGH
from slipctl.tick import Array


def _parts(bench: Bench) -> tuple[Array, Array, Array]:
    """Return mass (K,), place (K, 3) from the body origin, and yaw inertia (K,) of the robot's bodies."""
    rig = bench.specimen.rig().stand()
    return rig.parts()


def mass(bench: Bench) -> tuple[float, float]:
    """Return the mass the motion feels, and the sum over the file's bodies."""
    return bench.specimen.rest.mass, float(_parts(bench)[0].sum())


def yaw_inertia(bench: Bench) -> tuple[float, float]:
    """Return the yaw inertia the motion feels, and Steiner's sum over the bodies."""
    specimen = bench.specimen
    masses, places, own = _parts(bench)
    felt = specimen.rest.inertia[specimen.v + 5, specimen.v + 5]
    return float(felt), float((own + masses * (places[:, 0] ** 2 + places[:, 1] ** 2)).sum())


def centre_ahead(bench: Bench) -> tuple[float, float]:
    """Return how far the centre of mass lies ahead of the axle, by ``mj_fullM`` and summed [mm]."""
    specimen, (masses, places, _) = bench.specimen, _parts(bench)
    full = specimen.rest.inertia
    felt = full[specimen.v + 5, specimen.v + 1] / specimen.rest.mass
    return 1e3 * float(felt), 1e3 * float((masses * places[:, 0]).sum() / masses.sum())


def centre_height(bench: Bench) -> tuple[float, float]:
    """Return how high the centre of mass lies over the axle, likewise [mm]."""
    specimen, (masses, places, _) = bench.specimen, _parts(bench)
    full = specimen.rest.inertia
    felt = full[specimen.v + 4, specimen.v] / specimen.rest.mass
    return 1e3 * float(felt), 1e3 * float((masses * places[:, 2]).sum() / masses.sum())


def rolling_radius(bench: Bench) -> tuple[float, float]:
    """Return way over wheel angle on a straight line, and the height of the axle over the contact [mm]."""
    rig = bench.specimen.rig().stand(rolling=(0.3, 0.0))
    trace = rig.run(1.5)
    window = trace.since(0.5)
    way = trace.position[window][-1, 0] - trace.position[window][0, 0]
    # all but the last step: positions follow from the rates up to there
    turned = trace.wheel_rate[window][:-1].mean(axis=1).sum() * bench.timestep
    return 1e3 * way / turned, 1e3 * float(bench.specimen.rest.geometry.wheel_radius)


def _casters(bench: Bench) -> Rest:
    """Return the robot at rest, if it has casters."""
    if len(bench.specimen.rest.caster) == 0:
        raise ValueError("nothing but the wheels touches the floor at rest")
    return bench.specimen.rest


def lift_off(bench: Bench) -> tuple[float, float]:
    """Return the deceleration at which a caster lifts, and at which it would have to pull [m/s²].

    With no caster behind the axle: the acceleration.
    """
    rest = _casters(bench)
    behind = rest.caster_place[:, 0] < 0.0
    way = -1.0 if behind.any() else 1.0
    which = behind if behind.any() else ~behind
    level, braked = (  # loads are linear in the acceleration until something lifts
        rest.loads(a, 0.0, a / rest.radius)[2:][which].min() for a in (0.0, 0.01 * way)
    )
    expected = 0.01 * float(level / (level - braked)) * rest.pitch_stiffness / rest.spring

    def pull(rig: Rig, time: float) -> None:
        rig.drive(0.5 * expected * way * time)

    trace = bench.specimen.rig(ROUGH, free=True).stand().run(3.0, pull)
    lifted = np.flatnonzero((trace.caster[:, which] <= 0.0).any(axis=1))
    if len(lifted) == 0:
        return math.inf, expected
    at = int(lifted[0])
    window = slice(max(0, at - 10), at + 1)
    gained = trace.momentum[window, 0] * way
    return float((gained[-1] - gained[0]) / (max(len(gained) - 1, 1) * bench.timestep)), expected


def pitch(bench: Bench) -> tuple[float, float]:
    """Return the pitch at 1 m/s², nose up, and what the casters' springs make of it [mrad]."""
    rest = _casters(bench)

    def pull(rig: Rig, time: float) -> None:
        rig.drive(min(1.0, time))

    trace = bench.specimen.rig(ROUGH, free=True).stand().run(2.0, pull)
    window = trace.since(1.5)
    return -1e3 * float(trace.pitch[window].mean() - trace.pitch[0]), 1e3 * rest.nose_up(1.0)


FIXTURES = (
    Fixture("mass", "kg", 1e-6, True, "Σ mᵢ", "part of the robot is not free to move", mass),
    Fixture(
        "yaw_inertia",
        "kg·m²",
        1e-6,
        True,
        "Σ Iᵢ + mᵢ dᵢ²",
        "part of the robot is not free to turn",
        yaw_inertia,
    ),
    Fixture(
        "centre_of_mass_ahead",
        "mm",
        1e-3,
        False,
        "Σ mᵢ xᵢ / m, from the axle",
        "part of the robot is not free to move",
        centre_ahead,
    ),
    Fixture(
        "centre_of_mass_height",
        "mm",
        1e-3,
        False,
        "Σ mᵢ zᵢ / m, from the axle",
        "part of the robot is not free to move",
        centre_height,
    ),
    Fixture(
        "rolling_radius",
        "mm",
        5e-4,
        True,
        "axle over contact point at rest",
        "the wheels roll on another radius than they stand on: several contacts, or creep",
        rolling_radius,
    ),
    Fixture(
        "caster_lift_off",
        "m/s²",
        0.02,
        True,
        "where its spring would have to pull",
        "rigid casters: how much of the weight they carry, and when they lift, is left to chance",
        lift_off,
    ),
    Fixture(
        "pitch_at_1_m_s2",
        "mrad",
        0.02,
        True,
        "a (m h + 2J/r) / (Σ k l² − what tips over)",
        "the casters have no stiffness of their own: the body does not pitch as on springs",
        pitch,
    ),
)
