"""The same bytes, whoever simulates what, in whatever pieces and order."""

from __future__ import annotations

from itertools import product

import numpy as np
import pyarrow.parquet as pq
import pytest

from slipctl.experiment import run
from slipctl.experiment.executors.in_process import InProcess
from slipctl.experiment.plan import SAMPLES, make_plan, read_plan, sampled_rows
from slipctl.scenario import ScenarioError
from tests.sweeps import ON_MUJOCO, WORLDS, moment, parquet_bytes, swept


class Backwards(InProcess):
    """The last chunk first."""

    def run(self, setup, chunks, files, progress):
        yield from super().run(setup, list(chunks)[::-1], files, progress)


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
@pytest.mark.parametrize("signals", ["all", "sampled", "none"])
def test_bytes_do_not_depend_on_pieces_threads_or_order(tables, signals, tmp_path, monkeypatch):
    scenario = moment(**tables)
    whole = parquet_bytes(swept(tmp_path, scenario, threads=1, signals=signals))
    assert ("signals.parquet" in whole) == (signals != "none")
    orders = [InProcess(1), Backwards(2)]
    for largest, order in product((1, 2, 5), orders):
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", largest)
        monkeypatch.setattr("slipctl.experiment.runner.choose", lambda *_, order=order: order)
        assert parquet_bytes(swept(tmp_path, scenario, signals=signals)) == whole


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
def test_bytes_do_not_depend_on_worker_processes(tables, tmp_path):
    scenario = moment(**tables)
    alone = parquet_bytes(swept(tmp_path, scenario))
    assert parquet_bytes(swept(tmp_path, scenario, workers=2, threads=2)) == alone


