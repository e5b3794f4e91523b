"""Numbers of many worlds as arrays, and which worlds can be stacked."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from slipctl import scenario as files
from slipctl.tick import Array

World = files.World


def gather(worlds: Sequence[World], read: Callable[[files.Scenario], float]) -> Array:
    """Return one number of every world's scenario as an (N,) array."""
    return np.array([read(world.scenario) for world in worlds], dtype=float)


def tick_count(scenario: files.Scenario) -> int:
    """Return T = round(duration / tick); rows are 0 … T."""
    return round(scenario.duration / scenario.tick)


def batch_key(world: World) -> tuple:
    """Return what must be equal for worlds to share a batch: everything but stackable numbers."""
    s = world.scenario
    return (
        s.tick,
        tick_count(s),
        s.plant.kind,
        getattr(s.plant, "timestep", None),
        s.robot.model,
        (s.robot.left_wheel, s.robot.right_wheel, s.robot.keep_contacts, s.robot.caster_friction),
        s.robot.drive,
        getattr(s.robot, "torque_limit", None),
        getattr(s.robot, "compensate_wheels", None),
        s.robot.speed_limit if s.robot.drive == "wheel_torque" else None,
        None if s.slip is None else s.slip.kind,
        s.reference.kind,
        s.reference.kind == "point_to_point" and s.reference.start.yaw_rate is None,
        getattr(s.reference, "time_scaling", False),
        (s.sensing.pose, s.sensing.velocity, s.sensing.acceleration),
        tuple(
            (c.label, c.kind, getattr(c, "uncertainty", None), getattr(c, "time_scaled", None))
            for c in s.controller
        ),
    )
