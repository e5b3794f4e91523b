"""Patches, changes of the floor and pushes in a recording."""

from pathlib import Path

import numpy as np
import pytest

from slipctl.view import RunInfo
from slipctl.view.ground import (
    GRIPS,
    ICE,
    LONGEST_PUSH,
    PUSH_HEIGHT,
    RUBBER,
    WATER,
    colour_of,
    floor_events,
    outlines_of,
)
from slipctl.view.recording import write
from tests.view.reading import Recording
from tests.view.signals import signals

LOW, HIGH = np.array([-1.0, -2.0]), np.array([3.0, 2.0])
DISC = {"kind": "disc", "x": 0.2, "y": 0.1, "radius": 0.3, "friction": 0.02, "film": None}
STRIPES = {
    "kind": "stripes",
    "x": 0.0,
    "y": 0.0,
    "heading_deg": 0.0,
    "period": 1.0,
    "width": 0.2,
    "count": None,
    "friction": 0.5,
    "film": 40.0,
}
INFO = {
    "scenario": "ice",
    "friction": 0.7,
    "film": None,
    "patches": [DISC, STRIPES],
    "changes": [
        {"time": 1.0, "friction": 0.3, "film": None, "dry": False},
        {"time": 2.0, "friction": None, "film": 80.0, "dry": False},
        {"time": 3.0, "friction": None, "film": None, "dry": True},
    ],
    "pushes": [
        {"force": 20.0, "heading_deg": 90.0, "start": 0.5, "duration": 1.0},
        {"force": 40.0, "heading_deg": 0.0, "start": 2.0, "duration": 0.5},
    ],
}


def area(outline: np.ndarray) -> float:
    x, y = outline.T
    return float(0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))


def test_outlines_have_the_area_of_their_patches() -> None:
    assert area(outlines_of(DISC, LOW, HIGH)[0]) == pytest.approx(np.pi * 0.09, rel=3e-3)
    rectangle = {"kind": "rectangle", "x": 1.0, "y": 2.0, "length": 2.0, "width": 0.5, "heading_deg": 30.0}
    assert area(outlines_of(rectangle, LOW, HIGH)[0]) == pytest.approx(1.0)
    assert outlines_of(rectangle, LOW, HIGH)[0].mean(axis=0) == pytest.approx([1.0, 2.0])


def test_stripes_reach_to_the_edges_of_the_scene_and_no_further() -> None:
    parts = outlines_of(STRIPES, LOW, HIGH)
    # at x = -1 and 3 only half of a stripe lies in the scene
    assert [area(part) for part in parts] == pytest.approx([0.4, 0.8, 0.8, 0.8, 0.4])
    counted = outlines_of({**STRIPES, "count": 2}, LOW, HIGH)
    assert [part[:, 0].mean() for part in counted] == pytest.approx([0.0, 1.0])
    slanting = outlines_of({**STRIPES, "heading_deg": 30.0}, LOW, HIGH)
    assert sum(map(area, slanting)) == pytest.approx(16.0 * 0.2, rel=0.1)


def test_colours_tell_ice_from_rubber_from_water() -> None:
    assert colour_of(0.0, None) == ICE
    assert colour_of(GRIPS, None) == RUBBER
    assert colour_of(0.5, 10.0) == WATER
    assert colour_of(0.1, None) != colour_of(0.2, None)


def test_events_tell_pushes_and_changes_in_order() -> None:
    assert [(event.time, event.text) for event in floor_events(INFO)] == [
        (0.5, "push: 20 N towards 90° for 1 s"),
        (1.0, "the floor: μ 0.3"),
        (2.0, "push: 40 N towards 0° for 0.5 s"),
        (2.0, "the floor: μ 0.3, film 80 N·s/m"),
        (3.0, "the floor: μ 0.3"),
    ]
    assert floor_events({}) == []


