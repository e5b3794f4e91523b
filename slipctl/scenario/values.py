"""Numbers and controllers of raw tables, read with a file's defaults in place."""

from collections.abc import Mapping
from typing import Any

from slipctl.scenario.base import lookup, number
from slipctl.scenario.structure import Path, table_at


def value_at(raw: Any, *path: str | int) -> float | None:
    """Finite number at a path, its default where the file leaves it out, None where there is none."""
    value = lookup(raw, *path)
    if value is None:
        table = table_at(path[:-1], raw)
        field = None if table is None else table.model_fields.get(str(path[-1]))
        value = None if field is None or field.is_required() else field.default
    return number(value)


def has(raw: Any, *path: str | int) -> bool:
    """Whether a file gives the key at a path, whatever stands there."""
    entry = lookup(raw, *path[:-1])
    return isinstance(entry, Mapping) and path[-1] in entry


def controllers(raw: Mapping[str, Any]) -> list[tuple[Path, str, Mapping[str, Any]]]:
    """Path, label and table of each listed controller that is a table."""
    listed = lookup(raw, "controller")
    entries = listed if isinstance(listed, list | tuple) else []
    tables = [
        (("controller", index), entry) for index, entry in enumerate(entries) if isinstance(entry, Mapping)
    ]
    return [(path, str(entry.get("label", entry.get("kind", ""))), entry) for path, entry in tables]


def misses_multiple(value: float, unit: float) -> bool:
    """Whether a time is no whole multiple of another one, rounding aside."""
    count = value / unit
    return abs(count - round(count)) > 1e-9 * max(1.0, count)
