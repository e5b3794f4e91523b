"""What identifies a scenario, and its full dump for the manifest."""

from hashlib import sha256
from json import dumps
from typing import Any

from pydantic import BaseModel

from slipctl.scenario.applies import ignored
from slipctl.scenario.base import lookup
from slipctl.scenario.loading import sweep_table
from slipctl.scenario.model import Scenario
from slipctl.scenario.own_robot import content, is_path
from slipctl.scenario.slip import SeriesSlip
from slipctl.scenario.structure import ARRAYS
from slipctl.scenario.tables import Robot


def dump(scenario: Scenario) -> dict[str, Any]:
    """Every key that plays a part, defaults included, as JSON-able tables that `read` accepts."""
    tables = scenario.model_dump(mode="json", exclude={"sweep"}, exclude_none=True)
    for path in ignored(tables):
        parent = lookup(tables, *path[:-1])
        if parent is not None:
            parent.pop(path[-1], None)
    if scenario.ground.friction_left is not None and "ground" in tables:
        del tables["ground"]["friction"]
    for path in ARRAYS:
        parent = lookup(tables, *path[:-1]) or {}
        if not parent.get(path[-1], True):
            del parent[path[-1]]
    if not scenario.expect:
        del tables["expect"]
    for law in tables["controller"]:
        if not law["believes"]:
            del law["believes"]
    if scenario.sweep:
        tables["sweep"] = sweep_table(scenario.sweep)
    return tables


def canonical(scenario: Scenario) -> str:
    """Write the scenario as JSON text that depends only on what it means.

    Left out are name, description and claims, keys at their defaults (so that a key added later does not
    change the identity of scenarios without it) and tables that are then empty. A series of slip and a model
    by its path count by their content. Keys are sorted, numbers are floats however they were written. The
    sweep keeps its order, as that orders the worlds.
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
        if name in ("sweep", "expect") or is_default or _is_as_left_out(table, name, value):
            continue
        result[name] = _plain(value)
    if isinstance(table, Robot) and is_path(table.model):
        result["model"] = content(table.model)
    if isinstance(table, SeriesSlip):
        del result["file"]
        result["content"] = table.series.content
    return result


def _is_as_left_out(table: BaseModel, name: str, value: Any) -> bool:
    """Whether a value is what the rest of the scenario makes of the key where it is left out."""
    # `time_scaled = true` may stand only where the reference has time_scaling, whose default it is
    return (name == "label" and value == getattr(table, "kind", None)) or (name == "time_scaled" and value)


def _plain(value: Any) -> Any:
    if isinstance(value, BaseModel):
        return _essential(value)
    if isinstance(value, tuple):
        return [_plain(entry) for entry in value]
    return value + 0.0 if isinstance(value, float) else value  # −0.0 + 0.0 is 0.0


def scenario_id(scenario: Scenario) -> str:
    """Identity of a scenario: "sha256:" and the hash of its canonical text."""
    return "sha256:" + sha256(canonical(scenario).encode()).hexdigest()
