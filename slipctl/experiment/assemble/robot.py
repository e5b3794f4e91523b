"""The robot of a scenario, read off its compiled model."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from slipctl import scenario as files
from slipctl.shape import Shape
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import GRAVITY, WheelGeometry

if TYPE_CHECKING:
    from slipctl.plants.own import OwnModel


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
    notes : tuple of str
        What the user should know of a robot that was not written for slipctl.
    """

    inertia: Inertia
    model_id: str
    shapes: list[Shape]
    notes: tuple[str, ...] = ()

    @property
    def geometry(self) -> WheelGeometry:
        """Wheel radius and half track."""
        return self.inertia.geometry


def chosen_model(scenario: files.Scenario) -> str | OwnModel:
    """Return the shipped model's name, or the user's own file with what the scenario says of it."""
    from slipctl.plants.own import OwnModel

    robot = scenario.robot
    if not files.is_path(robot.model):
        return robot.model
    choice = (robot.left_wheel, robot.right_wheel, robot.keep_contacts, robot.caster_friction)
    return OwnModel(Path(robot.model), *choice)


def read_robot(scenario: files.Scenario) -> RobotModel:
    """Read the robot of a scenario; the ODE plants use its lengths, too.

    Raises
    ------
    slipctl.plants.model.ModelError
        Where the model cannot be used: a robot that does not turn as its wheels say is refused on MuJoCo.
    """
    from slipctl.plants import model, standstill

    path = model.find_model(chosen_model(scenario))
    compiled = model.compile_model(path)
    at_rest = standstill.settle(compiled)
    geometry = WheelGeometry(wheel_radius=at_rest.wheel_radius, half_track=at_rest.half_track)
    inertia = standstill.inertia(compiled, geometry)
    notes = () if isinstance(path, Path) else _noted(scenario, path)
    return RobotModel(inertia, model.model_id(path), model.shapes(compiled), notes)


def _noted(scenario: files.Scenario, own: OwnModel) -> tuple[str, ...]:
    """Return what is to be said of a robot that slipctl did not write.

    Raises
    ------
    slipctl.plants.errors.UnusableModel
        Where it cannot be driven on MuJoCo's floor.
    """
    from slipctl.plants.errors import UnusableModel
    from slipctl.plants.inspection import inspect

    seen = inspect(own)
    if scenario.plant.kind != "mujoco":
        return seen.notes
    if not seen.usable:
        raise UnusableModel(f"{own}: {'; '.join(seen.warnings)}")
    said = [*seen.notes, *seen.warnings]
    grip = (seen.mass or 0.0) * GRAVITY * (seen.wheel_radius or 0.0) / 2.0
    if scenario.robot.torque_limit > 4.0 * grip:
        said.append(
            f"robot.torque_limit is {scenario.robot.torque_limit:g} N·m; this robot's wheels slide at "
            f"{grip:.2g} N·m where friction is 1, so it may be meant to be smaller"
        )
    return tuple(said)


def paper_inertia(inertia: Inertia) -> Inertia:
    """Return the inertia without the wheels' own and without joint friction, which the paper neglects."""
    return replace(inertia, wheel_inertia=0.0, joint_friction=0.0)
