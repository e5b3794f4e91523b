"""What pydantic finds wrong with the single keys of a file, said as problems."""

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from slipctl.scenario.base import Table, lookup
from slipctl.scenario.later import later_value
from slipctl.scenario.model import Scenario
from slipctl.scenario.problems import Problem, later, nearest, quote, show
from slipctl.scenario.structure import (
    KINDS,
    Path,
    allowed,
    choices,
    dotted,
    generic,
    kinds_at,
    table_at,
    table_class,
    without_tags,
)

_MISSING = "nothing (the key is missing)"


def field_problems(error: ValidationError, raw: Mapping[str, Any]) -> list[Problem]:
    """Problems of the single keys; those of `[sweep]` and `where` are left to their readers."""
    problems = []
    for entry in error.errors(include_url=False, include_context=False):
        path = without_tags(entry["loc"])
        # An array counts as too short when every entry of it is wrong; then the entries say so themselves.
        echo = entry["type"] == "too_short" and lookup(raw, *path)
        by_rules = path[:1] == ("sweep",) or (path[:1] == ("expect",) and path[2:3] == ("where",))
        if not by_rules and not echo:
            problems.append(_problem(entry["type"], path, raw))
    return problems


def _problem(kind: str, path: Path, raw: Mapping[str, Any]) -> Problem:
    if kind == "extra_forbidden":
        return _extra(path, raw)
    value = lookup(raw, *path)
    if kind == "union_tag_not_found" and isinstance(value, Mapping):
        return Problem(dotted((*path, "kind"), raw), _MISSING, ", ".join(kinds_at(path)))
    if kind == "union_tag_invalid" and isinstance(value, Mapping):
        return _choice((*path, "kind"), value["kind"], tuple(kinds_at(path)), raw)
    if kinds_at(path):
        found = _MISSING if kind == "missing" else show(value)
        return Problem(dotted(path, raw), found, f"a table, kinds: {', '.join(kinds_at(path))}")
    parent, name = table_at(path[:-1], raw), str(path[-1])
    field = None if parent is None else parent.model_fields.get(name)
    if field is None:
        return Problem(dotted(path, raw), show(value), "another value")
    found = _MISSING if kind == "missing" else show(value)
    if kind == "literal_error":
        return _choice(path, value, choices(field), raw)
    if kind == "tuple_type":
        return Problem(
            dotted(path, raw), found, f"an array: write [[{generic(path)}]], not [{generic(path)}]"
        )
    return Problem(dotted(path, raw), found, allowed(name, field))


def _choice(path: Path, value: Any, valid: tuple[str, ...], raw: Any) -> Problem:
    key = dotted(path, raw)
    if later_value(generic(path), value):
        return later(key, quote(value), valid)
    hint = nearest(value, valid) if isinstance(value, str) else None
    return Problem(key, show(value), ", ".join(f'"{word}"' for word in valid), hint)


def _extra(path: Path, raw: Any) -> Problem:
    key, name = dotted(path, raw), str(path[-1])
    table = table_at(path[:-1], raw)
    valid = tuple(Scenario.model_fields if table is None else table.model_fields)
    owners = [kind for kind, member in kinds_at(path[:-1]).items() if name in member.model_fields]
    if owners:
        own = lookup(raw, *path[:-1], "kind")
        return Problem(key, f"a key of {' and '.join(owners)}, which {own} would ignore", ", ".join(valid))
    # Of equally near names the one that the table does not have yet is meant.
    given = lookup(raw, *path[:-1]) or ()
    likely = sorted(valid, key=lambda other: other in given)
    hint = nearest(name, likely) or _inside(table, name) or _elsewhere(name)
    return Problem(key, "an unknown key", ", ".join(valid), hint)


def _inside(table: type[Table] | None, name: str) -> str | None:
    """Which table inside a table has a key of this very name."""
    for inner, field in (table.model_fields if table else {}).items():
        member = table_class(field)
        if member is not None and name in member.model_fields:
            return f"{inner}.{name}"
    return None


def _elsewhere(name: str) -> str | None:
    """Where else in a file a key of this very name may stand."""
    for section in Scenario.model_fields:
        members = list(KINDS.get(section, {}).values())
        table = table_at((section,), {})
        for member in [*members, *([table] if table else [])]:
            if section != "sweep" and name in member.model_fields and table is not Scenario:
                return f"{section}.{name}"
            for inner in member.model_fields:
                deeper = table_at((section, inner), {section: {"kind": _kind_of(section, member)}})
                if deeper is not None and deeper is not member and name in deeper.model_fields:
                    return f"{section}.{inner}.{name}"
    return None


def _kind_of(section: str, member: Any) -> str | None:
    return next((kind for kind, other in KINDS.get(section, {}).items() if other is member), None)
