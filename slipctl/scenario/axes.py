"""`[sweep]`: which keys vary over which values."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from slipctl.scenario.base import number
from slipctl.scenario.problems import Problem, nearest, show, unknown_keys

_SPAN_KEYS = ("from", "to", "count", "scale")
_SCALES = ("linear", "log")
_FORMS = "an array of numbers, or { from, to, count, scale }"

AXES_SCHEMA = {
    "type": "object",
    "additionalProperties": {
        "anyOf": [
            {"type": "array", "items": {"type": "number"}, "minItems": 1, "uniqueItems": True},
            {
                "type": "object",
                "properties": {
                    "from": {"type": "number", "description": "First value"},
                    "to": {"type": "number", "description": "Last value"},
                    "count": {"type": "integer", "minimum": 2, "description": "Number of values"},
                    "scale": {"enum": list(_SCALES), "default": "linear", "description": "Spacing"},
                },
                "required": ["from", "to", "count"],
                "additionalProperties": False,
            },
            {
                "type": "object",
                "description": "A table of the scenario, with the keys of it to vary",
                "additionalProperties": {"anyOf": [{"type": "array"}, {"type": "object"}]},
            },
        ]
    },
}


@dataclass(frozen=True)
class Span:
    """`count` values from `first` to `last`, evenly spaced in the value or (`log`) in its logarithm."""

    first: float
    last: float
    count: int
    scale: str = "linear"

    def __len__(self) -> int:
        return self.count

    def table(self) -> dict[str, float | int | str]:
        """Give the span as the file does; the linear scale, the default, is left out."""
        span: dict[str, float | int | str] = {"from": self.first, "to": self.last, "count": self.count}
        return span if self.scale == "linear" else {**span, "scale": self.scale}

    def __iter__(self) -> Iterator[float]:
        """Go through the values, both ends exact, those between to 12 significant digits.

        Rounding keeps names short and the values the same on every machine's mathematical library.
        """
        yield self.first
        for index in range(1, self.count - 1):
            part = index / (self.count - 1)
            if self.scale == "log":
                value = self.first * (self.last / self.first) ** part
            else:
                value = self.first + (self.last - self.first) * part
            yield float(f"{value:.12g}")
        yield self.last


@dataclass(frozen=True)
class Axis:
    """One swept key with its values: a tuple as listed, or a span."""

    key: str
    values: tuple[float, ...] | Span

    def __len__(self) -> int:
        return len(self.values)

    def __iter__(self) -> Iterator[float | int]:
        """Go through the values; those of the seed are whole numbers."""
        for value in self.values:
            yield int(value) if self.key == "seed" and value == int(value) else value


def read_axes(table: Any) -> tuple[tuple[Axis, ...], list[Problem]]:
    """Read a `[sweep]` table, its keys dotted and quoted or nested in tables.

    Returns
    -------
    axes, problems
        What could be read, in file order, and everything wrong with the rest. Whether a key exists in the
        scenario is not looked at here.
    """
    if not isinstance(table, Mapping):
        return (), [Problem("sweep", show(table), "a table of dotted keys")]
    axes: dict[str, Axis] = {}
    problems: list[Problem] = []
    for key, value in leaves(table, _SPAN_KEYS):
        if key in axes:
            problems.append(Problem(f"sweep.{key}", "the key twice", "each key once"))
            continue
        values = (
            _read_span(key, value, problems)
            if isinstance(value, Mapping)
            else read_values(f"sweep.{key}", value, problems, _FORMS)
        )
        if values is not None:
            axes[key] = Axis(key, values)
    return tuple(axes.values()), problems


def swept_keys(table: Any) -> list[str]:
    """Dotted keys of a `[sweep]` table in file order, whether their values can be read or not."""
    return [key for key, _ in leaves(table, _SPAN_KEYS)] if isinstance(table, Mapping) else []


def leaves(table: Mapping[str, Any], words: tuple[str, ...], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Go through the dotted keys of a nested table and their values.

    A table that has one of `words` as a key of its own, or no key at all, is a value.
    """
    for name, value in table.items():
        key = f"{prefix}{name}"
        is_value = not isinstance(value, Mapping) or not value
        if is_value or any(word in value and not isinstance(value[word], Mapping) for word in words):
            yield key, value
        else:
            yield from leaves(value, words, f"{key}.")


def read_values(
    where: str, value: Any, problems: list[Problem], forms: str = "an array of numbers"
) -> tuple[float, ...] | None:
    """Read an array of different finite numbers; what is wrong with it joins `problems`, and None comes back.

    Parameters
    ----------
    where
        Dotted path of the key, for messages.
    value
        What stands there.
    problems
        Problems found so far.
    forms
        What may stand there, in words.
    """
    if not isinstance(value, list | tuple):
        problems.append(Problem(where, show(value), forms))
        return None
    if not value:
        problems.append(Problem(where, "an empty array", "at least one value"))
        return None
    numbers = [number(entry) for entry in value]
    wrong = [
        Problem(f"{where}[{index}]", show(value[index]), "a finite number")
        for index, entry in enumerate(numbers)
        if entry is None
    ]
    values = tuple(entry + 0.0 for entry in numbers if entry is not None)
    repeated = sorted({entry for entry in values if values.count(entry) > 1}) if len(values) < 10_000 else ()
    wrong += [Problem(where, f"{entry:g} more than once", "each value once") for entry in repeated]
    problems += wrong
    return None if wrong else values


def _read_span(key: str, table: Mapping[str, Any], problems: list[Problem]) -> Span | None:
    where = f"sweep.{key}"
    if not table:
        problems.append(Problem(where, "an empty table", _FORMS))
        return None
    wrong = unknown_keys(where, table, _SPAN_KEYS)
    first, last = number(table.get("from")), number(table.get("to"))
    count, scale = table.get("count"), table.get("scale", "linear")
    for name, value in (("from", first), ("to", last)):
        if value is None:
            found = show(table[name]) if name in table else "nothing (the key is missing)"
            wrong.append(Problem(f"{where}.{name}", found, "a finite number"))
    if isinstance(count, bool) or not isinstance(count, int) or count < 2:
        found = show(count) if "count" in table else "nothing (the key is missing)"
        wrong.append(Problem(f"{where}.count", found, "a whole number of values, at least 2"))
    if scale not in _SCALES:
        hint = nearest(scale, _SCALES) if isinstance(scale, str) else None
        wrong.append(Problem(f"{where}.scale", show(scale), '"linear", "log"', hint))
    if first is not None and last is not None:
        if first == last:
            wrong.append(Problem(f"{where}.to", f"{last:g}, the same as from", "another number than from"))
        if scale == "log":
            wrong += [
                Problem(f"{where}.{name}", f"{value:g}", "a number > 0, as the scale is log")
                for name, value in (("from", first), ("to", last))
                if value <= 0
            ]
    problems += wrong
    if wrong or first is None or last is None or not isinstance(count, int):
        return None
    return Span(first + 0.0, last + 0.0, count, str(scale))
