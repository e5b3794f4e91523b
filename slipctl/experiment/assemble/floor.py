"""The ground of a batch and the pushes on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from slipctl.experiment.assemble.stack import World, gather
from slipctl.plants.patches import Change, Patch
from slipctl.plants.pushes import Push
from slipctl.plants.terrain import Terrain
from slipctl.tick import Array

if TYPE_CHECKING:
    from slipctl.plants.ground import Ground


def ground(worlds: Sequence[World]) -> Ground:
    """Return what the wheels of a batch stand on."""
    from slipctl.plants.ground import Ground

    def each(read: Callable[[Any], float | None]) -> Array:
        return gather(worlds, lambda s: _or_nan(read(s.ground)))

    first = worlds[0].scenario.ground
    return Ground(
        friction=np.stack([each(lambda g, i=i: g.wheel_friction[i]) for i in (0, 1)], axis=-1),
        film=each(lambda g: g.film),
        creep_stiffness=each(lambda g: g.creep_stiffness),
        slope=np.radians(each(lambda g: g.slope_deg)),
        downhill=np.radians(each(lambda g: g.downhill_deg)),
        patches=tuple(_patch(worlds, index) for index in range(len(first.patch))),
        terrain=terrain(worlds),
        changes=tuple(_change(worlds, index) for index in range(len(first.change))),
    )


def terrain(worlds: Sequence[World]) -> Terrain | None:
    """Return the unevenness of a batch's floor, None where it is level."""
    first = worlds[0].scenario.ground.terrain
    if first is None:
        return None

    def each(name: str) -> Array:
        return gather(worlds, lambda s: getattr(s.ground.terrain, name))

    if first.kind == "waves":
        return Terrain.waves(each("amplitude"), each("wavelength"), np.radians(each("heading_deg")))
    seeds = [getattr(world.scenario.ground.terrain, "seed", 0) for world in worlds]
    return Terrain.bumps(each("amplitude"), each("wavelength"), seeds)


def pushes(worlds: Sequence[World]) -> tuple[Push, ...]:
    """Return the pushes on a batch."""

    def push(index: int) -> Push:
        def each(name: str) -> Array:
            return gather(worlds, lambda s: getattr(s.disturbance[index], name))

        return Push(each("force"), _direction(each("heading_deg")), each("start"), each("duration"))

    return tuple(push(index) for index in range(len(worlds[0].scenario.disturbance)))


def _patch(worlds: Sequence[World], index: int) -> Patch:
    def each(*names: str) -> Array:
        columns = [
            gather(worlds, lambda s, n=name: _or_nan(getattr(s.ground.patch[index], n))) for name in names
        ]
        return columns[0] if len(columns) == 1 else np.stack(columns, axis=-1)

    kind = worlds[0].scenario.ground.patch[index].kind
    zero = np.zeros(len(worlds))
    count = each("count") if kind == "stripes" else zero
    sizes = {"rectangle": ("length", "width"), "disc": ("radius", "radius"), "stripes": ("period", "width")}
    return Patch(
        kind=kind,
        place=each("x", "y"),
        direction=_direction(zero if kind == "disc" else each("heading_deg")),
        size=each(*sizes[kind]),
        count=np.where(np.isnan(count), np.inf, count),
        friction=each("friction"),
        film=each("film"),
    )


def _change(worlds: Sequence[World], index: int) -> Change:
    def each(name: str) -> Array:
        return gather(worlds, lambda s: _or_nan(getattr(s.ground.change[index], name)))

    dry = worlds[0].scenario.ground.change[index].dry
    return Change(each("time"), each("friction"), each("film"), dry)


def _direction(heading_deg: Array) -> Array:
    angles = np.radians(heading_deg).tolist()
    return np.array([(math.cos(angle), math.sin(angle)) for angle in angles])


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value
