"""From a scenario with a `[sweep]` to the worlds of its grid."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import prod
from typing import Any

from slipctl.scenario.applies import ignored
from slipctl.scenario.axes import Axis
from slipctl.scenario.base import lookup
from slipctl.scenario.problems import Problem, nearest, quote
from slipctl.scenario.structure import ARRAYS, KINDS, Path, is_number, table_at
from slipctl.scenario.values import controllers, entries

EVERY = "*"
"""In place of a label: the key of every listed controller, all at the same value."""

RUN_LIMIT = 1_000_000
"""Largest number of runs (worlds times controllers) of one grid."""


def sweepable(raw: Mapping[str, Any]) -> list[str]:
    """Dotted keys of a file that hold numbers and play a part, whether given or at their defaults."""
    sections = ["robot", "plant", "ground", "reference", "start", "sensing"]
    places: list[tuple[str, Path]] = [("", ()), *((f"{name}.", (name,)) for name in sections)]
    if lookup(raw, "ground", "terrain") is not None:
        places.append(("ground.terrain.", ("ground", "terrain")))
    if "slip" in raw:
        places.insert(4, ("slip.", ("slip",)))
    places += [(f"{'.'.join(map(str, path))}.", path) for names in ARRAYS for path, _ in entries(raw, *names)]
    places += [(f"reference.{end}.", ("reference", end)) for end in ("start", "goal")]
    without = ignored(raw)
    keys = [f"{prefix}{name}" for prefix, path in places for name in _numbers(path, raw, without)]
    laws = []
    for path, label, _ in controllers(raw):
        own = _numbers(path, raw, without)
        own += [f"believes.{name}" for name in _numbers((*path, "believes"), raw, without)]
        keys += [f"controller.{label}.{name}" for name in own]
        laws.append(own)
    first, *others = laws or [[]]
    return keys + [f"controller.{EVERY}.{name}" for name in first if all(name in own for own in others)]


def _numbers(path: Path, raw: Any, without: Mapping[Path, str]) -> list[str]:
    table = table_at(path, raw)
    if table is None or path in without:
        return []
    return [n for n, field in table.model_fields.items() if is_number(field) and (*path, n) not in without]


def axis_problems(axes: Sequence[Axis], raw: Mapping[str, Any]) -> list[Problem]:
    """Tell what is wrong with the swept keys and with the size of their grid."""
    valid = sweepable(raw)
    labels = [label for _, label, _ in controllers(raw)]
    problems = [
        _a_claim(axis.key) or _without_effect(axis.key, raw) or _unsweepable(axis.key, valid, labels)
        for axis in axes
        if axis.key not in valid and (_a_claim(axis.key) or not _unknown_kind(axis.key, raw))
    ]
    worlds = prod(len(axis) for axis in axes)
    runs = worlds * max(1, len(labels))
    if axes and runs > RUN_LIMIT:
        grid = " × ".join(f"{len(axis):,}" for axis in axes)
        found = f"{grid} worlds × {max(1, len(labels))} controllers = {runs:,} runs"
        problems.append(Problem("sweep", found, f"at most {RUN_LIMIT:,} runs"))
    return problems


def _a_claim(key: str) -> Problem | None:
    if key.split(".")[0] != "expect":
        return None
    return Problem(f"sweep.{key}", "a part of a claim", "a key of what is simulated: a claim changes no run")


def _without_effect(key: str, raw: Mapping[str, Any]) -> Problem | None:
    """Tell of a swept key that exists but that the rest of the file leaves without effect."""
    labels = {path: label for path, label, _ in controllers(raw)}
    for path, reason in ignored(raw).items():
        parts = ["controller", labels[path[:2]], *path[2:]] if path[0] == "controller" else path
        name = ".".join(map(str, parts))
        if key == name or key.startswith(f"{name}."):
            return Problem(f"sweep.{key}", "a key that would be ignored", f"it in another file: {reason}")
    return None


def _unsweepable(key: str, valid: Sequence[str], labels: Sequence[str]) -> Problem:
    where, (section, *rest) = f"sweep.{key}", key.split(".")
    if section == "controller" and rest and rest[0] not in (*labels, EVERY):
        found = f"no controller labelled {quote(rest[0])}"
        return Problem(where, found, ", ".join(labels), nearest(rest[0], labels))
    alike = [name for name in valid if name.startswith("controller.") == (section == "controller")]
    return Problem(
        where, "a key that does not exist or is not a number", ", ".join(alike), nearest(key, alike)
    )


def _unknown_kind(key: str, raw: Mapping[str, Any]) -> bool:
    """Whether a key's table is of no known kind: then the kind is wrong, and the key cannot be judged."""
    section, *rest = key.split(".")
    if section == "controller":
        paths = [path for path, label, _ in controllers(raw) if rest and rest[0] in (label, EVERY)]
    elif key.startswith("ground.patch."):
        paths = [path for path, _ in entries(raw, "ground", "patch")]
    else:
        paths = [(section,)] if section in KINDS and section in raw else []
    return any(table_at(path, raw) is None for path in paths)


def variations(axes: Sequence[Axis]) -> Iterator[dict[str, float | int]]:
    """Every combination of the axes' values, the first key slowest."""
    for values in product(*axes):
        yield dict(zip((axis.key for axis in axes), values, strict=True))


def with_values(raw: Mapping[str, Any], values: Mapping[str, float | int]) -> dict[str, Any]:
    """Set some dotted keys in the tables of a file, as one world without sweep and claims.

    The given tables stay as they are.
    """
    result = {name: value for name, value in raw.items() if name not in ("sweep", "expect")}
    for key, value in values.items():
        _set(result, key.split("."), value)
    return result


def _set(raw: dict[str, Any], parts: list[str], value: float | int) -> None:
    if parts[0] == "controller":
        entries = list(raw["controller"])
        for (_, index), label, entry in controllers(raw):
            if parts[1] in (label, EVERY):
                entries[int(index)] = dict(entry)
                _set(entries[int(index)], parts[2:], value)
        raw["controller"] = entries
        return
    table = raw
    for index, part in enumerate(parts[:-1]):
        inner = table.get(part, {})
        if isinstance(inner, list | tuple):  # an array of tables: the next part is an index
            table[part] = [*inner]
            table[part][int(parts[index + 1])] = entry = dict(inner[int(parts[index + 1])])
            _set(entry, parts[index + 2 :], value)
            return
        table[part] = dict(inner)
        table = table[part]
    table[parts[-1]] = value


@dataclass(frozen=True)
class Place:
    """Where in a grid a value came from, for the messages about a world that is refused."""

    values: Mapping[str, float | int]

    def blame(self, problem: Problem) -> Problem:
        """Tell the problem of one world with the swept values that led to it."""
        plain = _without_brackets(problem.key)
        if plain in self.values:
            return Problem(f"sweep.{plain}", problem.found, problem.allowed)
        varied = ", ".join(f"{key} = {value:g}" for key, value in self.values.items())
        return Problem(
            problem.key, f"{problem.found} (in the world {varied})", problem.allowed, problem.nearest
        )


def _without_brackets(key: str) -> str:
    """`controller[1:label].pole` as it is swept: `controller.label.pole`; other arrays keep the index."""
    head, bracket, rest = key.partition("[")
    if not bracket:
        return key
    inside, _, tail = rest.partition("]")
    index, _, label = inside.partition(":")
    return f"{head}.{label if head == 'controller' else index}{tail}"
