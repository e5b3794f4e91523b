"""A whole scenario: the tables of a file put together."""

from typing import Annotated, Any, Self

from pydantic import BeforeValidator, InstanceOf, WithJsonSchema, model_validator

from slipctl.scenario.axes import AXES_SCHEMA, Axis, read_axes
from slipctl.scenario.base import AsTuple, Table, quantity
from slipctl.scenario.controllers import Controller
from slipctl.scenario.expect import Claim
from slipctl.scenario.floor import Disturbance
from slipctl.scenario.references import Reference
from slipctl.scenario.sensing import Sensing
from slipctl.scenario.slip import Slip
from slipctl.scenario.tables import Ground, Plant, Robot, Start

NAME_PATTERN = r"^[A-Za-z0-9_][A-Za-z0-9_.-]*$"


def _axes(value: Any) -> Any:
    """Read the `[sweep]` table; its problems are reported, with all others, by the loader."""
    if isinstance(value, tuple):
        return value
    axes, problems = read_axes(value)
    if problems:
        raise ValueError("; ".join(str(problem) for problem in problems))
    return axes


class Scenario(Table):
    """One scenario: what is simulated, followed and compared.

    Made by `load` and `read`, which also hold the rules that span several tables. Optional tables that
    the file leaves out stand with their defaults, except `slip`, which is None.
    """

    name: str = quantity(
        "Name of the scenario and of its run folder; default: the file's name",
        "",
        "scenario",
        pattern=NAME_PATTERN,
    )
    description: str = quantity("One sentence for people", "", "")
    seed: int = quantity("Seed of everything random", "", 0, ge=0, lt=2**63)
    tick: float = quantity("Control period", "s", gt=0)
    duration: float = quantity("Simulated time; default: the reference's", "s", 0.0, gt=0)
    robot: Robot = quantity("The robot")
    plant: Plant = quantity("What simulates the robot")
    ground: Ground = quantity("The floor (MuJoCo)", "", Ground())
    slip: Slip | None = quantity("Prescribed slip (none unless given)", "", None)
    reference: Reference = quantity("The path to follow")
    start: Start = quantity("How the start differs from the planned one", "", Start())
    sensing: Sensing = quantity("What the controller gets to see", "", Sensing())
    disturbance: Annotated[tuple[Disturbance, ...], AsTuple] = quantity("Pushes on the robot", "", ())
    controller: Annotated[tuple[Controller, ...], AsTuple] = quantity(
        "The control laws to compare", min_length=1
    )
    sweep: Annotated[tuple[InstanceOf[Axis], ...], BeforeValidator(_axes), WithJsonSchema(AXES_SCHEMA)] = (
        quantity("Keys to vary: dotted key = values; several keys make a grid, the first one slowest", "", ())
    )
    expect: Annotated[tuple[Claim, ...], AsTuple] = quantity(
        "What is claimed of the runs; slipctl check judges it", "", ()
    )

    @model_validator(mode="after")
    def _duration_defaults_to_the_reference(self) -> Self:
        if not self.duration:
            object.__setattr__(self, "duration", self.reference.natural_duration)
        return self

    @model_validator(mode="after")
    def _laws_follow_the_reference_s_time(self) -> Self:
        for law in self.controller:
            if getattr(self.reference, "time_scaling", False) and getattr(law, "time_scaled", True) is None:
                object.__setattr__(law, "time_scaled", True)
        return self

    @property
    def ticks(self) -> int:
        """Number of control ticks N; a run has the rows 0…N."""
        return round(self.duration / self.tick)
