"""`where` of a claim: which worlds of a grid it is about."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import isclose
from typing import Any

from slipctl.scenario.axes import leaves, read_values
from slipctl.scenario.base import number
from slipctl.scenario.problems import Problem, show, unknown_keys

_ENDS = ("from", "to")
_FORMS = "a number, an array of numbers, or { from, to } of which one may be left out"
_CLOSE = 1e-9
"""Relative: swept values between the ends of a span are rounded to 12 digits."""

WHERE_SCHEMA = {
    "type": "object",
    "additionalProperties": {
        "anyOf": [
            {"type": "number"},
            {"type": "array", "items": {"type": "number"}, "minItems": 1, "uniqueItems": True},
            {
                "type": "object",
                "properties": {
                    "from": {"type": "number", "description": "Smallest value, itself included"},
                    "to": {"type": "number", "description": "Largest value, itself included"},
                },
                "additionalProperties": False,
            },
            {
                "type": "object",
                "description": "A table of the scenario, with the swept keys of it",
                "additionalProperties": {
                    "anyOf": [{"type": "number"}, {"type": "array"}, {"type": "object"}]
                },
            },
        ]
    },
}


@dataclass(frozen=True)
class Band:
    """All values from `first` to `last`, both included; None leaves that side open."""

    first: float | None
    last: float | None

    def __contains__(self, value: float) -> bool:
        above = self.first is None or value >= self.first or isclose(value, self.first, rel_tol=_CLOSE)
        below = self.last is None or value <= self.last or isclose(value, self.last, rel_tol=_CLOSE)
        return above and below

    def __str__(self) -> str:
        if self.first is None:
            return f"up to {self.last:g}"
        return f"{self.first:g} or more" if self.last is None else f"from {self.first:g} to {self.last:g}"


@dataclass(frozen=True)
class Condition:
    """One swept key and the values of it that a claim is about: those listed, or a band of them."""

    key: str
    values: tuple[float, ...] | Band

    def holds(self, value: float) -> bool:
        """Whether a swept value is among those meant."""
        if isinstance(self.values, Band):
            return value in self.values
        return any(isclose(value, listed, rel_tol=_CLOSE) for listed in self.values)

    def table(self) -> Any:
        """Give the values as the file does."""
        if isinstance(self.values, tuple):
            return self.values[0] if len(self.values) == 1 else list(self.values)
        ends = zip(_ENDS, (self.values.first, self.values.last), strict=True)
        return {name: value for name, value in ends if value is not None}

    def __str__(self) -> str:
        if isinstance(self.values, Band):
            return f"{self.key} is {self.values}"
        return f"{self.key} is {' or '.join(f'{value:g}' for value in self.values)}"


def where_table(conditions: tuple[Condition, ...]) -> dict[str, Any]:
    """Write conditions as a `where` table."""
    return {condition.key: condition.table() for condition in conditions}


def read_where(table: Any, place: str = "where") -> tuple[tuple[Condition, ...], list[Problem]]:
    """Read a `where` table, its keys dotted and quoted or nested in tables.

    Parameters
    ----------
    table
        The table, as TOML gives it.
    place
        Where it stands, for messages.

    Returns
    -------
    conditions, problems
        What could be read, in file order, and everything wrong with the rest. Whether a key is swept and
        its values occur is not looked at here.
    """
    if not isinstance(table, Mapping):
        return (), [Problem(place, show(table), "a table of swept keys")]
    conditions: dict[str, Condition] = {}
    problems: list[Problem] = []
    for key, value in leaves(table, _ENDS):
        if key in conditions:
            problems.append(Problem(f"{place}.{key}", "the key twice", "each key once"))
            continue
        values = _read(f"{place}.{key}", value, problems)
        if values is not None:
            conditions[key] = Condition(key, values)
    return tuple(conditions.values()), problems


def _read(place: str, value: Any, problems: list[Problem]) -> tuple[float, ...] | Band | None:
    if isinstance(value, list | tuple):
        return read_values(place, value, problems)
    if isinstance(value, Mapping):
        return _read_band(place, value, problems)
    single = number(value)
    if single is None:
        problems.append(Problem(place, show(value), _FORMS))
        return None
    return (single + 0.0,)


def _read_band(place: str, table: Mapping[str, Any], problems: list[Problem]) -> Band | None:
    if not table:
        problems.append(Problem(place, "an empty table", _FORMS))
        return None
    wrong = unknown_keys(place, table, _ENDS)
    ends = {name: number(table[name]) for name in _ENDS if name in table}
    wrong += [
        Problem(f"{place}.{name}", show(table[name]), "a finite number")
        for name, end in ends.items()
        if end is None
    ]
    first, last = ends.get("from"), ends.get("to")
    if first is not None and last is not None and first > last:
        wrong.append(Problem(f"{place}.to", f"{last:g}", f"a number ≥ from, {first:g}"))
    problems += wrong
    return None if wrong else Band(first, last)
