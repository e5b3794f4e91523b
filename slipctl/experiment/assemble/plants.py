"""The plant of a batch: robot, ground and prescribed slip."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipctl.experiment.assemble.robot import RobotModel, chosen_model, paper_inertia
from slipctl.experiment.assemble.stack import World, gather
from slipctl.simulate import Plant
from slipctl.theory.slip import NoSlip, ProportionalSlip, SeriesSlip, SinusoidalSlip, SlipLaw
from slipctl.tick import Array


def slip_law(worlds: Sequence[World]) -> SlipLaw | None:
    """Return the prescribed slip of a batch, or None."""
    if worlds[0].scenario.slip is None:
        return None

    def each(name: str) -> Array:
        return gather(worlds, lambda scenario: getattr(scenario.slip, name))

    if worlds[0].scenario.slip.kind == "series":
        series = worlds[0].scenario.slip.series  # a file's name cannot be swept: all worlds share it
        shape = (len(worlds), len(series.time))
        return SeriesSlip(
            series.time,
            np.broadcast_to(series.longitudinal, shape),
            np.broadcast_to(series.lateral, shape),
            np.broadcast_to(series.yaw, shape),
        )
    if worlds[0].scenario.slip.kind == "proportional":
        return ProportionalSlip(each("longitudinal"), each("lateral"), each("yaw"))
    return SinusoidalSlip(each("longitudinal"), each("lateral"), each("yaw"), each("period"))


def plant(worlds: Sequence[World], robot: RobotModel, threads: int) -> Plant:
    """Return the plant of a batch; `threads` counts for MuJoCo only."""
    arena = gather(worlds, lambda scenario: scenario.plant.arena)
    law = slip_law(worlds)
    first = worlds[0].scenario
    if first.plant.kind == "kinematic_ode":
        from slipctl.plants.ode import KinematicOde

        return KinematicOde(robot.geometry, law or NoSlip(len(worlds)), arena)
    if first.plant.kind == "dynamic_ode":
        from slipctl.plants.dynamic_ode import DynamicOde

        return DynamicOde(paper_inertia(robot.inertia), law or NoSlip(len(worlds)), arena)
    return _mujoco(worlds, law, robot, threads)


def _mujoco(worlds: Sequence[World], law: SlipLaw | None, robot: RobotModel, threads: int) -> Plant:
    from slipctl.experiment.assemble.floor import ground, pushes
    from slipctl.plants.mujoco import MujocoPlant

    first = worlds[0].scenario
    timestep = first.plant.timestep
    assert timestep is not None, "the file format gives MuJoCo a timestep"
    return MujocoPlant.build(
        model=chosen_model(first),
        ground=ground(worlds),
        slip_law=law,
        timestep=timestep,
        speed_drive=first.robot.drive == "wheel_speed",
        torque_limit=first.robot.torque_limit,
        wheel_rate_limit=first.robot.speed_limit / float(robot.geometry.wheel_radius),
        arena=gather(worlds, lambda scenario: scenario.plant.arena),
        threads=threads,
        pushes=pushes(worlds),
    )
