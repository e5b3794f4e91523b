"""Plan and start of every world."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from slipctl.experiment.assemble.stack import World, gather, tick_count
from slipctl.theory import reference as plans
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.robot import GRAVITY
from slipctl.theory.time_scale import TimeScaled
from slipctl.tick import Array, Reference, Start


def references(worlds: Sequence[World]) -> Reference:
    """Return the reference of every row, arrays (T + 1, N, 2).

    Planned once for all worlds on one path. In memory x of all worlds comes before y, as laws read them.
    """
    first = worlds[0].scenario
    times = np.arange(tick_count(first) + 1, dtype=np.float64) * first.tick
    keys = [(world.scenario.reference.model_dump_json(), world.scenario.duration) for world in worlds]
    firsts = {key: index for index, key in reversed(list(enumerate(keys)))}
    places = {key: place for place, key in enumerate(firsts)}
    planned = _plan([worlds[index] for index in firsts.values()]).at(times)
    own = [places[key] for key in keys]

    def rows(array: Array) -> Array:
        array = np.moveaxis(array, 0, -1)
        if len(firsts) == 1:
            array = np.broadcast_to(np.ascontiguousarray(array), (*array.shape[:-1], len(worlds)))
        else:
            array = np.ascontiguousarray(array[..., own])
        return np.swapaxes(array, 1, -1)

    return planned.each(rows)


def _plan(worlds: Sequence[World]) -> plans.Plan:
    def each(read: Callable) -> Array:
        return gather(worlds, lambda scenario: read(scenario.reference))

    def pose(read: Callable) -> Array:
        ends = [read(world.scenario.reference) for world in worlds]
        rows = [(end.x, end.y, math.radians(end.heading_deg), end.speed) for end in ends]
        if ends[0].yaw_rate is None:
            return np.array(rows)
        return np.array([(*row, end.yaw_rate, end.acceleration) for row, end in zip(rows, ends, strict=True)])

    kind = worlds[0].scenario.reference.kind
    if kind == "point_to_point":
        zero = np.zeros(len(worlds))
        duration = each(lambda reference: reference.duration)
        path = plans.PointToPoint(
            start=pose(lambda reference: reference.start),
            goal=pose(lambda reference: reference.goal),
            duration=duration,
            placement=plans.Placement(zero, zero, zero),
        )
        first = worlds[0].scenario
        if getattr(first.reference, "time_scaling", False):
            return TimeScaled(path, duration, duration, first.tick)
        return path
    placement = plans.Placement(
        each(lambda reference: reference.x),
        each(lambda reference: reference.y),
        np.radians(each(lambda reference: reference.heading_deg)),
    )
    speed = each(lambda reference: reference.speed)
    if kind == "line":
        return plans.Line(speed, placement)
    if kind == "circle":
        return plans.Circle(speed, each(lambda reference: reference.radius), placement)
    return plans.FigureEight(each(lambda reference: reference.length), speed, placement)


def start(worlds: Sequence[World], planned: Reference) -> Start:
    """Return the start of every world: planned pose with the scenario's offsets, planned rates or rest.

    Parameters
    ----------
    worlds : sequence of World
    planned : Reference
        Rows of the plan, (T + 1, N, 2).
    """
    path = planned.path_time
    own = planned if path is None else path
    speed, heading, push, turn = flat_to_state(own.velocity[0], own.acceleration[0])
    path_speed = None
    if path is not None:
        # the path's own time stands still, so the robot does, too
        path_speed, still = speed, np.zeros_like(speed)
        speed, push, turn = still, still, still
    # at rest both rates are 0, and a law lifts the speed that it remembers to its floor
    moving = 1.0 - gather(worlds, lambda scenario: scenario.start.at_rest)
    offset = np.stack(
        [
            gather(worlds, lambda scenario: scenario.start.x_offset),
            gather(worlds, lambda scenario: scenario.start.y_offset),
        ],
        axis=-1,
    )
    heading = heading + np.radians(gather(worlds, lambda scenario: scenario.start.heading_offset_deg))
    slope = np.radians(gather(worlds, lambda scenario: scenario.ground.slope_deg))
    downhill = np.radians(gather(worlds, lambda scenario: scenario.ground.downhill_deg))
    uphill = -GRAVITY * np.sin(slope) * np.cos(heading - downhill)
    return Start(
        planned.position[0] + offset,
        heading,
        speed * moving,
        turn * moving,
        push * moving,
        path_speed,
        uphill,
    )
