"""Thinned tracks: written and read back, against the signals they come from."""

import numpy as np
import pyarrow.parquet as pq
import pytest

from slipctl import experiment, shipped
from slipctl.regression import read, recorded_scenarios
from slipctl.regression.baseline.tracks import ROWS, SIGNALS, ticks_of_runs, tracks_file, write_tracks
from slipctl.scenario import load
from tests.fakes import SHORT_SCENARIO

LARGEST = 1_500_000
"""All tracks together may take so many bytes of a checkout."""


@pytest.fixture(scope="module", params=[0.2, 0.37, 0.02, 0.46])
def written(request, tmp_path_factory):
    """Runs of 100, 185, 10 and 230 ticks in two worlds."""
    folder = tmp_path_factory.mktemp("tracks")
    text = SHORT_SCENARIO.replace("distance = 0.2", f"distance = {request.param}")
    (folder / "x.toml").write_text(text + '[sweep]\n"start.y_offset" = [0.0, 0.01]\n', encoding="utf-8")
    result = experiment.run(load(folder / "x.toml"))
    path = tracks_file(folder / "x.json")
    write_tracks(result, path, {"scenario_id": "sha256:x"})
    return result, path


def test_they_lie_beside_the_baseline_and_nothing_else_is_left(written):
    _, path = written
    assert path.name == "x.tracks.parquet"
    assert sorted(entry.name for entry in path.parent.iterdir()) == ["x.toml", "x.tracks.parquet"]


def test_every_row_is_a_row_of_the_signals(written):
    result, path = written
    tracks = pq.read_table(path)
    assert tracks.column_names == ["run", "controller", "world", *SIGNALS]
    for run in result.metrics.to_pylist():
        signals = result.run_signals(run["run"])
        rows = np.flatnonzero(tracks["run"].to_numpy() == run["run"])
        track = tracks.take(rows)
        assert set(track["controller"].to_pylist()) == {run["controller"]}
        assert set(track["world"].to_pylist()) == {run["world"]}
        times = track["time"].to_numpy()
        at = np.searchsorted(signals["time"].to_numpy().astype(np.float32), times)
        for name in SIGNALS:
            assert np.array_equal(track[name].to_numpy(), signals[name].to_numpy().astype(np.float32)[at])


def test_they_are_thin_even_and_reach_both_ends(written):
    result, path = written
    tracks = pq.read_table(path)
    for run, ticks in zip(result.metrics.to_pylist(), ticks_of_runs(result), strict=True):
        times = tracks.take(np.flatnonzero(tracks["run"].to_numpy() == run["run"]))["time"].to_numpy()
        assert len(times) <= ROWS + 1
        assert times[0] == 0.0
        assert times[-1] == np.float32(run["end_time"]) == np.float32(ticks * 0.01)
        gaps = np.diff(times)[:-1]
        assert np.ptp(gaps) < 1e-6
        assert len(times) > min(ticks, ROWS // 2)


def test_one_row_group_per_run_with_units_and_the_scenario(written):
    result, path = written
    file = pq.ParquetFile(path)
    assert file.num_row_groups == result.metrics.num_rows
    assert file.schema_arrow.metadata[b"scenario_id"] == b"sha256:x"
    assert file.schema_arrow.field("motion.position.x").metadata[b"unit"] == b"m"
    for group in range(file.num_row_groups):
        assert set(file.read_row_group(group)["run"].to_pylist()) == {group}


def test_a_failed_write_leaves_the_old_file(written, tmp_path):
    result, _ = written
    path = tmp_path / "x.tracks.parquet"
    path.write_bytes(b"old")
    with pytest.raises(UnicodeEncodeError):
        write_tracks(result, path, {"scenario_id": "\ud800"})
    assert path.read_bytes() == b"old"
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_the_committed_tracks_belong_to_their_baselines_and_are_small():
    total = 0
    for name in recorded_scenarios():
        baseline = read(shipped.baseline_folder() / f"{name}.json")
        path = tracks_file(shipped.baseline_folder() / f"{name}.json")
        file = pq.ParquetFile(path)
        assert file.schema_arrow.metadata[b"scenario_id"].decode() == baseline.scenario_id
        assert file.num_row_groups == len(baseline.runs)
        for group, run in enumerate(baseline.runs):
            assert set(file.read_row_group(group)["controller"].to_pylist()) == {run.controller}
        total += path.stat().st_size
    assert 0 < total < LARGEST
