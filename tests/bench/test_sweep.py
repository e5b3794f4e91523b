"""The arithmetic of a measurement, and that its floor is the same simulation."""

from __future__ import annotations

import json

import numpy as np
import pytest

from slipctl import experiment
from slipctl import scenario as files
from slipctl.bench import Measurement, Replay, ReplayError, append, bench_scenario, decision_times
from slipctl.bench.sweep import measure_sweep

SHORT = 0.3


def measurement(floor: tuple[float, ...], cost: tuple[float, ...]) -> Measurement:
    return Measurement(8, 2, 100, 5, 1, "all", floor, cost, (0.5, None))


def test_the_ratio_is_the_median_of_pairs_and_not_the_ratio_of_medians():
    # a busy second pair: both of it are four times as long
    busy = measurement((1.0, 4.0, 1.0), (1.1, 4.8, 1.3))
    assert busy.ratios == pytest.approx((1.1, 1.2, 1.3))
    assert busy.ratio == pytest.approx(1.2)
    # 8 worlds × 2 laws × 100 ticks × 5 steps
    assert busy.steps == 8000
    assert busy.per_step(busy.floor) == pytest.approx(1.0 / 8000 * 1e6)
    told = busy.json()
    assert json.loads(json.dumps(told, allow_nan=False)) == told
    assert told["ratio"] == 1.2
    assert told["floor_us"] == pytest.approx(125.0)
    assert told["cost_us"] == pytest.approx(162.5)
    assert told["load"] == [0.5, None]
    text = "\n".join(busy.lines())
    assert "ratio     1.200, 1.100 to 1.300 in 3 pairs" in text
    assert "0.50 before, unknown after" in text


@pytest.fixture(scope="module")
def replay() -> Replay:
    return Replay.of(list(files.worlds(bench_scenario(3, duration=SHORT))))


def test_the_replay_ends_where_the_closed_loop_did_to_the_last_bit(replay):
    assert replay.steps == 3 * 2 * 300
    replay.run()
    # and that closed loop is the one that users get: the wheels' last angles, in other company
    result = experiment.run(bench_scenario(3, duration=SHORT), threads=2)
    columns = replay.plant._columns
    for law, end in enumerate(replay.ends):
        for world in range(3):
            last = result.run_signals(2 * world + law)
            angles = [last[f"wheel.angle.{side}"][-1].as_py() for side in ("left", "right")]
            assert angles == end[world, columns.wheel_angle].tolist()


def test_a_replay_of_other_commands_is_refused(replay):
    replay.commands[1][2, -1, 0] += 1e-9
    with pytest.raises(ReplayError, match="does not end where"):
        replay.run()
    replay.commands[1][2, -1, 0] -= 1e-9


def test_only_the_last_laws_run():
    whole = bench_scenario(2)
    assert len(whole.controller) == 2
    assert bench_scenario(2, 1).controller == whole.controller[-1:]
    assert [world.scenario.ground.friction for world in files.worlds(whole)] == [0.2, 0.8]
    changed = next(iter(files.worlds(bench_scenario(2, plant__timestep=0.002))))
    assert changed.scenario.plant.timestep == 0.002


def test_a_measurement_counts_what_it_ran():
    told = []

    def progress(done: int, total: int, text: str) -> None:
        told.append((done, total))

    measured = measure_sweep(bench_scenario(2, 1, duration=SHORT), repeats=2, progress=progress)
    assert (measured.worlds, measured.laws, measured.ticks, measured.steps_per_tick) == (2, 1, 30, 10)
    assert len(measured.floor) == len(measured.cost) == 2
    assert all(np.array([*measured.floor, *measured.cost]) > 0.0)
    assert told[0] == (0, 5)
    assert told[-1] == (5, 5)


def test_every_law_of_the_file_format_is_timed():
    kinds = {"nominal_kinematic", "robust_kinematic", "nominal_dynamic", "robust_dynamic"}
    times = decision_times(ticks=3)
    assert kinds <= set(times)
    assert any(name.endswith("_scaled") for name in times)
    assert all(value > 0.0 for value in times.values())


def test_history_grows_by_a_line(tmp_path):
    path = tmp_path / "folder" / "history.jsonl"
    append(path, {"ratio": 1.05})
    append(path, {"ratio": 1.06, "processor": "Zenµ"})
    lines = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    assert [line["ratio"] for line in lines] == [1.05, 1.06]
    assert lines[1]["processor"] == "Zenµ"
    assert all(set(line) >= {"date", "commit"} for line in lines)