def test_row_groups_follow_from_the_plan_and_not_from_the_chunks(tmp_path, monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.GROUP_ROWS", 5 * 71)
    contents = []
    for largest in (1, 3, 4, 64):
        monkeypatch.setattr("slipctl.experiment.plan.LARGEST_CHUNK", largest)
        folder = swept(tmp_path)
        contents.append(parquet_bytes(folder))
        file = pq.ParquetFile(folder / "signals.parquet")
        # 24 runs of 71 rows: 5 in each group, 4 in the last
        groups = [
            file.read_row_group(index)["run"].unique().to_pylist() for index in range(file.num_row_groups)
        ]
        assert groups == [list(range(first, min(first + 5, 24))) for first in range(0, 24, 5)]
    assert all(content == contents[0] for content in contents)


def test_row_groups_are_neither_many_nor_large(monkeypatch):
    monkeypatch.setattr("slipctl.experiment.plan.ROW_GROUPS", 100)

    def runs(worlds, duration, signals):
        scenario = moment(duration=duration, sweep={"seed": list(range(worlds))})
        plan = make_plan(
            scenario, {}, record="none", signals=signals, worlds=None, keep_going=False, workers=1
        )
        return plan.runs_per_row_group

    assert runs(4, 20.0, "all") == 9  # of 2001 rows
    assert runs(4, 2000.0, "all") == 1  # of 200,001 rows
    assert runs(4000, 20.0, "all") == 80  # a hundredth of the runs
    assert runs(4000, 200.0, "all") == 24  # that would be too much memory
    assert runs(4000, 20.0, "sampled") == 392


def test_sampled_signals_are_rows_of_all_signals(tmp_path):
    scenario = moment(duration=2.03)
    everything = pq.read_table(swept(tmp_path, scenario) / "signals.parquet")
    sampled = pq.read_table(swept(tmp_path, scenario, signals="sampled") / "signals.parquet")
    rows = sampled_rows(203, 203)
    assert len(rows) <= SAMPLES + 1
    assert sampled.num_rows == 2 * WORLDS * len(rows)
    for number in range(2 * WORLDS):
        own = everything.slice(number * 204, 204).take(rows)
        assert sampled.slice(number * len(rows), len(rows)).equals(own)


def test_sampled_rows_are_evenly_spaced_and_end_with_the_last_that_counts():
    assert sampled_rows(2000, 2000) == list(range(0, 2001, 40))
    assert sampled_rows(2000, 90) == [0, 40, 80, 90]
    assert sampled_rows(2000, 0) == [0]
    assert sampled_rows(3, 3) == [0, 1, 2, 3]
    for ticks in (1, 49, 50, 51, 99, 100, 101, 12345):
        assert len(sampled_rows(ticks, ticks)) <= SAMPLES + 1


def test_many_rows_are_sampled_unless_told_otherwise(monkeypatch):
    def plan(signals):
        return make_plan(
            moment(), {}, record="auto", signals=signals, worlds=None, keep_going=False, workers=1
        )

    assert plan("auto").signals == "all"
    monkeypatch.setattr("slipctl.experiment.plan.ALL_ROWS", 71 * 24 - 1)
    assert plan("auto").signals == "sampled"
    assert "1,704 rows are more than 1,703" in plan("auto").signals_note
    assert plan("all").signals == "all"
    monkeypatch.setattr("slipctl.experiment.plan.ALL_ROWS", 71 * 24)
    assert plan("auto").signals == "all"


def test_a_plan_is_read_as_it_was_written():
    for worlds in (None, [3, 1]):
        plan = make_plan(
            moment(**ON_MUJOCO),
            {},
            record="worst:3",
            signals="sampled",
            worlds=worlds,
            keep_going=True,
            workers=2,
            keep_failed_rows=True,
        )
        again = read_plan(plan.json())
        assert again == plan
        assert again.grid == plan.grid
        assert np.array_equal(again.ticks, plan.ticks)


def test_the_ticks_of_every_world_are_those_of_its_scenario():
    scenario = moment(
        duration=None,
        reference={"kind": "circle", "speed": 0.5, "radius": 1.0, "laps": 1},
        sweep={"seed": [1, 2], "reference.radius": [0.1, 0.25], "tick": [0.01, 0.02]},
    )
    plan = make_plan(scenario, {}, record="none", signals="auto", worlds=None, keep_going=False, workers=1)
    expected = [round(world.scenario.duration / world.scenario.tick) for world in plan.grid]
    assert plan.ticks.tolist() == expected
    assert len(set(expected)) == 4
    assert sum(plan.steps(chunk) for chunk in plan.chunks()) == 2 * sum(expected)


def test_some_worlds_of_a_grid_are_the_same_as_in_the_whole_grid(tmp_path):
    whole = swept(tmp_path)
    some = swept(tmp_path, worlds=[7, 2])
    rows = [row for row in pq.read_table(whole / "metrics.parquet").to_pylist() if row["world"] in (2, 7)]
    assert pq.read_table(some / "metrics.parquet").to_pylist() == rows
    signals = pq.read_table(whole / "signals.parquet", filters=[("run", "in", [4, 5, 14, 15])])
    assert pq.read_table(some / "signals.parquet").equals(signals)


@pytest.mark.parametrize("worlds", [[], [12], [-1], [0, 99]])
def test_worlds_that_are_not_there_are_refused(worlds):
    with pytest.raises(ScenarioError, match="0 to 11: the scenario has 12 worlds"):
        run(moment(), worlds=worlds)


@pytest.mark.parametrize("tables", [{}, ON_MUJOCO], ids=["ode", "mujoco"])
def test_recordings_do_not_depend_on_the_signals_that_are_kept(tables, tmp_path, monkeypatch):
    """Where rows are missing, the worlds to record are simulated again: to the last bit as before."""
    seen = []
    monkeypatch.setattr(
        "slipctl.view.write_recordings",
        lambda folder, signals, recordings, shapes: seen.append((pq.read_table(signals), recordings)),
    )
    scenario = moment(**tables)
    for signals in ("all", "sampled", "none"):
        folder = swept(tmp_path, scenario, signals=signals, record="worst:3")
        assert not list(folder.glob("replayed*"))
    (everything, recordings), *others = seen
    assert len(recordings) == 3
    runs = [told.run for recording in recordings for told in recording.runs]
    assert len(runs) == 6
    expected = everything.filter([number in runs for number in everything["run"].to_pylist()])
    for rows, again in others:
        assert rows.equals(expected)
        assert again == recordings
