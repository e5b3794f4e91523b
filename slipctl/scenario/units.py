"""The unit of a key, for tables that have it as a column."""

from slipctl.scenario.identity import dump
from slipctl.scenario.model import Scenario
from slipctl.scenario.structure import unit_at


def key_unit(scenario: Scenario, key: str) -> str:
    """Give the unit of a dotted key of a scenario, ``1`` where the key has none.

    Parameters
    ----------
    scenario
        Decides which law a label means.
    key
        As in `[sweep]`, such as ``controller.robust_kinematic.pole``.
    """
    steps = [int(step) if step.isdigit() else step for step in key.split(".")]
    if steps[0] == "controller" and len(steps) > 1:
        labels = [law.label for law in scenario.controller]
        steps[1] = labels.index(str(steps[1])) if steps[1] in labels else 0
    return unit_at(tuple(steps), dump(scenario))
