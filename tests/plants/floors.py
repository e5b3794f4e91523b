"""Floors with patches and changes, and pushes, for the tests of the MuJoCo plant."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from slipctl.plants.patches import Change, Patch
from slipctl.plants.pushes import Push
from tests.plants.driving import full


def patch(
    kind: Literal["rectangle", "disc", "stripes"],
    size: tuple[float, float],
    friction: float,
    x: float = 0.0,
    y: float = 0.0,
    heading_deg: float = 0.0,
    count: float = math.inf,
    film: float = math.nan,
    worlds: int = 1,
) -> Patch:
    angle = math.radians(heading_deg)
    return Patch(
        kind=kind,
        place=np.tile([x, y], (worlds, 1)),
        direction=np.tile([math.cos(angle), math.sin(angle)], (worlds, 1)),
        size=np.tile(np.array(size, dtype=float), (worlds, 1)),
        count=full(worlds, count),
        friction=full(worlds, friction),
        film=full(worlds, film),
    )


def change(
    time: float, friction: float = math.nan, film: float = math.nan, dry: bool = False, worlds: int = 1
) -> Change:
    return Change(full(worlds, time), full(worlds, friction), full(worlds, film), dry)


def push(force: float, heading_deg: float, start: float, duration: float, worlds: int = 1) -> Push:
    angle = math.radians(heading_deg)
    return Push(
        force=full(worlds, force),
        direction=np.tile([math.cos(angle), math.sin(angle)], (worlds, 1)),
        start=full(worlds, start),
        duration=full(worlds, duration),
    )
