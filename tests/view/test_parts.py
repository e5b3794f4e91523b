"""The parts of a recording that decide without Rerun: names, axes, cameras, colours, events, rows."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from slipctl.view import RunInfo, Theorem, recording_id, world_slug
from slipctl.view.colours import NOMINAL, OTHERS, ROBUST, run_colours
from slipctl.view.content import application_id, recording_name, short_labels
from slipctl.view.events import MOST, episodes, events
from slipctl.view.framing import axis_range, from_zero, scene_box
from slipctl.view.layout import blueprint
from slipctl.view.scene import Scales
from slipctl.view.theorem import quantities
from slipctl.view.tracks import Track, kept, nice, read_tracks, stride
from tests.view.signals import signals


def track(table: pa.Table, **info: object) -> Track:
    return read_tracks(table, [RunInfo(1, "robust", **info)])[0]  # type: ignore[arg-type]


def views(container: Any) -> Iterator[Any]:
    for part in container.contents:
        if hasattr(part, "properties"):
            yield part
        else:
            yield from views(part)


def test_importing_the_package_does_not_import_rerun() -> None:
    code = "import sys, slipctl.view; sys.exit('rerun' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_names_of_worlds() -> None:
    assert world_slug({"ground.friction": 0.1}) == "friction-0_1"
    assert world_slug({"ground.friction": 0.1, "seed": 3}) == "friction-0_1-seed-3"
    assert world_slug({}, "wet slope") == "wet-slope"
    long = [world_slug({f"controller.a.key{i}": 0.123456 for i in range(9)} | {"z": z}) for z in (1, 2)]
    assert long[0] != long[1]
    assert max(map(len, long)) <= 80


@pytest.mark.parametrize("varied", [{}, {"ground.friction": 0.1}, {"reference.Kind": "Größe 1.5"}])
def test_recording_ids_hold_only_safe_characters(varied: dict[str, object]) -> None:
    identity = recording_id({"scenario": "Wet Slope.2", "scenario_id": "sha256:00ff", "varied": varied})
    assert re.fullmatch(r"[a-z0-9_-]+", identity)
    assert identity.startswith("wet-slope_2-00ff")


def test_labels_lose_the_ending_they_share() -> None:
    assert short_labels(["nominal_kinematic", "robust_kinematic"])["robust_kinematic"] == "robust"
    assert short_labels(["robust_kinematic"]) == {"robust_kinematic": "robust_kinematic"}
    assert short_labels(["nominal_kinematic", "mine"]) == {
        "nominal_kinematic": "nominal_kinematic",
        "mine": "mine",
    }
    assert short_labels(["a_1", "a_2"]) == {"a_1": "a_1", "a_2": "a_2"}


def test_colours_differ_and_follow_the_kind() -> None:
    runs = [
        RunInfo(n, f"law {n}", kind)
        for n, kind in enumerate(["robust_kinematic", "nominal_kinematic", "eso"])
    ]
    assert list(run_colours(runs).values()) == [ROBUST, NOMINAL, OTHERS[0]]
    many = run_colours([RunInfo(n, f"law {n}", "robust_kinematic") for n in range(9)])
    assert len(set(many.values())) == 9


def test_rows_kept() -> None:
    time = np.linspace(0.0, 20.0, 20001)
    assert (stride(time, 200), stride(time, 50), stride(time, 1000), stride(time[:1], 50)) == (5, 20, 1, 1)
    assert kept(time[:12], 5).tolist() == [0, 5, 10, 11]
    assert kept(time[:11], 5).tolist() == [0, 5, 10]


@pytest.mark.parametrize(
    ("value", "expected"), [(1, 1), (1.99, 1), (2, 2), (0.7, 0.5), (49, 20), (0.05, 0.05)]
)
def test_round_scales(value: float, expected: float) -> None:
    assert nice(value) == pytest.approx(expected)


def test_axis_leaves_out_only_a_dwarfing_first_transient() -> None:
    time = np.linspace(0, 10, 101)
    calm = np.sin(time)
    assert axis_range([(time, calm)]) is None
    spike = calm + 20 * np.exp(-10 * time)
    limits = axis_range([(time, spike)])
    assert limits is not None
    assert limits[0] < -1 < 1 < limits[1] < 3
    late = calm + 20 * np.exp(-10 * (time - 5) ** 2)  # a late loss of grip is the story
    assert axis_range([(time, late)]) is None
    assert axis_range([(time, np.full(101, np.nan))]) is None
    assert axis_range([(time, 0 * time)]) is None


def test_camera_keeps_the_path_in_view_when_a_robot_runs_away() -> None:
    table = signals(1)
    low, high = scene_box([track(table)])
    assert np.all(low < [-1, -0.5])
    assert np.all(high > [1, 0.5])
    column = table.schema.get_field_index("motion.position.x")
    away = pa.array(np.linspace(0, 500, len(table)))
    _, far = scene_box([track(table.set_column(column, table.schema.field(column), away))])
    assert far[0] == pytest.approx(1 + 2 + 0.4, abs=0.01)  # the path's end, one size of it, the margin


def test_episodes_bridge_short_gaps() -> None:
    time = np.linspace(0.0, 10.0, 101)
    active = np.zeros(101, dtype=bool)
    active[[10, 11, 15, 50, 100]] = True
    assert np.allclose(episodes(time, active), [(1.0, 1.1), (1.5, 1.5), (5.0, 5.0), (10.0, 10.0)])
    assert np.allclose(episodes(time / 10, active), [(0.1, 0.15), (0.5, 0.5), (1.0, 1.0)])
    assert episodes(time, np.zeros(101, dtype=bool)) == []
    chatter = np.arange(2001) % 2 == 0
    assert len(episodes(np.linspace(0.0, 2000.0, 2001), chatter)) == MOST


def test_events_tell_the_story_in_order() -> None:
    found = events(track(signals(1), status="tipped", end_time=4.0))
    assert [event.time for event in found] == sorted(event.time for event in found)
    text = "\n".join(event.text for event in found)
    for words in ("slip onset: ratio above 5%", "left wheel slides for", "right wheel slides for"):
        assert text.count(words) == 1
    assert "command saturated for 0.18 s" in text
    assert "guarantee not held for 0.40 s: uncertainty covered by ρ" in text
    assert (found[-1].time, found[-1].level, found[-1].text) == (4.0, "ERROR", "robust: ended: tipped")
    slides = next(event for event in found if "left wheel" in event.text)
    column = signals(1)["wheel.sliding.left"].to_pylist()
    assert slides.time == pytest.approx(column.index(True) * 0.01)


def test_violation_and_alarm_are_events_with_a_time() -> None:
    told = {
        "first_violation": "uncertainty_covered",
        "first_violation_time": 3.6,
        "first_violation_excess": 0.275,
    }
    found = events(track(signals(1), guarantee=told))
    first = next(event for event in found if "violated first" in event.text)
    assert (first.time, first.level) == (3.6, "WARN")
    assert first.text == "robust: guarantee violated first: uncertainty covered by ρ, at 3.60 s, by 28 %"
    alarms = [event for event in found if "slip alarm" in event.text]
    alarm = signals(1)["guarantee.alarm"].to_pylist()
    assert [event.time for event in alarms] == [pytest.approx(alarm.index(True) * 0.01)]
    assert alarms[0].level == "ERROR"


def test_amounts_start_at_zero_and_leave_room_above() -> None:
    time = np.linspace(0, 1, 11)
    assert from_zero([(time, 3 * time), (time, time)]) == pytest.approx((0.0, 4.2))
    assert from_zero([(time, 0.05 * time)]) == pytest.approx((0.0, 0.105))
    assert from_zero([(time, 0 * time)]) is None
    assert from_zero([(time, np.full(11, np.nan))]) is None


def test_the_legend_of_amounts_and_the_line_at_zero_have_room() -> None:
    driven = track(signals(1))
    layout = blueprint([driven], Scales(1.0, None), {"robust": "/runs/robust"}, sweep=False)
    top, checked = float(np.nanmax(driven.values("error.position"))), 0
    for view in views(layout.root_container):
        if str(view.name).startswith("Position error"):
            ((low, high),) = view.properties["ScalarAxis"].range.as_arrow_array().to_pylist()
            assert low < 0.0
            assert high >= 1.4 * top
            checked += 1
    assert checked == 2


def test_what_is_drawn_is_what_the_bound_is_on() -> None:
    table = signals(1)

    def drawn(uncertainty: str, **fields: Any) -> dict[str, np.ndarray]:
        theorem = Theorem(uncertainty, 0.3, 0.05, **fields)
        return {path: values for path, _, values in quantities(track(table, theorem=theorem))}

    along, across = (np.abs(table[f"slip.{name}"].to_numpy()) for name in ("longitudinal", "lateral"))
    speed = np.abs(table["motion.forward_speed"].to_numpy())
    assert np.array_equal(drawn("independent")["guarantee.size.v_t"], along)
    assert np.array_equal(drawn("independent")["guarantee.bound.slip"], 0.3 * speed)
    assert np.array_equal(drawn("independent")["guarantee.bound.w_s"], 0.3 * speed)
    assert np.allclose(drawn("paper")["guarantee.size.slip"], (along + across) / 2)
    assert np.allclose(drawn("slip_ratio")["guarantee.size.slip"], np.hypot(along, across) / np.sqrt(2))
    general = drawn("general", yaw_slip_bound=0.7, lateral_slip_bound=0.02)
    assert set(general["guarantee.bound.w_s"]) == {0.7}
    assert set(general["guarantee.bound.v_s"]) == {0.02}
    assert np.array_equal(general["guarantee.size.v_s"], across)
    assert quantities(track(table)) == []


def test_bounds_are_drawn_from_the_end_of_the_transient_and_only_where_promised() -> None:
    theorem = Theorem("independent", 0.3, 0.05)
    told: dict[str, Any] = {"settling_time": 2.0, "lyapunov_level": 0.1, "error_bound": 0.03}
    found = {
        path: values for path, _, values in quantities(track(signals(1), theorem=theorem, guarantee=told))
    }
    for path, value in (("guarantee.bound.error", 0.03), ("guarantee.bound.level", 0.1)):
        assert np.isnan(found[path][:200]).all()
        assert set(found[path][200:]) == {value}
    told["error_bound"] = None
    found = {path for path, _, _ in quantities(track(signals(1), theorem=theorem, guarantee=told))}
    assert not found & {"guarantee.bound.error", "guarantee.bound.level"}


def test_names_in_the_viewer_begin_with_what_differs() -> None:
    info = {"scenario": "friction-sweep", "scenario_id": "sha256:00ff", "varied": {"ground.friction": 0.1}}
    assert application_id(info) == "friction-0_1-friction-sweep-00ff"
    assert recording_name(info) == "friction 0.1"
    assert (application_id({"scenario": "belt"}), recording_name({"scenario": "belt"})) == (
        "slipctl-belt",
        "belt",
    )
