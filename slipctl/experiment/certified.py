"""Whether the model of a scenario is certified against closed forms, as the scenario steps it."""

from __future__ import annotations

import shlex
from typing import TYPE_CHECKING, Any

from slipctl.report.certificate import standing_line

if TYPE_CHECKING:
    from slipctl.scenario import Scenario

DEFAULT_TIMESTEP = 0.001
"""What `slipctl certify` takes where it is told none [s]."""


def standing(scenario: Scenario) -> dict[str, Any] | None:
    """Return what a manifest says of it; None for a plant without an engine.

    Parameters
    ----------
    scenario : Scenario
        One without a sweep, or one whose sweep does not touch the model or the timestep.

    Raises
    ------
    slipctl.plants.model.ModelError
        Where the model cannot be read.
    """
    plant = scenario.plant
    if plant.kind != "mujoco":
        return None
    from slipctl.certify import certificate
    from slipctl.experiment.assemble.robot import chosen_model

    found = certificate.standing(chosen_model(scenario), plant.timestep).json()
    return found | {"command": _command(scenario)}


def _command(scenario: Scenario) -> str:
    """Return the command that certifies just what the scenario simulates."""
    robot, timestep = scenario.robot, scenario.plant.timestep
    words = ["slipctl", "certify", shlex.quote(robot.model)]
    if timestep != DEFAULT_TIMESTEP:
        words += ["--timestep", f"{timestep:g}"]
    for name in ("left_wheel", "right_wheel", "caster_friction"):
        value = getattr(robot, name)
        if value is not None:
            words += [f"--{name.replace('_', '-')}", shlex.quote(str(value))]
    if robot.keep_contacts:
        words.append("--keep-contacts")
    return " ".join(words)


def missing(scenario: Scenario) -> list[str]:
    """Say of every model that the scenario simulates, and that is not certified, what is missing."""
    from slipctl.scenario import worlds

    grid = worlds(scenario)
    keys = [key for key in grid.keys if key.startswith("robot.") or key == "plant.timestep"]
    alike = {tuple(grid.varied(index)[key] for key in keys): index for index in range(len(grid))}
    said = {}
    for index in sorted(alike.values()):
        world = grid[index]
        found = standing(world.scenario)
        if found is not None and found["state"] != "passed":
            said[standing_line(found, world.scenario.robot.model)] = None
    return [line for line in said if line]
