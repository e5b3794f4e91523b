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


def entries(raw: Mapping[str, Any], *names: str) -> list[tuple[Path, Mapping[str, Any]]]:
    """Path and table of each entry of an array of tables that is a table."""
    listed = lookup(raw, *names)
    found = listed if isinstance(listed, list | tuple) else []
    return [((*names, index), entry) for index, entry in enumerate(found) if isinstance(entry, Mapping)]


def controllers(raw: Mapping[str, Any]) -> list[tuple[Path, str, Mapping[str, Any]]]:
    """Path, label and table of each listed controller that is a table."""
    tables = entries(raw, "controller")
    return [(path, str(entry.get("label", entry.get("kind", ""))), entry) for path, entry in tables]


def misses_multiple(value: float, unit: float) -> bool:
    """Whether a time is no whole multiple of another one, rounding aside."""
    count = value / unit
    return abs(count - round(count)) > 1e-9 * max(1.0, count)


def natural_duration(raw: Mapping[str, Any]) -> float | None:
    """Duration of the reference, None where it cannot be told."""
    table = table_at(("reference",), raw)
    if table is None:
        return None
    numbers = {
        name: value for name in table.model_fields if (value := value_at(raw, "reference", name)) is not None
    }
    try:
        return number(getattr(table.model_construct(None, **numbers), "natural_duration", None))
    except (AttributeError, TypeError, ZeroDivisionError, OverflowError):
        return None
