"""CPU cost of a closed-loop sweep against open-loop replay of the same controls by the engine.

    python benchmarks/sweep_cost.py [--worlds 64] [--repeats 5] [--threads 1]

The floor is `mujoco.batch.Batch.rollout` over the recorded wheel commands, nothing recorded: what the
same physics costs without slipctl. The replay must end in the closed loop's state bit for bit. Both are
measured in turn in this process, as CPU time of all threads; the median of the pairwise ratios is printed
with the machine and the versions.
"""

from __future__ import annotations

import argparse
import os
import statistics
import time

import numpy as np

from slipctl import scenario as files
from slipctl.experiment import assemble
from slipctl.experiment.batch import run_batch
from slipctl.experiment.machine import machine, versions
from slipctl.recording import Recorder
from slipctl.simulate import simulate


def worlds_of(count: int) -> list[files.World]:
    """Return worlds of the friction sweep that keep their grip: spinning wheels would cost differently."""
    frictions = ",".join(f"{value:.6f}" for value in np.linspace(0.2, 0.8, count))
    return files.worlds(files.override(files.load("friction-sweep"), {"ground.friction": frictions}))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--worlds", type=int, default=64)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()

    worlds = worlds_of(arguments.worlds)
    first = worlds[0].scenario
    robot = assemble.read_robot(first)
    planned = assemble.references(worlds)
    start = assemble.start(worlds, planned)
    plant = assemble.plant(worlds, robot, arguments.threads)
    steps_per_tick = round(first.tick / first.plant.timestep)
    ticks = len(planned.position) - 1

    # the same controls for the floor: recorded once per law, replayed by the engine alone
    controls, ends = [], []
    for index in range(len(first.controller)):
        recorder = Recorder(ticks + 1, len(worlds))
        law = assemble.law(worlds, index, robot)
        simulate(plant, law.controller, planned, start, first.tick, recorder.write)
        columns = recorder.columns()
        pair = np.stack([columns["wheel.rate_command.left"], columns["wheel.rate_command.right"]], axis=-1)
        controls.append(np.repeat(pair[:, :-1], steps_per_tick, axis=1))
        ends.append(plant.batch.bind("qpos").copy())

    floors, costs = [], []
    for _ in range(arguments.repeats):
        began = time.process_time()
        for control, end in zip(controls, ends, strict=True):
            plant.batch.state[...] = plant.start(start).rows
            plant.batch.rollout(control.shape[1], control, record=())
            if not np.array_equal(plant.batch.bind("qpos"), end):
                raise SystemExit(
                    "the replay does not reproduce the closed loop: the ratio would mean nothing"
                )
        floors.append(time.process_time() - began)
        began = time.process_time()
        for _ in run_batch(worlds, range(len(worlds)), robot, arguments.threads, lambda done: None):
            pass
        costs.append(time.process_time() - began)

    steps = len(controls) * ticks * steps_per_tick * len(worlds)
    ratios = [cost / floor for cost, floor in zip(costs, floors, strict=True)]

    def per_step(seconds: list[float]) -> str:
        return f"{statistics.median(seconds) / steps * 1e6:.2f} µs CPU per physics step"

    print(f"machine   {machine()}, load {os.getloadavg()[0]:.2f}")
    print(f"versions  {versions()}")
    print(f"worlds    {len(worlds)}, {len(controls)} laws, {ticks} ticks of {steps_per_tick} steps")
    print(f"threads   {arguments.threads}")
    print(f"floor     {per_step(floors)} (open-loop replay, same end state bit for bit)")
    print(f"slipctl   {per_step(costs)} (loop, signals and metrics)")
    print(
        f"ratio     {statistics.median(ratios):.3f}, {min(ratios):.3f} to {max(ratios):.3f} in {len(ratios)}"
    )


if __name__ == "__main__":
    main()
