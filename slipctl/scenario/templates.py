"""A commented scenario file to start from."""

import re
from collections.abc import Iterator, Mapping
from json import dumps
from typing import Any

from slipctl.scenario.applies import ignored
from slipctl.scenario.base import Table, lookup
from slipctl.scenario.identity import dump
from slipctl.scenario.loading import load, sweep_table
from slipctl.scenario.model import NAME_PATTERN, Scenario
from slipctl.scenario.problems import Problem, ScenarioError, quote
from slipctl.scenario.structure import ARRAYS, KINDS, Path, allowed, choices, table_at
from slipctl.scenario.where import where_table


def template(like: str, name: str) -> str:
    """Write a scenario file to start from: another scenario with every key explained.

    Parameters
    ----------
    like
        The scenario to start from, as `load` takes it.
    name
        Name of the new scenario.

    Returns
    -------
    str
        A valid TOML file that means the same as `like`. Keys at their defaults stand in it as comments.

    Raises
    ------
    ScenarioError
        If there is no scenario `like`, or the name cannot be one.
    """
    if not re.fullmatch(NAME_PATTERN, name):
        valid = allowed("name", Scenario.model_fields["name"])
        raise ScenarioError(name, [Problem("name", quote(name), valid)])
    scenario = load(like)
    applies = dump(scenario)
    given = scenario.model_fields_set
    skip = ("name", "description") if "duration" in given else ("name", "description", "duration")
    lines = [
        f"# A scenario of slipctl, made from {scenario.name}. SI and radians, except keys that end in _deg.",
        "# Lines that begin with # and hold a value are keys at their defaults. Run it: slipctl run FILE",
        "",
        f"name = {quote(name)}",
        f"description = {quote(scenario.description)}",
        *_keys((), scenario, applies, skip),
    ]
    for section in ("robot", "plant", "ground", "slip", "reference", "start", "sensing"):
        table = getattr(scenario, section)
        if table is not None and section in applies:
            lines += _section((section,), "" if section in given else "# ", table, applies)
        for path in ARRAYS:
            listed = path[-1] if path[0] == section == "ground" else None
            if listed is not None and section in applies:
                lines += _array(path, getattr(table, listed), applies)
    if ("disturbance",) not in ignored(applies):
        lines += _array(("disturbance",), scenario.disturbance, applies)
    for index, entry in enumerate(scenario.controller):
        lines += _section(("controller", index), "", entry, applies)
    if scenario.sweep:
        lines += _head("sweep", "[sweep]")
        lines += [f"{quote(key)} = {_value(value)}" for key, value in sweep_table(scenario.sweep).items()]
    lines += _array(("expect",), scenario.expect, applies)
    return "\n".join(lines) + "\n"


def _head(section: str, head: str) -> list[str]:
    return ["", f"# {Scenario.model_fields[section].description}.", head]


def _section(path: Path, mark: str, table: Table, applies: Mapping[str, Any]) -> Iterator[str]:
    section = str(path[0])
    yield from _head(section, mark + (f"[[{section}]]" if len(path) == 2 else f"[{section}]"))
    yield from _keys(path, table, applies)


def _array(path: tuple[str, ...], listed: tuple[Table, ...], applies: Mapping[str, Any]) -> Iterator[str]:
    """Lines of an array of tables; one that is empty is told of in a comment."""
    name = ".".join(path)
    owner = table_at(path[:-1], applies) or Scenario
    text = f"# {owner.model_fields[path[-1]].description}"
    if not listed:
        kinds = f", kinds: {', '.join(KINDS[name])}" if name in KINDS else ""
        yield from ("", f"{text}{kinds}: [[{name}]]")
    for index, entry in enumerate(listed):
        yield from ("", f"{text}.", f"[[{name}]]")
        yield from _keys((*path, index), entry, applies)


def _keys(path: Path, table: Table, applies: Mapping[str, Any], skip: tuple[str, ...] = ()) -> Iterator[str]:
    """Lines of a table's own keys, its kind first, those left at their defaults as comments."""
    fields, without = type(table).model_fields, ignored(applies)
    for name in sorted(fields, key=lambda name: name != "kind"):
        value, field = getattr(table, name), fields[name]
        value = (where_table(value) or None) if name == "where" else value
        is_section = isinstance(value, tuple) or (isinstance(table, Scenario) and isinstance(value, Table))
        if name in skip or is_section or (isinstance(table, Scenario) and value is None):
            continue
        words = choices(field)
        text = f"{field.description}: {', '.join(words)}" if len(words) > 1 else field.description
        if (*path, name) in without:
            continue
        if isinstance(value, Table) and not value.model_fields_set:
            inner = type(value).model_fields
            used = ", ".join(key for key in inner if (*path, name, key) not in without)
            yield f"# {name}: {text}: {{ {used} }}"
        elif value is None:
            yield f"# {name}: {text}"
        elif name in lookup(applies, *path):
            mark = "" if name in table.model_fields_set else "# "
            yield f"{mark}{name} = {_value(_plain(value))}  # {text}"


def _plain(value: Any) -> Any:
    return value.model_dump(exclude_unset=True) if isinstance(value, Table) else value


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quote(key)


def _value(value: Any) -> str:
    """Spell a value in TOML."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {_value(entry)}" for key, entry in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, str):
        return dumps(value, ensure_ascii=False)
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)
