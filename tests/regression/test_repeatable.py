"""The same machine gives the same numbers: ten times, on one to three threads, whatever is run beside."""

import pytest

from slipctl import experiment
from slipctl.regression import check, record
from slipctl.scenario import load

GRID = """
tick = 0.01
duration = 0.6
seed = 3
[robot]
model = "magellan_pro"
drive = "wheel_speed"
[plant]
kind = "mujoco"
timestep = 0.002
[ground]
friction = 0.8
[reference]
kind = "circle"
speed = 1.0
radius = 0.5
[sensing]
pose = "odometry_camera"
velocity = "odometry"
camera_rate = 20.0
camera_position_noise = 0.003
[[controller]]
kind = "nominal_kinematic"
pole = -2.0
[[controller]]
kind = "robust_kinematic"
pole = -2.0
slip_bound = 0.4
boundary_layer = 0.05
uncertainty = "independent"
[sweep]
"ground.friction" = [0.05, 0.1, 0.2, 0.4, 0.8, 1.0]
"""
"""Six worlds from ice, where the wheels slide, to grip; with noise."""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("grid") / "grid.toml"
    path.write_text(GRID, encoding="utf-8")
    record(str(path), "a test")
    return str(path)


def test_ten_repetitions_are_identical(scenario):
    first, *others = [check(scenario).findings for _ in range(10)]
    assert {finding.verdict.value for finding in first} == {"same"}
    assert all(finding.current == finding.baseline for finding in first)
    assert all(other == first for other in others)


@pytest.mark.parametrize("threads", [1, 2, 3])
def test_the_number_of_threads_changes_no_bit(scenario, threads):
    findings = check(scenario, threads=threads).findings
    assert len(findings) == 6 * 2 * 8
    assert all(finding.current == finding.baseline for finding in findings)


def test_every_signal_is_the_same_on_three_threads(scenario):
    one, three = (experiment.run(load(scenario), threads=threads).signals for threads in (1, 3))
    assert one.equals(three)
    assert one.num_rows == 6 * 2 * 61


def test_some_of_these_runs_slide(scenario):
    """Or the test would say nothing about runs after loss of traction."""
    findings = [f for f in check(scenario).findings if f.metric == "max_position_error"]
    worst = max(f.current for f in findings if isinstance(f.current, float))
    assert worst > 0.1
