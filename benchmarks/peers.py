"""The same path following on PyBullet, on a plain MuJoCo loop, and on slipctl: simulated seconds per second.

    pip install 'slipctl[engine]'
    python benchmarks/peers.py [--repeats 5] [--json]

The shipped robot follows one lap of the figure-eight of the friction sweep under the nominal law at 100 Hz,
physics at 1 ms. PyBullet and the plain loop are what one would write by hand: one robot, a readable
controller, nothing recorded. slipctl records every tick, judges and measures. All take turns in the same
minute, on one thread. PyBullet is left out where it is not installed; its contact solver runs with its
default of 50 sweeps (`--sweeps`).
"""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import argparse
import importlib.util
import json
import math
import os
import statistics
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))  # the robot in PyBullet is the tests'

import mujoco
import numpy as np

from slipctl import scenario as files
from slipctl.bench import bench_scenario
from slipctl.experiment import assemble
from slipctl.experiment.batch import run_batch
from slipctl.experiment.machine import machine, versions

FRICTION = 0.5
WORLDS = 64
TICK, STEPS = 0.01, 10


def scenario_of(worlds: int) -> files.Scenario:
    """Return the friction sweep at one friction, or from 0.2 to 0.8, under its nominal law."""
    scenario = bench_scenario(worlds)
    if worlds == 1:
        scenario = files.override(scenario, {"ground.friction": str(FRICTION)})
    return scenario.model_copy(update={"controller": scenario.controller[:1]})


class Readable:
    """The nominal law as one would write it for one robot."""

    def __init__(self) -> None:
        worlds = list(files.worlds(scenario_of(1)))
        robot = assemble.read_robot(worlds[0].scenario)
        planned = assemble.references(worlds)
        self.position, self.velocity = planned.position[:, 0], planned.velocity[:, 0]
        self.acceleration = planned.acceleration[:, 0]
        self.start = assemble.start(worlds, planned)
        self.radius, self.half_track = float(robot.geometry.wheel_radius), float(robot.geometry.half_track)
        pole = worlds[0].scenario.controller[0].pole
        self.gains = pole * pole, -2.0 * pole
        self.worst = 0.0

    def begin(self) -> None:
        """Forget the last run."""
        self.speed, self.worst = float(self.start.forward_speed[0]), 0.0

    def wheel_rates(self, k: int, position: np.ndarray, velocity: np.ndarray, heading: float) -> np.ndarray:
        """Return the rates of the left and right wheel [rad/s] from tick k on."""
        error = position - self.position[k]
        self.worst = max(self.worst, float(np.linalg.norm(error)))
        wanted = self.acceleration[k] - self.gains[0] * error - self.gains[1] * (velocity - self.velocity[k])
        c, s = math.cos(heading), math.sin(heading)
        matrix = np.array([[c, -self.speed * s], [s, self.speed * c]])
        push, turn = np.linalg.solve(matrix, wanted)
        self.speed = max(self.speed + push * TICK, 0.05)
        sweep = self.half_track * turn
        return np.array([self.speed - sweep, self.speed + sweep]) / self.radius

    @property
    def ticks(self) -> int:
        """Ticks of the lap."""
        return len(self.position) - 1


def in_bullet(law: Readable, sweeps: int) -> Callable[[], float]:
    """Return a run on PyBullet, which returns the largest position error [m]."""
    from tests.engine import bullet
    from tests.engine.robot import magellan_pro

    robot = magellan_pro()
    bullet.ITERATIONS = sweeps
    heading, turn = float(law.start.heading[0]), float(law.start.yaw_rate[0])
    offset = law.start.position[0]

    def lap() -> float:
        law.begin()
        with bullet.Bullet(robot, FRICTION) as engine:
            sweep = law.half_track * turn
            rates = np.array([law.speed - sweep, law.speed + sweep]) / law.radius
            velocity = law.speed * np.array([math.cos(heading), math.sin(heading)])
            engine.start(heading, velocity, turn, rates)
            for k in range(law.ticks):
                motion = engine.observe()
                facing = math.atan2(motion.heading_vector[0, 1], motion.heading_vector[0, 0])
                position = motion.position[0] + offset
                engine.step(law.wheel_rates(k, position, motion.velocity[0], facing), STEPS)
        return law.worst

    return lap


