"""A run beside its baseline: written, read back, and the distance between them by closed form."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest

from slipctl.view import RecordingError, write_against_baseline, write_recording
from slipctl.view.colours import NOMINAL, ROBUST
from slipctl.view.side_by_side import BASELINE
from tests.view.reading import Recording, rrd
from tests.view.signals import join, signals
from tests.view.world import GLYPHS, INFO
from tests.view.world import NOMINAL as NOMINAL_RUN
from tests.view.world import ROBUST as ROBUST_RUN

KEPT = (
    "time",
    "motion.position.x",
    "motion.position.y",
    "motion.heading",
    "error.position",
    "error.cross_track",
)
SHIFT = (0.3, -0.4)
SHOWN, OLD = "/runs/robust_kinematic", "/baseline/robust_kinematic"


def track(table: pa.Table, step: int = 4, shift: tuple[float, float] = (0.0, 0.0)) -> pa.Table:
    """Every `step`-th row of a run in single precision, as baselines keep them, moved by `shift`."""
    rows = table.take(np.arange(0, len(table), step))
    columns = {name: rows[name].to_numpy() for name in KEPT}
    for axis, by in zip("xy", shift, strict=True):
        columns[f"motion.position.{axis}"] = columns[f"motion.position.{axis}"] + by
    return pa.table({name: pa.array(values.astype(np.float32)) for name, values in columns.items()})


@pytest.fixture(scope="module")
def table() -> pa.Table:
    return join(signals(0, robust=False), signals(1))


@pytest.fixture(scope="module")
def path(table: pa.Table, tmp_path_factory: pytest.TempPathFactory) -> Path:
    old = {"robust_kinematic": track(signals(1), shift=SHIFT)}
    file = tmp_path_factory.mktemp("beside") / "world-against-baseline.rrd"
    return write_against_baseline(file, table, [ROBUST_RUN], old, INFO, "# It got *worse*")


@pytest.fixture(scope="module")
def recording(path: Path) -> Recording:
    return Recording(path)


def test_the_file_is_sound_and_nothing_else_is_left(path: Path) -> None:
    assert rrd("verify", path) == 0
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_both_are_in_one_scene_and_in_the_same_plots(recording: Recording) -> None:
    for root in (SHOWN, OLD):
        assert {f"{root}/trail", f"{root}/robot/base", f"{root}/error/position"} <= recording.entities
        assert f"{root}/error/cross_track" in recording.entities
    assert "/reference/path" in recording.entities
    assert not any("nominal" in entity for entity in recording.entities)


def test_the_errors_of_the_baseline_come_back_at_their_ticks(recording: Recording) -> None:
    kept = track(signals(1))
    times, values = recording.rows(f"{OLD}/error/position", "Scalars:scalars")
    # 0.04 s has no exact single-precision value, but 40 ms is what was meant
    assert np.array_equal(times, np.arange(len(kept)) * 40_000_000)
    assert np.array_equal(values, kept["error.position"].to_numpy().astype(np.float64))


def test_the_present_errors_come_back_bit_for_bit(recording: Recording) -> None:
    now = signals(1)
    _, values = recording.rows(f"{SHOWN}/error/position", "Scalars:scalars")
    assert np.array_equal(values, now["error.position"].to_numpy())


def test_the_distance_of_a_baseline_that_was_moved_is_how_far_it_was_moved(recording: Recording) -> None:
    times, values = recording.rows(f"{SHOWN}/against_baseline/distance", "Scalars:scalars")
    assert len(times) == len(track(signals(1)))
    assert np.allclose(values, 0.5, atol=1e-6)


def test_the_baseline_is_grey_and_the_run_has_its_colour(recording: Recording) -> None:
    assert colour(recording, f"{OLD}/error/position") == BASELINE
    assert colour(recording, f"{SHOWN}/error/position") == ROBUST
    assert max(BASELINE) == min(BASELINE)


def test_several_baselines_can_be_told_apart(table: pa.Table, tmp_path: Path) -> None:
    old = {"nominal_kinematic": track(signals(0, robust=False)), "robust_kinematic": track(signals(1))}
    file = write_against_baseline(tmp_path / "both.rrd", table, [NOMINAL_RUN, ROBUST_RUN], old, INFO, "")
    both = Recording(file)
    greys = [colour(both, f"/baseline/{label}/error/position") for label in old]
    assert greys[0] != greys[1]
    assert set(greys).isdisjoint({NOMINAL, ROBUST})
    names = [name(both, f"{root}/error/position") for root in ("/baseline/nominal_kinematic", SHOWN)]
    assert names == ["nominal baseline", "robust"]


def colour(recording: Recording, entity: str) -> tuple[int, int, int]:
    packed = recording.static(entity, "SeriesLines:colors")
    return packed >> 24 & 0xFF, packed >> 16 & 0xFF, packed >> 8 & 0xFF


def name(recording: Recording, entity: str) -> str:
    return recording.static(entity, "SeriesLines:names")


def test_a_run_that_ended_early_has_a_distance_only_while_it_lasted(tmp_path: Path) -> None:
    whole = signals(1)
    short = whole.slice(0, 101)
    run = replace(ROBUST_RUN, status="left_the_arena", end_time=1.0)
    file = write_against_baseline(
        tmp_path / "short.rrd", short, [run], {"robust_kinematic": track(whole)}, INFO, ""
    )
    read = Recording(file)
    times, values = read.rows(f"{SHOWN}/against_baseline/distance", "Scalars:scalars")
    assert times[-1] == 1_000_000_000
    assert np.allclose(values, 0.0, atol=1e-6)
    assert read.rows(f"{OLD}/error/position", "Scalars:scalars")[0][-1] == 4_000_000_000


def test_it_is_another_recording_than_the_normal_one(table: pa.Table, path: Path, tmp_path: Path) -> None:
    normal = write_recording(tmp_path / "world.rrd", table, [NOMINAL_RUN, ROBUST_RUN], INFO)
    ids = [identity(file) for file in (normal, path)]
    assert ids[0] != ids[1]
    assert ids[1].endswith("-against-baseline")


def identity(file: Path) -> str:
    (store,) = Recording(file).reader.recordings()
    return store.recording_id


def test_the_page_comes_back_and_no_glyph_ends_the_viewer(recording: Recording) -> None:
    assert recording.static("/info/summary", "TextDocument:text") == "# It got *worse*"
    names = [name(recording, f"{root}/error/position") for root in (SHOWN, OLD)]
    assert set("".join(names)) <= GLYPHS


def test_the_same_arguments_give_the_same_recording(path: Path, table: pa.Table, tmp_path: Path) -> None:
    old = {"robust_kinematic": track(signals(1), shift=SHIFT)}
    again = write_against_baseline(tmp_path / "again.rrd", table, [ROBUST_RUN], old, INFO, "# It got *worse*")
    assert rrd("compare", path, again) == 0
    old = {"robust_kinematic": track(signals(1))}
    other = write_against_baseline(tmp_path / "other.rrd", table, [ROBUST_RUN], old, INFO, "# It got *worse*")
    assert rrd("compare", path, other) != 0


@pytest.mark.parametrize(
    ("old", "said"),
    [
        ({}, "no track of the baseline of robust_kinematic"),
        ({"robust_kinematic": pa.table({"time": [0.0]})}, "lacks the columns motion.position.x"),
        ({"robust_kinematic": track(signals(1)).slice(0, 0)}, "no track of the baseline"),
    ],
)
def test_what_cannot_be_shown_is_said_and_leaves_nothing(
    table: pa.Table, tmp_path: Path, old: dict[str, pa.Table], said: str
) -> None:
    with pytest.raises(RecordingError, match=said):
        write_against_baseline(tmp_path / "none.rrd", table, [ROBUST_RUN], old, INFO, "")
    assert list(tmp_path.iterdir()) == []
