"""Which table class stands at which place of a file, and what its keys allow, in words."""

from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

from slipctl.scenario import controllers, expect, floor, references, slip, tables
from slipctl.scenario.base import Table, lookup
from slipctl.scenario.model import Scenario

Path = tuple[str | int, ...]


def _kinds(union: Any) -> dict[str, type[Table]]:
    """Table classes of a discriminated union by kind, in order."""
    classes = get_args(get_args(union)[0])
    return {get_args(member.model_fields["kind"].annotation)[0]: member for member in classes}


KINDS: dict[str, dict[str, type[Table]]] = {
    "plant": _kinds(tables.Plant),
    "slip": _kinds(slip.Slip),
    "reference": _kinds(references.Reference),
    "controller": _kinds(controllers.Controller),
    "ground.patch": _kinds(floor.Patch),
    "ground.terrain": _kinds(floor.Terrain),
    "expect": _kinds(expect.Claim),
}
"""The kinds of each table that has some, with their classes."""

ARRAYS: tuple[tuple[str, ...], ...] = (("ground", "patch"), ("ground", "change"), ("disturbance",))
"""The arrays of tables beside [[controller]], whose entries are known by their index instead of a label."""

_WITH_KINDS = ("controller", "ground.patch", "expect")


def kinds_at(path: Path) -> dict[str, type[Table]]:
    """Give the kinds that a table at `path` may have; empty where it has only one form."""
    name = generic(path)
    is_entry = bool(path) and isinstance(path[-1], int)
    return KINDS.get(name, {}) if is_entry == (name in _WITH_KINDS) else {}


def without_tags(location: Path) -> Path:
    """Pydantic's error location less the union tags that it puts between the keys."""
    path: list[str | int] = []
    tagged = False
    for step in location:
        kinds = kinds_at(tuple(path))
        if kinds and not tagged and step in kinds:
            tagged = True
            continue
        tagged = False
        path.append(step)
    return tuple(path)


def table_at(path: Path, raw: Any) -> type[Table] | None:
    """Class of the table at `path` of a file, or None where there is none (or its kind is unknown)."""
    table: type[Table] | None = Scenario
    for depth in range(1, len(path) + 1):
        kinds = kinds_at(path[:depth])
        if kinds:
            kind = lookup(raw, *path[:depth], "kind")
            table = kinds.get(kind) if isinstance(kind, str) else None
        elif table is not None and generic(path[:depth]) not in _WITH_KINDS:
            step = path[depth - 1]
            table = table if isinstance(step, int) else table_class(table.model_fields.get(step))
    return table


def table_class(field: FieldInfo | None) -> type[Table] | None:
    """Class of the table (or of an array's tables) that a key holds, None for none or several kinds."""
    annotation = None if field is None else field.annotation
    if get_origin(annotation) is tuple:
        annotation = get_args(annotation)[0]
    return annotation if isinstance(annotation, type) and issubclass(annotation, Table) else None


def is_number(field: FieldInfo) -> bool:
    """Whether a key holds a number (and can be swept)."""
    return _plain(field.annotation) in (float, int)


def _plain(annotation: Any) -> Any:
    """Annotation without Annotated and without `| None`."""
    if get_origin(annotation) is Annotated:
        return _plain(get_args(annotation)[0])
    if get_origin(annotation) in (Union, UnionType):
        rest = [member for member in get_args(annotation) if member is not NoneType]
        return _plain(rest[0]) if len(rest) == 1 else annotation
    return annotation


def choices(field: FieldInfo) -> tuple[str, ...]:
    """Give the words a key may have as its value; empty where it is not a choice."""
    plain = _plain(field.annotation)
    return get_args(plain) if get_origin(plain) is Literal else ()


def allowed(name: str, field: FieldInfo) -> str:
    """Tell what may stand at a key, in words."""
    plain = _plain(field.annotation)
    if name in KINDS and name != "expect":
        kinds = ", ".join(KINDS[name])
        return (
            f"one [[controller]] or more, kinds: {kinds}"
            if name == "controller"
            else f"a table, kinds: {kinds}"
        )
    if get_origin(plain) is tuple and name != "sweep":
        return "an array of tables"
    if name == "label":
        return "lower-case letters a-z, digits, _ and -"
    if name == "name":
        return "letters, digits, _, - and ., as it names the run folder"
    if choices(field):
        return ", ".join(f'"{word}"' for word in choices(field))
    if plain is bool:
        return "true or false"
    if plain is str:
        return "text"
    if plain in (float, int):
        return _number(field, "a whole number" if plain is int else "a number")
    if isinstance(plain, type) and issubclass(plain, Table):
        return f"a table with {', '.join(plain.model_fields)}"
    return "a table"


def unit_at(path: Path, raw: Any) -> str:
    """Give the unit of the number at a path, ``1`` where it has none."""
    table = table_at(path[:-1], raw)
    field = None if table is None else table.model_fields.get(str(path[-1]))
    extra = None if field is None else field.json_schema_extra
    return str(extra.get("unit", "1")) if isinstance(extra, dict) else "1"


def _number(field: FieldInfo, noun: str) -> str:
    signs = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
    limits = [
        f"{sign} {limit if abs(limit) < 1e6 else '2^63'}"
        for word, sign in signs.items()
        for limit in [next((getattr(entry, word) for entry in field.metadata if hasattr(entry, word)), None)]
        if limit is not None
    ]
    extra = field.json_schema_extra
    unit = extra.get("unit", "") if isinstance(extra, dict) else ""
    return f"{noun} {' and '.join(limits) or ''}".rstrip() + (f" [{unit}]" if unit else "")


def dotted(path: Path, raw: Any) -> str:
    """Write a path as it is shown: `controller[1:label].slip_bound`."""
    text = ""
    for depth, step in enumerate(path):
        if isinstance(step, int):
            entry = lookup(raw, *path[:depth], step)
            label = lookup(entry, "label")
            label = label if isinstance(label, str) and label else lookup(entry, "kind")
            text += f"[{step}:{label}]" if isinstance(label, str) else f"[{step}]"
        else:
            text += f".{step}" if text else step
    return text


def generic(path: Path) -> str:
    """Write a path without array indices: `controller.slip_bound`."""
    return ".".join(step for step in path if isinstance(step, str))
