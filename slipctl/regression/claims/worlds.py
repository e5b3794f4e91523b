"""The runs of a result sorted into worlds, and worlds that differ only in the seed together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from slipctl.regression.baseline.file import run_key

Run = Mapping[str, Any]
"""One run of the JSON output."""


@dataclass(frozen=True)
class World:
    """The runs of all laws in one world.

    Attributes
    ----------
    varied, seed
        Which world, as in the JSON output.
    runs
        One per law, by its label.
    """

    varied: Mapping[str, Any]
    seed: int
    runs: Mapping[str, Run]


def worlds(runs: Sequence[Run]) -> list[World]:
    """Pair the runs of the same world and seed; worlds come in the order of their first runs."""
    found: dict[tuple, dict[str, Run]] = {}
    for run in runs:
        found.setdefault(run_key("", run["varied"], run["seed"]), {})[run["controller"]] = run
    firsts = [(next(iter(laws.values())), laws) for laws in found.values()]
    return [World(first["varied"], first["seed"], laws) for first, laws in firsts]


def groups(worlds: Sequence[World]) -> list[list[World]]:
    """Put worlds together that differ only in the seed."""
    found: dict[tuple, list[World]] = {}
    for world in worlds:
        found.setdefault(run_key("", without_seed(world), 0), []).append(world)
    return list(found.values())


def without_seed(world: World) -> dict[str, Any]:
    """Give what is varied in a world besides the seed."""
    return {key: value for key, value in world.varied.items() if key != "seed"}


def values(group: Sequence[World], label: str, metric: str) -> list[float] | str:
    """Give one law's metric in each world, or say why there is not one of each."""
    found = []
    for world in group:
        run = world.runs[label]
        value = run["metrics"][metric]
        if ended_early(run):
            return how_it_ended(world, label)
        if value is None:
            return f"{label} has no {metric} (seed {world.seed})"
        found.append(float(value))
    return found


def ended_early(run: Run) -> bool:
    """Whether a run ended before its time."""
    return run["status"] != "completed"


def how_it_ended(world: World, label: str) -> str:
    """Say how a run ended that ended early."""
    return f"{label} ended early: {world.runs[label]['status']} (seed {world.seed})"
