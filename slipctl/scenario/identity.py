"""What identifies a scenario, and its full dump for the manifest."""

from hashlib import sha256
from json import dumps
from typing import Any

from pydantic import BaseModel

from slipctl.scenario.loading import sweep_table
from slipctl.scenario.model import Scenario


def dump(scenario: Scenario) -> dict[str, Any]:
    """Every key that plays a part, defaults included, as JSON-able tables that `read` accepts."""
    tables = scenario.model_dump(mode="json", exclude={"sweep"}, exclude_none=True)
    if scenario.plant.kind == "kinematic_ode":
        del tables["ground"], tables["robot"]["torque_limit"]
    elif scenario.ground.friction_left is not None:
        del tables["ground"]["friction"]
    if scenario.sweep:
        tables["sweep"] = sweep_table(scenario.sweep)
    return tables


def canonical(scenario: Scenario) -> str:
    """Write the scenario as JSON text that depends only on what it means.

    Left out are name and description, keys at their defaults (so that a key added later does not change the
    identity of scenarios without it) and tables that are then empty. Keys are sorted, numbers are floats
    however they were written. The sweep keeps its order, as that orders the worlds.
    """
    tables = _essential(scenario)
    tables = {name: value for name, value in tables.items() if name not in ("name", "description")}
    if scenario.duration == scenario.reference.natural_duration:
        tables.pop("duration", None)
    if scenario.sweep:
        tables["sweep"] = [list(entry) for entry in sweep_table(scenario.sweep).items()]
    return dumps(tables, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _essential(table: BaseModel) -> dict[str, Any]:
    result = {}
    for name, field in type(table).model_fields.items():
        value = getattr(table, name)
        is_default = not field.is_required() and value == field.default
        if name == "sweep" or is_default or (name == "label" and value == getattr(table, "kind", None)):
            continue
        result[name] = _plain(value)
    return result


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return _essential(value)
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return value + 0.0 if isinstance(value, float) else value  # −0.0 + 0.0 is 0.0


def scenario_id(scenario: Scenario) -> str:
    """Identity of a scenario: "sha256:" and the hash of its canonical text."""
    return "sha256:" + sha256(canonical(scenario).encode()).hexdigest()
