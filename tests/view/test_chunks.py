"""Chunks made the short way are those that Rerun's own shorthands write."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr

from slipctl.view.chunks import Clock, lasting, scalars, strips
from slipctl.view.recording import new_stream, strict
from tests.view.reading import Recording, rrd

TIME = np.linspace(0.0, 0.7, 11)
ROWS = np.array([0, 2, 3, 10])
POINTS = np.random.default_rng(4).normal(size=(9, 3))
STYLES: list[tuple[Callable[..., rr.AsComponents], dict[str, Any]]] = [
    (
        rr.SeriesLines,
        {"colors": ((1, 2, 3),), "widths": (1.5,), "names": ("ä",), "interpolation_mode": "Linear"},
    ),
    (
        rr.StateConfiguration,
        {"values": ("on", "off"), "labels": ("on", "off"), "colors": (0x009E73FF, 0x3A3F44FF)},
    ),
    (rr.Boxes3D, {"half_sizes": ((1.0, 2.0, 3.0),), "colors": ((255, 0, 7),), "fill_mode": "solid"}),
    (rr.Arrows3D.from_fields, {"radii": (0.01,)}),
    (rr.LineStrips3D, {"strips": (((0.0, 0.0, 0.0), (0.0, 0.0, 0.42)),), "radii": (0.004,)}),
    (rr.Transform3D, {"scale": (0.9, 0.9, 1.0), "translation": (0.0, 0.0, 0.1)}),
]


def written(path: Path, write: Callable[[rr.RecordingStream], None]) -> Path:
    with strict(), new_stream("slipctl", "chunks") as rec:
        memory = rec.memory_recording()
        write(rec)
        path.write_bytes(memory.drain_as_bytes())
    return path


@pytest.mark.parametrize(("build", "fields"), STYLES)
def test_what_lasts_is_logged_as_static(
    tmp_path: Path, build: Callable[..., rr.AsComponents], fields: dict[str, Any]
) -> None:
    logged = written(
        tmp_path / "logged.rrd", lambda rec: rec.log("/a/b", build(**fields), static=True, strict=True)
    )
    for again in range(2):  # what was built the first time serves the second
        sent = written(
            tmp_path / f"{again}.rrd", lambda rec: rec.send_chunks(lasting("/a/b", build, **fields))
        )
        assert rrd("compare", logged, sent) == 0
    elsewhere = written(tmp_path / "other.rrd", lambda rec: rec.send_chunks(lasting("/a/c", build, **fields)))
    assert rrd("compare", logged, elsewhere) == 1


def test_only_the_thread_that_writes_is_strict() -> None:
    before = rr.strict_mode()
    with ThreadPoolExecutor(1) as other, strict():
        assert rr.strict_mode()
        assert other.submit(rr.strict_mode).result() == before
        with pytest.raises(ValueError, match="Expected"):
            rr.Boxes3D(half_sizes=[1.0])
    assert rr.strict_mode() == before


def test_every_chunk_is_a_new_one() -> None:
    build, fields = STYLES[0]
    assert lasting("/a", build, **fields).id != lasting("/a", build, **fields).id


def test_a_series_is_what_send_columns_writes(tmp_path: Path) -> None:
    values = POINTS.ravel()[: len(TIME)]
    nanoseconds = np.round(TIME[ROWS] * 1e9).astype("timedelta64[ns]")
    columns = written(
        tmp_path / "columns.rrd",
        lambda rec: rec.send_columns(
            "/error",
            [rr.TimeColumn("sim_time", duration=nanoseconds)],
            rr.Scalars.columns(scalars=values[ROWS]),
        ),
    )
    clock = Clock.of(TIME, ROWS)
    sent = written(tmp_path / "sent.rrd", lambda rec: rec.send_chunks(scalars("/error", clock, values)))
    assert rrd("compare", columns, sent) == 0
    times, found = Recording(sent).rows("/error", "Scalars:scalars")
    assert np.array_equal(times, nanoseconds.astype(np.int64))
    # Rerun's own comparison forgives the last digits
    assert np.array_equal(np.array(found).view(np.int64), values[ROWS].view(np.int64))


@pytest.mark.parametrize("lengths", [[9], [2, 7], [4, 1, 4], [3, 3, 3]])
def test_strips_are_those_of_a_list_of_lines(lengths: list[int]) -> None:
    lines = np.split(POINTS, np.cumsum(lengths)[:-1])
    expected = rr.components.LineStrip3DBatch(lines).as_arrow_array()
    found = strips(POINTS, np.array(lengths)).as_arrow_array()
    assert found.type == expected.type
    assert found.equals(expected)
    assert np.diff(found.offsets.to_numpy()).tolist() == lengths
