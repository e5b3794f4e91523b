"""From the worlds of a scenario to the objects of one batch: plan, start, plant and laws.

The only place that knows both the file format and the implementations.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slipctl import scenario as files
from slipctl.control.drive import DriveLimits
from slipctl.control.nominal_kinematic import NominalKinematic
from slipctl.control.robust_kinematic import RobustKinematic
from slipctl.guarantee import Hypotheses
from slipctl.simulate import Controller, Plant
from slipctl.theory import reference as plans
from slipctl.theory.dynamic import Inertia
from slipctl.theory.flatness import flat_to_state
from slipctl.theory.robot import WheelGeometry
from slipctl.theory.robust import UNCERTAINTIES, chain_gains, lyapunov_matrix
from slipctl.theory.slip import NoSlip, ProportionalSlip, SinusoidalSlip, SlipLaw
from slipctl.tick import Array, Reference, Shape, Start

World = files.World


@dataclass(frozen=True)
class Law:
    """A controller for one batch and what its theorem assumes.

    Attributes
    ----------
    controller : Controller
    hypotheses : Hypotheses or None
        None for a law without a theorem.
    """

    controller: Controller
    hypotheses: Hypotheses | None


@dataclass(frozen=True)
class RobotModel:
    """What the compiled model says about the robot.

    Attributes
    ----------
    inertia : Inertia
        Lengths, mass and inertias.
    model_id : str
        ``sha256:…`` of the compiled base model.
    shapes : list of Shape
        What a viewer draws.
    """

    inertia: Inertia
    model_id: str
    shapes: list[Shape]

    @property
    def geometry(self) -> WheelGeometry:
        """Wheel radius and half track."""
        return self.inertia.geometry


def read_robot(scenario: files.Scenario) -> RobotModel:
    """Read the robot of a scenario; the ODE plants use its lengths, too.

    Raises
    ------
    slipctl.plants.model.ModelError
        Where the model cannot be used.
    """
    from slipctl.plants import model, standstill

    path = model.find_model(scenario.robot.model)
    compiled = model.compile_model(path)
    at_rest = standstill.settle(compiled)
    geometry = WheelGeometry(wheel_radius=at_rest.wheel_radius, half_track=at_rest.half_track)
    inertia = standstill.inertia(compiled, geometry)
    return RobotModel(inertia, model.model_id(path), model.shapes(compiled))


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
        s.robot.drive,
        s.robot.torque_limit,
        None if s.slip is None else s.slip.kind,
        s.reference.kind,
        tuple((c.label, c.kind, getattr(c, "uncertainty", None)) for c in s.controller),
    )


def references(worlds: Sequence[World]) -> Reference:
    """Return the reference of every row, arrays (T + 1, N, 2)."""
    first = worlds[0].scenario
    times = np.arange(tick_count(first) + 1, dtype=np.float64) * first.tick
    planned = _plan(worlds).at(times)

    def by_row(vector: Array) -> Array:
        return np.ascontiguousarray(np.swapaxes(vector, 0, 1))

    return Reference(
        by_row(planned.position), by_row(planned.velocity), by_row(planned.acceleration), by_row(planned.jerk)
    )


def _plan(worlds: Sequence[World]) -> plans.Plan:
    def each(read: Callable) -> Array:
        return gather(worlds, lambda scenario: read(scenario.reference))

    def pose(read: Callable) -> Array:
        return np.array(
            [
                (end.x, end.y, math.radians(end.heading_deg), end.speed)
                for end in (read(world.scenario.reference) for world in worlds)
            ]
        )

    kind = worlds[0].scenario.reference.kind
    if kind == "point_to_point":
        zero = np.zeros(len(worlds))
        return plans.PointToPoint(
            start=pose(lambda reference: reference.start),
            goal=pose(lambda reference: reference.goal),
            duration=each(lambda reference: reference.duration),
            placement=plans.Placement(zero, zero, zero),
        )
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
    speed, heading, push, turn = flat_to_state(planned.velocity[0], planned.acceleration[0])
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
    return Start(planned.position[0] + offset, heading, speed * moving, turn * moving, push * moving)


def slip_law(worlds: Sequence[World]) -> SlipLaw | None:
    """Return the prescribed slip of a batch, or None."""
    if worlds[0].scenario.slip is None:
        return None

    def each(name: str) -> Array:
        return gather(worlds, lambda scenario: getattr(scenario.slip, name))

    if worlds[0].scenario.slip.kind == "proportional":
        return ProportionalSlip(each("longitudinal"), each("lateral"), each("yaw"))
    return SinusoidalSlip(each("longitudinal"), each("lateral"), each("yaw"), each("period"))


def plant(worlds: Sequence[World], geometry: WheelGeometry, threads: int) -> Plant:
    """Return the plant of a batch; `threads` counts for MuJoCo only."""
    arena = gather(worlds, lambda scenario: scenario.plant.arena)
    law = slip_law(worlds)
    first = worlds[0].scenario
    if first.plant.kind == "kinematic_ode":
        from slipctl.plants.ode import KinematicOde

        return KinematicOde(geometry, law or NoSlip(len(worlds)), arena)
    from slipctl.plants.ground import Ground
    from slipctl.plants.mujoco import MujocoPlant

    def absent(value: float | None) -> float:
        return math.nan if value is None else value

    ground = Ground(
        friction=np.stack(
            [
                gather(worlds, lambda s: s.ground.wheel_friction[0]),
                gather(worlds, lambda s: s.ground.wheel_friction[1]),
            ],
            axis=-1,
        ),
        film=gather(worlds, lambda s: absent(s.ground.film)),
        creep_stiffness=gather(worlds, lambda s: absent(s.ground.creep_stiffness)),
        slope=np.radians(gather(worlds, lambda s: s.ground.slope_deg)),
        downhill=np.radians(gather(worlds, lambda s: s.ground.downhill_deg)),
    )
    return MujocoPlant.build(
        model=first.robot.model,
        ground=ground,
        slip_law=law,
        timestep=first.plant.timestep,
        torque_limit=first.robot.torque_limit,
        arena=arena,
        threads=threads,
    )


def law(worlds: Sequence[World], index: int, geometry: WheelGeometry) -> Law:
    """Return the `index`-th listed controller for a batch."""

    def each(name: str) -> Array:
        return gather(worlds, lambda scenario: getattr(scenario.controller[index], name))

    drive = DriveLimits(
        geometry=geometry,
        speed_limit=gather(worlds, lambda scenario: scenario.robot.speed_limit),
        yaw_rate_limit=gather(worlds, lambda scenario: scenario.robot.yaw_rate_limit),
        speed_floor=each("speed_floor"),
    )
    first = worlds[0].scenario.controller[index]
    gains = chain_gains(each("pole"), 2)
    if first.kind == "nominal_kinematic":
        return Law(NominalKinematic(drive, gains), None)
    slip_bound = each("slip_bound")
    controller = RobustKinematic(
        drive=drive,
        gains=gains,
        weights=np.stack([lyapunov_matrix(row)[:, 1] for row in gains]),
        slip_bound=slip_bound,
        boundary_layer=each("boundary_layer"),
        bound=UNCERTAINTIES[first.uncertainty].bound,
    )
    return Law(controller, Hypotheses(slip_bound, drive.speed_floor, first.uncertainty))
