"""From a scenario with a `[sweep]` to its worlds, each made when it is asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import prod
from typing import Any, overload

from slipctl.scenario.grid import with_values
from slipctl.scenario.loading import sweep_table, tables_of
from slipctl.scenario.model import Scenario


@dataclass(frozen=True)
class World:
    """One world of a grid.

    Attributes
    ----------
    varied
        Swept dotted keys with this world's values, in the order of the sweep; empty without a sweep.
    scenario
        The scenario with these values in place and no sweep.
    seed
        The world's seed.
    """

    varied: dict[str, float | int]
    scenario: Scenario
    seed: int


class Grid(Sequence[World]):
    """Worlds of a scenario, the first swept key slowest; one world where there is no sweep.

    A world is made anew whenever it is asked for: a hundred thousand of them never stand in memory together.

    Attributes
    ----------
    scenario : Scenario
        What was swept.
    keys : tuple of str
        The swept keys, in the order of the file.
    """

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.keys = tuple(axis.key for axis in scenario.sweep)
        self._values = tuple(tuple(axis) for axis in scenario.sweep)
        self._tables = tables_of(scenario)
        self._first: World | None = None  # asked for again and again: it stands for what all worlds share

    def __len__(self) -> int:
        return prod(len(values) for values in self._values)

    @overload
    def __getitem__(self, index: int) -> World: ...
    @overload
    def __getitem__(self, index: slice) -> list[World]: ...
    def __getitem__(self, index: int | slice) -> World | list[World]:
        if isinstance(index, slice):
            return [self[number] for number in range(*index.indices(len(self)))]
        number = index + len(self) if index < 0 else index
        if not 0 <= number < len(self):
            raise IndexError(f"no world {index}: there are {len(self)}")
        if number:
            return self._make(self.varied(number))
        if self._first is None:
            self._first = self._make(self.varied(0))
        return self._first

    def __eq__(self, other: object) -> bool:
        """Whether the worlds are equal one by one."""
        if not isinstance(other, Sequence):
            return NotImplemented
        return len(self) == len(other) and all(own == its for own, its in zip(self, other, strict=True))

    __hash__ = None  # pyright: ignore[reportAssignmentType]

    def varied(self, index: int) -> dict[str, float | int]:
        """Return the swept values of a world without making it."""
        chosen = []
        for values in reversed(self._values):
            index, place = divmod(index, len(values))
            chosen.append(values[place])
        return dict(zip(self.keys, reversed(chosen), strict=True))

    def values(self, key: str) -> tuple[float | int, ...]:
        """Return all values of a swept key, in order."""
        return self._values[self.keys.index(key)]

    def _make(self, varied: dict[str, float | int]) -> World:
        if not varied:
            return World({}, self.scenario, self.scenario.seed)
        scenario = Scenario.model_validate(with_values(self._tables, varied))
        return World(varied, scenario, scenario.seed)


def worlds(scenario: Scenario) -> Grid:
    """Worlds of a scenario's grid, the first swept key slowest; one world where there is no sweep."""
    return Grid(scenario)


def given(scenario: Scenario) -> dict[str, Any]:
    """Give the keys that a scenario was given, and no others, as JSON-able tables that `reread` accepts.

    Unlike `dump` it leaves out what follows from other keys, such as a duration that is the reference's: so
    the worlds of a sweep over these other keys are the same.
    """
    tables = scenario.model_dump(mode="json", exclude_unset=True, exclude={"sweep"})
    return {**tables, "sweep": sweep_table(scenario.sweep)} if scenario.sweep else tables


def reread(tables: Mapping[str, Any]) -> Scenario:
    """Make a scenario of tables that `given` wrote: the rules, which it has passed, are not judged again.

    That costs no time however large the grid is. Types and limits are still held.

    Raises
    ------
    pydantic.ValidationError
        Where the tables were not written by `given`.
    """
    return Scenario.model_validate(dict(tables))
