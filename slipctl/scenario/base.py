"""What every table of a scenario file shares: strictness, and how a key states its unit and limits."""

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


class Table(BaseModel):
    """A table of a scenario file: typed, frozen, no unknown keys, no text for numbers, no NaN or infinity."""

    model_config = ConfigDict(strict=True, frozen=True, extra="forbid", allow_inf_nan=False)


def quantity(description: str, unit: str = "", default: Any = ..., **limits: Any) -> Any:
    """Field of a table with its description and unit, which the JSON Schema and the messages show.

    Parameters
    ----------
    description
        What the key means, in the words of the field.
    unit
        SI unit, "1" for a dimensionless number, "" for what is no quantity.
    default
        Default value; without one the key is required.
    **limits
        Limits that pydantic knows: `gt`, `ge`, `lt`, `le`, `pattern`, `min_length`.
    """
    text = f"{description} [{unit}]" if unit else description
    return Field(default, description=text, json_schema_extra={"unit": unit} if unit else None, **limits)


def _array_to_tuple(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


AsTuple = BeforeValidator(_array_to_tuple)
"""A TOML array read into a tuple (a strict tuple would refuse a list)."""


def _true(value: Any) -> Any:
    return "true" if value is True else value


AsTrue = BeforeValidator(_true)
"""TOML's `true` read as the word "true", so that both spellings of the key mean the same."""


def number(value: Any) -> float | None:
    """Read a value as a finite float, or None where it is not a number (a bool is none)."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        result = float(value)
    except OverflowError:
        return None
    return result if abs(result) < float("inf") else None


def lookup(raw: Any, *path: str | int) -> Any:
    """Value at a path of tables and arrays, or None where the path does not lead anywhere."""
    for step in path:
        if isinstance(step, int):
            if not isinstance(raw, list | tuple) or step >= len(raw):
                return None
            raw = raw[step]
        else:
            if not isinstance(raw, Mapping):
                return None
            raw = raw.get(step)
    return raw
