"""Mirror symmetry, and what the timestep does."""

from __future__ import annotations

import math

import numpy as np

from slipctl.certify.fixture import Bench, Fixture
from slipctl.certify.rig import Rig
from slipctl.certify.specimen import Specimen
from slipctl.certify.trace import Trace


def _wander(specimen: Specimen, duration: float, mirrored: bool = False, friction: float = 0.8) -> Trace:
    """Drive a bend that tightens, opens and reverses, on speeds told to the servos."""
    rig = specimen.rig(friction).stand(rolling=(0.3, 0.0))
    hand = -1.0 if mirrored else 1.0

    def servo(rig: Rig, time: float) -> None:
        speed = 0.3 + 0.1 * math.sin(1.3 * time)
        rig.data.ctrl[:] = rig.rates(speed, hand * 0.8 * math.sin(1.1 * time))

    return rig.run(duration, servo)


def mirror(bench: Bench) -> tuple[float, float]:
    """Return the largest distance over 3 s between a drive and its mirror image; and none [µm]."""
    one, other = (_wander(bench.specimen, 3.0, mirrored) for mirrored in (False, True))
    gap = np.hypot(one.position[:, 0] - other.position[:, 0], one.position[:, 1] + other.position[:, 1])
    return 1e6 * float(gap.max()), 0.0


def _ends(bench: Bench) -> list[np.ndarray]:
    ends = []
    for share in (1.0, 0.5, 0.25):
        specimen = bench.specimen if share == 1.0 else Specimen(bench.path, bench.timestep * share)
        trace = _wander(specimen, 6.0)
        ends.append(trace.position[-1, :2] + specimen.timestep * trace.velocity[-1, :2])
    return ends


def _gaps(bench: Bench) -> tuple[float, float]:
    one, half, quarter = _ends(bench)
    return float(np.hypot(*(one - half))), float(np.hypot(*(half - quarter)))


def order(bench: Bench) -> tuple[float, float]:
    """Return the order at which an open-loop drive of 6 s converges in the timestep, and first order."""
    coarse, fine = _gaps(bench)
    return math.log2(coarse / fine), 1.0


def size(bench: Bench) -> tuple[float, float]:
    """Return the position error of that drive, extrapolated from half the timestep, and none [mm]."""
    coarse, _ = _gaps(bench)
    return 2e3 * coarse, 0.0


MIRROR = "left and right are not alike: a solver that stops early, or contacts that depend on their order"
STEP = "the timestep is too long for these contacts"

FIXTURES = (
    Fixture("mirror_symmetry", "µm", 1.0, False, "none", MIRROR, mirror),
    Fixture("timestep_order", "1", 0.3, False, "first order", STEP, order),
    Fixture("timestep_error", "mm", 2.0, False, "none", STEP, size),
)
