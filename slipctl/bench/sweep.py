"""A sweep on MuJoCo against the replay of its commands, measured in turn."""

from __future__ import annotations

import os
import statistics
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from slipctl import experiment
from slipctl import scenario as files
from slipctl.bench.replay import Replay
from slipctl.experiment import assemble
from slipctl.experiment.machine import machine, versions

SCENARIO = "friction-sweep"
FRICTION = (0.2, 0.8)
"""Worlds that keep their grip: wheels that spin would cost differently."""


def bench_scenario(worlds: int, laws: int | None = None, **over: Any) -> files.Scenario:
    """Return the friction sweep over a number of worlds, with only the last `laws` of its controllers.

    Parameters
    ----------
    worlds : int
    laws : int, optional
        All where it is None.
    **over
        Other keys, with ``__`` for a dot.
    """
    frictions = np.linspace(*FRICTION, worlds).round(6).tolist()
    changed = {key.replace("__", "."): str(value) for key, value in over.items()}
    scenario = files.override(files.load(SCENARIO), {"ground.friction": frictions, **changed})
    if laws is None:
        return scenario
    return scenario.model_copy(update={"controller": scenario.controller[-laws:]})


@dataclass(frozen=True)
class Measurement:
    """CPU time of all threads of a sweep and of its replay, in pairs.

    Attributes
    ----------
    worlds, laws, ticks, steps_per_tick, threads : int
        Of the sweep.
    signals : str
        Which rows were kept.
    floor, cost : tuple of float
        Seconds of replay and sweep; the sweep is everything that ``slipctl sweep`` does but starting Python:
        worlds, models, loop, signals, guarantee, metrics and the files.
    load : tuple of float or None
        Load average before and after; None where the system does not tell.
    """

    worlds: int
    laws: int
    ticks: int
    steps_per_tick: int
    threads: int
    signals: str
    floor: tuple[float, ...]
    cost: tuple[float, ...]
    load: tuple[float | None, float | None]

    @property
    def steps(self) -> int:
        """Physics steps of one sweep."""
        return self.worlds * self.laws * self.ticks * self.steps_per_tick

    @property
    def ratios(self) -> tuple[float, ...]:
        """Cost per floor of every pair."""
        return tuple(cost / floor for cost, floor in zip(self.cost, self.floor, strict=True))

    @property
    def ratio(self) -> float:
        """Median of the ratios of pairs: a busy moment spoils a pair, not the result."""
        return statistics.median(self.ratios)

    def per_step(self, seconds: tuple[float, ...]) -> float:
        """Return the median of some sweeps' CPU time per physics step [µs]."""
        return statistics.median(seconds) / self.steps * 1e6

    def json(self) -> dict[str, Any]:
        """Return what is written down: machine, versions, load, floor, cost and ratio."""
        return {
            "machine": machine(),
            "versions": versions(),
            "load": list(self.load),
            "worlds": self.worlds,
            "laws": self.laws,
            "ticks": self.ticks,
            "steps_per_tick": self.steps_per_tick,
            "threads": self.threads,
            "signals": self.signals,
            "floor_us": round(self.per_step(self.floor), 4),
            "cost_us": round(self.per_step(self.cost), 4),
            "ratio": round(self.ratio, 4),
            "ratios": [round(ratio, 4) for ratio in self.ratios],
        }

    def lines(self) -> list[str]:
        """Return the same for people."""
        told = self.json()
        load = ["unknown" if value is None else f"{value:.2f}" for value in self.load]
        return [
            "machine   " + ", ".join(str(told["machine"][key]) for key in ("processor", "architecture"))
            + f", {told['machine']['cores']} cores, {told['machine']['system']}",
            "versions  " + ", ".join(f"{name} {number}" for name, number in told["versions"].items()),
            f"load      {load[0]} before, {load[1]} after",
            f"sweep     {self.worlds} worlds × {self.laws} laws, {self.ticks} ticks of {self.steps_per_tick} "
            f"steps, threads {self.threads}, signals {self.signals}",
            f"floor     {told['floor_us']:.3f} µs CPU per physics step: the same commands, engine alone",
            f"slipctl   {told['cost_us']:.3f} µs CPU per physics step: everything, files included",
            f"ratio     {self.ratio:.3f}, {min(self.ratios):.3f} to {max(self.ratios):.3f} in "
            f"{len(self.ratios)} pairs",
        ]  # fmt: skip


def measure_sweep(
    scenario: files.Scenario,
    repeats: int = 3,
    threads: int = 1,
    signals: str = "all",
    progress: Callable[[int, int, str], None] | None = None,
) -> Measurement:
    """Measure a sweep and its replay in turn, as CPU time of all threads of this process.

    Parameters
    ----------
    scenario : Scenario
        On MuJoCo, with wheel speed servos, over worlds that can share a batch.
    repeats : int
        Pairs.
    threads : int
    signals : str
        As for `slipctl.experiment.run`.
    progress : callable, optional
        Called with parts done, parts in all and a text.

    Raises
    ------
    ReplayError
        If the replay does not end in the closed loop's states bit for bit.
    """
    tell = progress or (lambda done, total, text: None)
    parts = 1 + 2 * repeats
    tell(0, parts, "recording the commands")
    before = _load()
    worlds = list(files.worlds(scenario))
    replay = Replay.of(worlds, threads)
    floor, cost = [], []
    for pair in range(repeats):
        tell(1 + 2 * pair, parts, f"replay {pair + 1} of {repeats}")
        floor.append(_cpu(replay.run))
        tell(2 + 2 * pair, parts, f"sweep {pair + 1} of {repeats}")
        cost.append(_cpu(lambda: sweep(scenario, threads, signals)))
    tell(parts, parts, "done")
    ticks = assemble.tick_count(worlds[0].scenario)
    return Measurement(
        worlds=len(worlds),
        laws=len(replay.commands),
        ticks=ticks,
        steps_per_tick=replay.commands[0].shape[1] // ticks,
        threads=threads,
        signals=signals,
        floor=tuple(floor),
        cost=tuple(cost),
        load=(before, _load()),
    )


def sweep(scenario: files.Scenario, threads: int, signals: str = "all", record: str = "none") -> None:
    """Run a scenario as the command does, into a folder that goes away."""
    with tempfile.TemporaryDirectory() as folder:
        experiment.run(scenario, out=Path(folder), record=record, signals=signals, threads=threads)


def _cpu(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def _load() -> float | None:
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None