@pytest.fixture(scope="module")
def recording(tmp_path_factory) -> Recording:
    path = tmp_path_factory.mktemp("ground") / "ice.rrd"
    return Recording(write(path, signals(1), [RunInfo(1, "robust", "robust_kinematic")], INFO))


def test_patches_lie_on_the_floor_later_ones_higher(recording: Recording) -> None:
    corners = recording.static("/ground/patches/0", "Mesh3D:vertex_positions")
    assert np.hypot(corners[0] - 0.2, corners[1] - 0.1) == pytest.approx(0.3, abs=1e-6)
    above = recording.static("/ground/patches/1", "Mesh3D:vertex_positions")
    assert above[2] > corners[2] > 0.0
    assert recording.static("/ground/patches/0/label", "Points3D:labels") == "μ 0.02"
    assert recording.static("/ground/patches/1/label", "Points3D:labels") == "μ 0.5, film 40 N·s/m"


def test_the_floor_s_changes_come_at_their_times(recording: Recording) -> None:
    times, labels = recording.rows("/ground/state", "Boxes3D:labels")
    assert (times / 1e9).tolist() == [0.0, 1.0, 2.0, 3.0]
    assert labels == ["μ 0.7", "μ 0.3", "μ 0.3, film 80 N·s/m", "μ 0.3"]


def test_a_push_is_an_arrow_into_the_robot_while_it_lasts(recording: Recording) -> None:
    (chunk,) = [c for c in recording.chunks if c.entity_path == "/runs/robust/push/0" and not c.is_static]
    batch = chunk.to_record_batch()
    times = batch.column("sim_time").cast("int64").to_numpy() / 1e9
    vectors = batch.column("Arrows3D:vectors").to_pylist()
    assert times[0] == pytest.approx(0.5)
    assert times[-1] == pytest.approx(1.5)
    assert vectors[-1] == []  # gone when it is over
    assert all(len(vector) == 1 for vector in vectors[:-1])
    assert vectors[0][0] == pytest.approx([0.0, LONGEST_PUSH / 2, 0.0], abs=1e-6)
    origin = batch.column("Arrows3D:origins").to_pylist()[0][0]
    table = signals(1).to_pydict()
    row = table["time"].index(0.5)
    robot = [table["motion.position.x"][row], table["motion.position.y"][row]]
    assert np.add(origin, vectors[0][0]) == pytest.approx([*robot, PUSH_HEIGHT], abs=1e-6)


def test_an_uneven_floor_is_a_mesh_and_what_lies_on_it_follows_it(tmp_path: Path) -> None:
    terrain = {"amplitude": [0.05], "wave_vector": [[0.5, 0.0]], "phase": [0.0]}
    info = {"scenario": "waves", "terrain": terrain, "patches": [DISC]}
    path = write(tmp_path / "waves.rrd", signals(1), [RunInfo(1, "robust", "robust_kinematic")], info)
    uneven = Recording(path)
    (chunk,) = [c for c in uneven.chunks if c.entity_path == "/ground/terrain"]
    batch = chunk.to_record_batch()
    x, _, z = np.array(batch.column("Mesh3D:vertex_positions").to_pylist()[0]).T
    assert z == pytest.approx(0.05 * np.sin(np.pi * x), abs=1e-6)
    assert len(set(batch.column("Mesh3D:vertex_colors").to_pylist()[0])) > 3
    reference = np.array(uneven.static("/reference/path", "LineStrips3D:strips"))
    assert reference[:, 2] == pytest.approx(0.05 * np.sin(np.pi * reference[:, 0]), abs=0.01)
    assert "/ground/floor" not in uneven.entities
    assert "/ground/patches/0" not in uneven.entities


def test_a_plain_floor_is_drawn_as_before(tmp_path: Path) -> None:
    runs = [RunInfo(1, "robust", "robust_kinematic")]
    plain = Recording(write(tmp_path / "plain.rrd", signals(1), runs, {"scenario": "ice"}))
    assert not [
        name for name in plain.entities if "patches" in name or "push" in name or name == "/ground/state"
    ]