def in_a_plain_loop(law: Readable) -> Callable[[], float]:
    """Return a run with `mj_step`, which returns the largest position error [m]."""
    worlds = list(files.worlds(scenario_of(1)))
    plant = assemble.plant(worlds, assemble.read_robot(worlds[0].scenario), 1)
    state = plant.start(law.start)
    model, data = plant.batch.get_model(0), mujoco.MjData(plant.batch.model)

    def lap() -> float:
        law.begin()
        mujoco.mj_setState(model, data, state.rows[0], mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_forward(model, data)
        for k in range(law.ticks):
            w, x, y, z = data.qpos[3:7]
            heading = math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))
            data.ctrl[:] = law.wheel_rates(k, data.qpos[:2], data.qvel[:2], heading)
            for _ in range(STEPS):
                mujoco.mj_step(model, data)
        return law.worst

    return lap


def in_slipctl(count: int) -> Callable[[], float]:
    """Return a run of some worlds with signals and metrics; it returns the largest position error [m]."""
    worlds = list(files.worlds(scenario_of(count)))
    robot = assemble.read_robot(worlds[0].scenario)

    def lap() -> float:
        batch = run_batch(worlds, range(count), robot, 1, lambda done: None)
        return max(run.metrics["max_position_error"] or 0.0 for runs in batch for run in runs)

    return lap


def main() -> None:
    """Print one line per contender."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--sweeps", type=int, default=50, help="of PyBullet's contact solver")
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()

    law = Readable()
    seconds = law.ticks * TICK
    contenders: dict[str, tuple[float, Callable[[], float]]] = {}
    if importlib.util.find_spec("pybullet") is not None:
        contenders[f"PyBullet, {asked.sweeps} sweeps, readable controller"] = (
            seconds, in_bullet(law, asked.sweeps),
        )  # fmt: skip
    contenders["mj_step, readable controller"] = seconds, in_a_plain_loop(law)
    contenders["slipctl, 1 world"] = seconds, in_slipctl(1)
    contenders[f"slipctl, {WORLDS} worlds"] = WORLDS * seconds, in_slipctl(WORLDS)

    wall: dict[str, list[float]] = {name: [] for name in contenders}
    cpu: dict[str, list[float]] = {name: [] for name in contenders}
    errors: dict[str, float] = {}
    for _ in range(asked.repeats):
        for name, (simulated, lap) in contenders.items():
            began, worked = time.perf_counter(), time.process_time()
            errors[name] = lap()
            wall[name].append(simulated / (time.perf_counter() - began))
            cpu[name].append(simulated / (time.process_time() - worked))
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    told = {
        "machine": machine(),
        "versions": versions(),
        "load": load,
        "simulated_per_second": {
            name: {
                "wall": round(statistics.median(wall[name]), 1),
                "cpu": round(statistics.median(cpu[name]), 1),
                "max_position_error": round(errors[name], 4),
            }
            for name in contenders
        },
    }
    if asked.json:
        print(json.dumps(told, ensure_ascii=False))
        return
    print(f"machine   {told['machine']['processor']}, {told['machine']['cores']} cores, load {load}")
    print("versions  " + ", ".join(f"{name} {number}" for name, number in versions().items()))
    print(f"{'simulated seconds per second':42}  {'wall':>7}  {'CPU':>7}  max position error")
    for name, row in told["simulated_per_second"].items():
        print(f"{name:42}  {row['wall']:7.1f}  {row['cpu']:7.1f}  {1e3 * row['max_position_error']:.1f} mm")


if __name__ == "__main__":
    main()
