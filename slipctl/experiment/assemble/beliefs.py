"""What a controller believes about the robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from slipctl.control.believing import BelievingLaw
from slipctl.experiment.assemble.stack import World, gather
from slipctl.simulate import Controller
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array


def believes(worlds: Sequence[World], index: int) -> bool:
    """Return whether the `index`-th controller is told anything about the robot in any of the worlds."""
    return any(
        getattr(world.scenario.controller[index].believes, name) is not None
        for world in worlds
        for name in ("wheel_radius", "half_track", "mass", "yaw_inertia")
    )


def believed(worlds: Sequence[World], index: int, true: Inertia) -> Inertia:
    """Return what the `index`-th controller believes in every world: the truth where it is told nothing.

    Parameters
    ----------
    worlds : sequence of World
    index : int
    true : Inertia
        Of the robot. Wheel inertia and joint friction are always known as they are here.
    """
    if not believes(worlds, index):
        return true

    def each(name: str, truth: float | Array) -> Array:
        told = gather(
            worlds, lambda scenario: _or_unknown(getattr(scenario.controller[index].believes, name))
        )
        return np.where(np.isnan(told), truth, told)

    geometry = true.geometry
    return replace(
        true,
        geometry=WheelGeometry(
            each("wheel_radius", geometry.wheel_radius), each("half_track", geometry.half_track)
        ),
        mass=each("mass", true.mass),
        yaw_inertia=each("yaw_inertia", true.yaw_inertia),
    )


def _or_unknown(value: float | None) -> float:
    return math.nan if value is None else value


def misled(law: Controller, believed: WheelGeometry, true: WheelGeometry) -> Controller:
    """Return a law that meets the true robot; the law itself where it knows the robot's geometry."""
    return law if believed is true else BelievingLaw(law, believed, true)


def radius_ratio(believed: WheelGeometry, true: WheelGeometry) -> float | Array:
    """Return the believed wheel radius in shares of the true one."""
    return believed.wheel_radius / true.wheel_radius
