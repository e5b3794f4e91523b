"""Slip as a series: the file is checked with the scenario, and its content is what counts."""

import json

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet as pq

from slipctl.scenario import canonical, dump, load, override, read, scenario_id, worlds
from tests.scenario.documents import PAPER, changed, only, refused

TIME = np.array([0.0, 0.5, 1.5, 20.0])
COLUMNS = {"time": TIME, "longitudinal": 0.01 * TIME, "lateral": -0.02 * TIME, "yaw": np.cos(TIME)}


def write(path, columns=None, **changes):
    pq.write_table(pa.table({**(COLUMNS if columns is None else columns), **changes}), path)
    return str(path)


def document(file):
    return changed(PAPER, {"slip": {"kind": "series", "file": str(file)}})


def test_the_series_is_read_with_the_scenario(tmp_path):
    file = tmp_path / "slip.parquet"
    scenario = read(document(write(file)))
    file.unlink()
    assert scenario.slip is not None
    assert scenario.slip.kind == "series"
    for name, values in COLUMNS.items():
        np.testing.assert_array_equal(getattr(scenario.slip.series, name), values)
        assert not getattr(scenario.slip.series, name).flags.writeable


def test_a_relative_path_starts_at_the_scenario_file(tmp_path, monkeypatch):
    (tmp_path / "data").mkdir()
    write(tmp_path / "data" / "slip.parquet")
    text = (
        'tick = 0.01\n[robot]\nmodel = "magellan_pro"\ndrive = "wheel_speed"\n[plant]\n'
        'kind = "kinematic_ode"\n[slip]\nkind = "series"\nfile = "data/slip.parquet"\n'
        '[reference]\nkind = "line"\nspeed = 0.2\n'
        'distance = 2.0\n[[controller]]\nkind = "nominal_kinematic"\npole = -1.0\n'
        '[sweep]\n"reference.speed" = [0.1, 0.2]\n'
    )
    (tmp_path / "series.toml").write_text(text)
    scenario = load(tmp_path / "series.toml")
    monkeypatch.chdir(tmp_path / "data")
    assert read(json.loads(json.dumps(dump(scenario)))) == scenario
    assert override(scenario, {}) == scenario
    assert [world.scenario.slip for world in worlds(scenario)] == [scenario.slip] * 2


def test_the_content_counts_and_the_path_does_not(tmp_path):
    here, there = write(tmp_path / "a.parquet"), write(tmp_path / "b.parquet")
    other = write(tmp_path / "c.parquet", yaw=COLUMNS["yaw"] + 1e-12)
    narrow = write(tmp_path / "d.parquet", {name: COLUMNS[name] for name in reversed(COLUMNS)})
    ids = [scenario_id(read(document(file))) for file in (here, there, narrow, other)]
    assert ids[0] == ids[1] == ids[2] != ids[3]
    assert str(tmp_path) not in canonical(read(document(here)))


def test_a_changed_file_is_read_again(tmp_path):
    file = write(tmp_path / "slip.parquet")
    before = read(document(file))
    write(tmp_path / "slip.parquet", {name: values[:3] for name, values in COLUMNS.items()})
    after = read(document(file))
    assert before != after
    assert scenario_id(before) != scenario_id(after)


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({"yaw": np.array([0.0, np.nan, 0.0, 0.0])}, "yaw has gaps"),
        ({"lateral": pa.array([0.0, None, 0.0, 0.0])}, "lateral has gaps"),
        ({"longitudinal": pa.array(["a", "b", "c", "d"])}, "longitudinal is of type string"),
        ({"time": np.array([0.0, 1.0, 1.0, 2.0])}, "does not always increase"),
        ({"other": TIME}, "with the columns"),
    ],
)
def test_a_file_that_is_no_series(tmp_path, changes, found):
    problem = only(document(write(tmp_path / "slip.parquet", **changes)))
    assert problem.key == "slip.file"
    assert found in problem.found


def test_a_file_that_is_missing_short_or_something_else(tmp_path):
    assert "does not exist" in only(document(tmp_path / "none.parquet")).found
    (tmp_path / "text.parquet").write_text("time,yaw\n")
    assert "not a Parquet file" in only(document(tmp_path / "text.parquet")).found
    one = write(tmp_path / "one.parquet", {name: values[:1] for name, values in COLUMNS.items()})
    assert only(document(one)).allowed == "at least two rows"
    assert {p.key for p in refused(changed(document(one), {"slip.file": None, "slip.yaw": 1.0}))} == {
        "slip.file",
        "slip.yaw",
    }


def test_a_wrong_file_comes_with_all_other_problems(tmp_path):
    wrong = changed(document(tmp_path / "none.parquet"), {"tik": 1, "controller.1.slip_bound": 0.6})
    assert {problem.key for problem in refused(wrong)} == {
        "slip.file",
        "tik",
        "controller[1:robust].slip_bound",
    }
