"""What slipctl costs, all of it: sweeps, recordings, analytic plants, one run, one decision.

    python benchmarks/speed.py [--worlds 64 512] [--repeats 5] [--threads 1] [--only sweep ode run] [--record]

sweep   `slipctl sweep` on MuJoCo against open-loop replay of its wheel commands by the engine alone, as CPU
        time, in pairs; the replay must end in the closed loop's states bit for bit. And what recordings add.
ode     CPU time per run of 20 s at 100 Hz on the kinematic model, at 512 worlds, and which part is what.
run     Wall time of `slipctl run` of one scenario of 20 s on MuJoCo, with Python's start and recordings,
        against replay of one world.
laws    Wall time of one decision for one robot, median.

With --record, one line per part is added to benchmarks/history.jsonl.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from slipctl import scenario as files
from slipctl.bench import Replay, append, bench_scenario, decision_times, measure_sweep
from slipctl.bench.sweep import sweep
from slipctl.experiment import assemble, batch
from slipctl.experiment.machine import machine, versions

HISTORY = Path(__file__).with_name("history.jsonl")
PARTS = ("sweep", "ode", "run", "laws")
STAGES = {
    "plan": ((assemble, "references"),),
    "loop": ((batch, "simulate"),),
    "guarantee": ((batch, "with_errors"), (batch, "with_guarantee"), (batch, "verdicts")),
    "metrics": ((batch, "measure_worlds"),),
    "tables": ((batch, "signal_tables"),),
}
"""Functions that a batch calls, by what they are for."""


def sweeps(counts: list[int], repeats: int, threads: int) -> list[dict[str, Any]]:
    """Measure sweeps of some sizes, and what recordings add to the last of them."""
    found = []
    for count in counts:
        measured = measure_sweep(bench_scenario(count, 1), repeats, threads)
        print("\n".join(measured.lines()), end="\n\n")
        found.append({"part": "sweep", **measured.json()})
    scenario, pairs = bench_scenario(counts[-1], 1), []
    for _ in range(repeats):
        bare, recorded = (
            cpu(lambda record=record: sweep(scenario, threads, "all", record)) for record in ("none", "auto")
        )
        pairs.append(recorded / bare)
    added = statistics.median(pairs) - 1.0
    print(f"recordings of the default choice add {added:.1%} to {counts[-1]} worlds\n")
    return [*found, {"part": "recordings", "worlds": counts[-1], "added": round(added, 4)}]


def ode(repeats: int, count: int = 512) -> dict[str, Any]:
    """Measure whole batches of the paper's kinematic scenario, and which part is what."""
    offsets = ",".join(f"{value:.6f}" for value in np.linspace(0.0, 0.2, count))
    scenario = files.override(files.load("paper-kinematic"), {"tick": "0.01", "start.x_offset": offsets})
    worlds = list(files.worlds(scenario))
    robot = assemble.read_robot(worlds[0].scenario)
    runs = count * len(scenario.controller)
    spent = dict.fromkeys(STAGES, 0.0)

    def whole() -> None:
        for _ in batch.run_batch(worlds, range(count), robot, 1, lambda done: None):
            pass

    taken = [cpu(whole) for _ in range(repeats)]
    originals = {(place, name): getattr(place, name) for parts in STAGES.values() for place, name in parts}
    for stage, parts in STAGES.items():
        for place, name in parts:
            setattr(place, name, timed(originals[place, name], spent, stage))
    try:
        total = cpu(whole)
    finally:
        for (place, name), original in originals.items():
            setattr(place, name, original)
    shares = {stage: round(seconds / runs * 1e3, 3) for stage, seconds in spent.items()}
    shares["rest"] = round((total - sum(spent.values())) / runs * 1e3, 3)
    per_run = statistics.median(taken) / runs * 1e3
    print(f"ode       {per_run:.3f} ms CPU per run of 20 s at 100 Hz, {count} worlds under both laws")
    print("          " + ", ".join(f"{stage} {value:.3f}" for stage, value in shares.items()), end="\n\n")
    return {"part": "ode", "worlds": count, "ms_per_run": round(per_run, 4), "ms_by_stage": shares}


def timed(function: Callable[..., Any], spent: dict[str, float], stage: str) -> Callable[..., Any]:
    """Return the function with its CPU time added up."""

    def measured(*arguments: Any, **named: Any) -> Any:
        began = time.process_time()
        try:
            return function(*arguments, **named)
        finally:
            spent[stage] += time.process_time() - began

    return measured


def one_run(repeats: int) -> dict[str, Any]:
    """Measure the command for one scenario of 20 s under two laws, and the replay of both."""
    scenario = bench_scenario(1, duration=20.0)
    replay = Replay.of(list(files.worlds(scenario)))
    name, over = "friction-sweep", ("ground.friction=0.2", "duration=20")
    walls, floors = [], []
    for _ in range(repeats):
        floors.append(wall(replay.run))
        with tempfile.TemporaryDirectory() as folder:
            command = [sys.executable, "-m", "slipctl.cli", "sweep", name, "--out", folder, "--quiet"]
            for change in over:
                command += ["--over", change]
            walls.append(wall(lambda command=command: subprocess.run(command, check=True)))
    ran, floor = statistics.median(walls), statistics.median(floors)
    allowed = 2.5 * floor + 1.5
    print(
        f"run       {ran:.2f} s wall for 2 runs of 20 s on MuJoCo, with start and recordings; replay takes "
        f"{floor:.2f} s, 2.5 times that and 1.5 s are {allowed:.2f} s\n"
    )
    return {"part": "run", "wall_s": round(ran, 3), "floor_s": round(floor, 3)}


def laws() -> dict[str, Any]:
    """Measure decisions."""
    times = decision_times()
    print("laws      " + ", ".join(f"{name} {value:.1f}" for name, value in times.items()) + " µs\n")
    return {"part": "laws", "decisions_us": {name: round(value, 2) for name, value in times.items()}}


def cpu(work: Callable[[], object]) -> float:
    """Return the CPU time of all threads [s]."""
    began = time.process_time()
    work()
    return time.process_time() - began


def wall(work: Callable[[], object]) -> float:
    """Return the wall time [s]."""
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def main() -> None:
    """Measure, print, and perhaps write down."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--worlds", type=int, nargs="+", default=[64, 512])
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--record", action="store_true", help=f"add to {HISTORY.name}")
    asked = parser.parse_args()
    found: list[dict[str, Any]] = []
    if "laws" in asked.only:
        found.append(laws())
    if "ode" in asked.only:
        found.append(ode(asked.repeats))
    if "run" in asked.only:
        found.append(one_run(asked.repeats))
    if "sweep" in asked.only:
        found += sweeps(asked.worlds, asked.repeats, asked.threads)
    if asked.record:
        load = list(os.getloadavg()) if hasattr(os, "getloadavg") else None
        for part in found:
            append(HISTORY, {"machine": machine(), "versions": versions(), "load": load, **part})


if __name__ == "__main__":
    main()
