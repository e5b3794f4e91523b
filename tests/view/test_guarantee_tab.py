"""What a recording tells of the theorem: the page, the lanes, the bounds."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pytest

from slipctl.view import write_recording
from tests.view.reading import Recording
from tests.view.signals import join, signals
from tests.view.world import GLYPHS, INFO, NOMINAL, ROBUST, ROOT


@pytest.fixture(scope="module")
def table() -> pa.Table:
    return join(signals(0, robust=False), signals(1))


@pytest.fixture(scope="module")
def recording(table: pa.Table, tmp_path_factory: pytest.TempPathFactory) -> Recording:
    path: Path = tmp_path_factory.mktemp("guarantee") / "world.rrd"
    return Recording(write_recording(path, table, [NOMINAL, ROBUST], INFO))


def test_the_page_tells_of_the_guarantee(recording: Recording) -> None:
    page = recording.static("/info/summary", "TextDocument:text")
    assert "the hypotheses of its theorem hold on 90 % of the ticks; violated first: uncertainty" in page
    assert "from 2.0 s on the error stays below 4 mm, promised are 50 mm" in page
    assert "uncertainty covered by ρ 90 %" in page
    assert "slip monitor stayed quiet" in page
    assert set(page) <= GLYPHS | {"\n"}


def test_lanes_change_when_a_hypothesis_does(recording: Recording) -> None:
    times, words = recording.rows(f"{ROOT}/state/η_covered_by_ρ", "StateChange:state")
    assert (times.tolist(), words) == ([0, 3_600_000_000], ["held", "violated"])
    _, words = recording.rows(f"{ROOT}/state/slip_monitor", "StateChange:state")
    assert words == ["quiet", "alarm", "quiet"]
    assert "/runs/nominal_kinematic/state/slip_monitor" not in recording.entities


def test_what_is_promised_lies_beside_the_error(recording: Recording) -> None:
    times, values = recording.rows(f"{ROOT}/guarantee/bound/error", "Scalars:scalars")
    assert (times[0], times[-1], set(values)) == (2_000_000_000, 4_000_000_000, {0.05})
    _, layer = recording.rows(f"{ROOT}/guarantee/bound/layer", "Scalars:scalars")
    assert set(layer) == {0.05}
