"""Whether the model of a scenario is certified against closed forms, as the scenario steps it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipctl.report.certificate import standing_line

if TYPE_CHECKING:
    from slipctl.scenario import Scenario


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

    return certificate.standing(chosen_model(scenario), plant.timestep).json()


def missing(scenario: Scenario) -> list[str]:
    """Say of every model that the scenario simulates, and that is not certified, what is missing."""
    from slipctl.scenario import worlds

    said = {}
    for world in worlds(scenario):
        found = standing(world.scenario)
        if found is not None and found["state"] != "passed":
            said[standing_line(found, world.scenario.robot.model)] = None
    return [line for line in said if line]
