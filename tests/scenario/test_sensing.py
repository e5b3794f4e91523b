"""What the controller sees: sources, camera, noise and delays."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.scenario import read
from slipctl.scenario.sensing import Sensing
from tests.scenario.documents import EXPERIMENT, PAPER, TORQUE, changed, only, refused

NUMBERS = [name for name, field in Sensing.model_fields.items() if field.annotation is float]


def test_every_key_arrives():
    given = EXPERIMENT["sensing"]
    sensing = read(EXPERIMENT).sensing
    assert {key: getattr(sensing, key) for key in given} == given


def test_the_default_is_the_truth_at_once():
    sensing = read(PAPER).sensing
    assert (sensing.pose, sensing.velocity, sensing.acceleration) == ("true", "true", "true")
    assert {getattr(sensing, name) for name in NUMBERS if name != "camera_gain"} == {0.0}
    assert sensing.camera_gain == 1.0
    assert sensing.camera_rate is None


def test_a_camera_has_a_rate():
    problem = only(changed(EXPERIMENT, {"sensing.camera_rate": None}))
    assert (problem.key, problem.allowed) == ("sensing.camera_rate", "a number > 0 [Hz]")
    assert only(changed(EXPERIMENT, {"sensing.camera_rate": 0.0})).key == "sensing.camera_rate"
    assert only(changed(EXPERIMENT, {"sensing.camera_rate": 21.0})).allowed == "at most one fix a tick, 20 Hz"
    assert refused(changed(EXPERIMENT, {"sensing.camera_rate": 20.0})) == []


@pytest.mark.parametrize("name", [name for name in NUMBERS if "acceleration" not in name])
def test_numbers_have_ranges(name):
    problem = only(changed(EXPERIMENT, {f"sensing.{name}": -0.1}))
    assert problem.key == f"sensing.{name}"
    assert problem.allowed.startswith("a number ")


@pytest.mark.parametrize("name", ["acceleration_noise", "acceleration_delay"])
def test_those_of_the_acceleration_too(name):
    assert only(changed(TORQUE, {f"sensing.{name}": -0.1})).key == f"sensing.{name}"


@pytest.mark.parametrize("gain", [0.0, 1.01])
def test_a_fix_corrects_a_share(gain):
    assert only(changed(EXPERIMENT, {"sensing.camera_gain": gain})).allowed == "a number > 0 and ≤ 1 [1]"


@given(st.integers(0, 200), st.sampled_from([0.05, 0.01, 0.3, 0.013]))
def test_every_multiple_of_the_tick_is_a_delay(count, tick):
    document = changed(EXPERIMENT, {"tick": tick, "sensing.camera_rate": 1.0})
    delays = {"sensing.pose_delay": count * tick, "sensing.velocity_delay": count * tick}
    wrong = {problem.key for problem in refused(changed(document, delays))}
    assert wrong == (set(delays) if count * tick > 10.0 else set())


@given(st.integers(0, 100), st.floats(0.01, 0.99))
def test_a_delay_between_two_ticks_is_refused_with_both(count, part):
    delay = (count + part) * 0.05
    problem = only(changed(EXPERIMENT, {"sensing.pose_delay": delay}))
    assert problem.key == "sensing.pose_delay"
    assert f"such as {count * 0.05:.9g} or {(count + 1) * 0.05:.9g} s" in problem.allowed


def test_a_swept_tick_that_a_delay_does_not_fit():
    problem = only(changed(EXPERIMENT, {"sweep": {"tick": [0.05, 0.04]}, "sensing.velocity_delay": 0.0}))
    assert (problem.key, "tick = 0.04" in problem.found) == ("sensing.pose_delay", True)


@pytest.mark.parametrize(
    ("key", "wrong", "meant"),
    [("pose", "odometry_kamera", "odometry_camera"), ("velocity", "differentiate", "differentiated")],
)
def test_a_misspelt_source(key, wrong, meant):
    assert only(changed(EXPERIMENT, {f"sensing.{key}": wrong})).nearest == meant
    assert only(changed(TORQUE, {"sensing.acceleration": "imuu"})).nearest == "imu"


def test_sensing_can_be_swept():
    grid = {"sensing.camera_rate": [1.0, 3.0], "sensing.velocity_noise": [0.0, 0.01]}
    assert refused(changed(EXPERIMENT, {"sweep": grid})) == []
