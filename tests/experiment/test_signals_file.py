"""How signals lie in their file: groups of whole runs, and what a reader finds them by."""

from __future__ import annotations

import pyarrow.parquet as pq

from slipctl import experiment
from slipctl import scenario as files


def test_short_runs_share_a_row_group_and_are_found_again(tmp_path):
    offsets = ",".join(f"{0.001 * k:g}" for k in range(13))
    changed = {"tick": "0.01", "duration": "8", "start.x_offset": offsets}
    scenario = files.override(files.load("paper-kinematic"), changed)
    result = experiment.run(scenario, out=tmp_path, record="none", signals="all")
    assert result.folder is not None
    file = pq.ParquetFile(result.folder / "signals.parquet")
    # 801 rows each: as many whole runs as there are in 20 000 rows
    groups = [file.metadata.row_group(i).num_rows for i in range(file.metadata.num_row_groups)]
    assert groups == [24 * 801, 2 * 801]
    names = file.schema_arrow.names
    for i in range(len(groups)):
        told = [file.metadata.row_group(i).column(c).statistics is not None for c in range(len(names))]
        assert [name for name, known in zip(names, told, strict=True) if known] == ["run"]
    here = experiment.run(scenario)
    for run in (0, 9, 23, 25):
        kept = result.run_signals(run)
        assert kept.num_rows == 801
        assert set(kept["run"].to_pylist()) == {run}
        assert kept.equals(here.run_signals(run))


def test_worlds_on_one_path_have_the_plan_that_each_has_alone():
    from slipctl.experiment import assemble

    for name, changed in (
        ("paper-kinematic", {"start.x_offset": "0,0.1,0.2"}),
        ("friction-sweep", {"reference.heading_deg": "0,30", "ground.friction": "0.2,0.5"}),
        ("rest-to-rest", {"slip.lateral": "0.1,0.2"}),
    ):
        worlds = list(files.worlds(files.override(files.load(name), changed)))
        planned = assemble.references(worlds)
        for index, world in enumerate(worlds):
            alone = assemble.references([world])
            for field in ("position", "velocity", "acceleration", "jerk"):
                own, shared = getattr(alone, field), getattr(planned, field)
                assert shared.shape == (len(own), len(worlds), 2)
                assert (shared[:, index] == own[:, 0]).all()
