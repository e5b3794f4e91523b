"""Accelerations that friction alone decides, in both engines and in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.engine.compare import Track, in_bullet, in_mujoco
from tests.engine.drives import Drive, dash, grip_limit, locked, tightening
from tests.engine.robot import Robot


@dataclass(frozen=True)
class Fixture:
    """A drive, what is measured on it [m/s²], and what that should be (None: no closed form)."""

    name: str
    drive: Drive
    measure: Callable[[Track], float]
    closed_form: float | None


def _slide(drive: Drive) -> Callable[[Track], float]:
    # the pitching and rolling of the beginning has died down in the last third
    first, last = 2.0 / 3.0 * drive.duration, drive.duration
    return lambda track: float(np.hypot(*track.acceleration(first, last)))


def fixtures() -> list[Fixture]:
    """Return every fixture."""
    made = []
    slides = ((0.3, 0.0, 0.0), (0.3, 90.0, 0.0), (0.3, 45.0, 45.0), (0.7, 90.0, 0.0))
    for friction, direction, heading in slides:
        where = {0.0: "straight", 45.0: "at 45°, heading 45°", 90.0: "sideways"}[direction]
        drive = locked("", friction, direction, heading)
        name = f"locked wheels, {where}, μ {friction}"
        made.append(Fixture(name, drive, _slide(drive), grip_limit(friction)))
    hard = locked("", 0.7, 0.0)
    lifted = Fixture("locked wheels, straight, μ 0.7: the rear caster lifts", hard, _slide(hard), None)
    tight = tightening("", 0.3)
    # the start is left out, where the robot rolls into the curve
    limit = Fixture(
        "largest lateral acceleration, μ 0.3",
        tight,
        lambda track: track.after(1.0).steepest(),
        grip_limit(0.3),
    )
    pull = [
        Fixture(
            f"traction, {share:g} times the grip, μ 0.3",
            dash("", 0.3, share),
            lambda track: float(track.acceleration(0.3, 0.9)[0]),
            min(share, 1.0) * grip_limit(0.3),
        )
        for share in (0.5, 1.2, 2.0)
    ]
    return [*made, lifted, limit, *pull]


def measured(fixture: Fixture, robot: Robot) -> tuple[float, float]:
    """Return what MuJoCo and Bullet make of a fixture [m/s²]."""
    return fixture.measure(in_mujoco(fixture.drive)), fixture.measure(in_bullet(robot, fixture.drive))
