"""The robot of a scenario, read off its compiled model."""

from __future__ import annotations

from dataclasses import dataclass, replace

from slipctl import scenario as files
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Shape


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


def paper_inertia(inertia: Inertia) -> Inertia:
    """Return the inertia without the wheels' own and without joint friction, which the paper neglects."""
    return replace(inertia, wheel_inertia=0.0, joint_friction=0.0)
