"""Durations, tick counts and the slowest point of a path."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.scenario import load, read
from slipctl.scenario.path_speed import slowest
from slipctl.theory.reference import Placement, PointToPoint
from tests.scenario.documents import EIGHT, PAPER, TORQUE, changed, only, refused

ENDS_PARTS = (st.floats(-2, 2), st.floats(-2, 2), st.floats(-180, 180), st.floats(0.05, 1.0))
ENDS = st.tuples(*ENDS_PARTS)


def duration(reference):
    document = changed(EIGHT, {"reference": reference, "duration": None, "sweep": None})
    return read(document).duration


def test_durations_of_the_references():
    assert read(PAPER).duration == 20.0
    assert duration({"kind": "line", "speed": 0.5, "distance": 3.0}) == 6.0
    assert duration({"kind": "circle", "speed": 0.5, "radius": -1.5, "laps": 2}) == pytest.approx(
        12 * math.pi
    )
    assert duration({"kind": "circle", "speed": 0.5, "radius": 1.5}) == pytest.approx(6 * math.pi)
    assert read(EIGHT).duration == 4.0


@pytest.mark.parametrize("laps", [0.5, 1.0, 3.0])
def test_the_figure_eight_takes_its_laps_at_the_phase_speed_of_the_crossing(laps):
    length, speed = 2.0, 0.7
    total = duration({"kind": "figure_eight", "length": length, "speed": speed, "laps": laps})
    phase = np.linspace(0.0, 1e-6, 2)
    x, y = length / 2 * np.sin(phase), length / 4 * np.sin(2 * phase)
    per_phase = math.hypot(x[1] - x[0], y[1] - y[0]) / (phase[1] - phase[0])
    assert total == pytest.approx(laps * 2 * math.pi * per_phase / speed)


def test_the_number_of_ticks_is_rounded():
    assert load("paper-kinematic").ticks == 20_000
    assert load("friction-sweep").ticks == 889
    assert read(changed(PAPER, {"tick": 0.3, "duration": 1.0})).ticks == 3


@given(ENDS, ENDS, st.floats(0.5, 30.0))
def test_the_slowest_point_against_a_dense_search(start, goal, total):
    speed, time = slowest(start, goal, total)
    part = np.linspace(0.0, 1.0, 2001)
    square = np.zeros_like(part)
    for index, turn in ((0, math.cos), (1, math.sin)):
        v0, v1 = (end[3] * turn(math.radians(end[2])) for end in (start, goal))
        p0, p1 = start[index], goal[index]
        # Hermite basis, differentiated
        velocity = (
            (6 * part**2 - 6 * part) * (p0 - p1) / total
            + (3 * part**2 - 4 * part + 1) * v0
            + (3 * part**2 - 2 * part) * v1
        )
        square += velocity**2
    dense = np.sqrt(square)
    assert 0.0 <= time <= total
    assert speed <= dense.min() * (1 + 1e-9) + 1e-12
    nearby = np.interp(time / total, part, dense)
    assert speed == pytest.approx(nearby, rel=1e-2, abs=1e-2)


QUINTIC_ENDS = st.tuples(*ENDS_PARTS, st.floats(-1, 1), st.floats(-1, 1))


@given(QUINTIC_ENDS, QUINTIC_ENDS, st.floats(0.5, 30.0))
def test_the_slowest_point_of_a_quintic_against_the_planned_path(start, goal, total):
    speed, time = slowest(start, goal, total)
    first, last, still = np.array([start]), np.array([goal]), np.zeros(1)
    for end in (first, last):
        end[:, 2] = np.radians(end[:, 2])
    plan = PointToPoint(first, last, np.array([total]), Placement(still, still, still))
    velocity = plan.at(np.linspace(0.0, total, 2001)).velocity[0]
    dense = np.hypot(velocity[:, 0], velocity[:, 1])
    scale = dense.max()
    assert speed <= dense.min() + 1e-9 * scale
    there = plan.at(np.array([time])).velocity[0, 0]
    assert speed == pytest.approx(np.hypot(*there), abs=1e-9 * scale)


def test_nor_does_its_quintic():
    start, goal = (0, 0, 90, 0.15, 0, 0), (1.2, 1.5, 90, 0.15, 0, 0)
    assert slowest(start, goal, 20.0)[0] == pytest.approx(0.0937, abs=5e-5)


@pytest.mark.parametrize("end", ["start", "goal"])
@pytest.mark.parametrize("key", ["yaw_rate", "acceleration"])
def test_a_quintic_has_both_rates_at_both_ends(end, key):
    missing = only(changed(TORQUE, {f"reference.{end}.{key}": None}))
    assert missing.key == f"reference.{end}.{key}"
    assert "quintic" in missing.allowed
    alone = refused(changed(PAPER, {f"reference.{end}.{key}": 0.0}))
    assert len(alone) == 3
    assert f"reference.{end}.{key}" not in {problem.key for problem in alone}
    assert all(f"reference.{end}.{key}" in problem.found for problem in alone)


@pytest.mark.parametrize(("document", "quintic"), [(PAPER, False), (TORQUE, True)])
def test_quintics_are_told_from_cubics(document, quintic):
    reference = read(document).reference
    assert reference.kind == "point_to_point"
    assert reference.quintic is quintic


def test_table_one_never_slows_to_the_floor():
    assert slowest((0, 0, 90, 0.15), (1.2, 1.5, 90, 0.15), 20.0)[0] == pytest.approx(0.0937, abs=5e-5)


def test_a_path_that_stands_still_is_refused():
    back = {"reference.goal": {"x": 1.0, "y": 0.0, "speed": 0.15}, "reference.start.heading_deg": 0.0}
    assert refused_reason(changed(PAPER, {**back, "reference.duration": 100.0})).startswith(
        "a path that stands still"
    )
    assert refused_reason(changed(PAPER, back)) == "a path that stands still at t = 10 s"
    assert read(changed(PAPER, {**back, "reference.duration": 10.0})).duration == 10.0


@pytest.mark.parametrize("end", ["start", "goal"])
def test_ends_at_rest_are_refused(end):
    problem = only(changed(PAPER, {f"reference.{end}.speed": 0.0}))
    assert problem.key == f"reference.{end}.speed"
    assert problem.allowed == "a number > 0 [m/s]"


def refused_reason(document):
    problem = only(document)
    assert problem.key == "reference"
    assert "singular" in problem.allowed
    return problem.found
