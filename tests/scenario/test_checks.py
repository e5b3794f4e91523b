"""Rules between keys, and that everything is reported at once."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.scenario import read
from slipctl.scenario.checks import TICK_LIMIT
from tests.scenario.documents import EIGHT, PAPER, changed, only, refused


def test_all_problems_come_at_once_those_between_keys_too():
    wrong = changed(
        PAPER,
        {
            "tik": 1,
            "tick": "0.01",
            "robot.speed_limit": -1,
            "ground.friction": 0.5,
            "plant.timestep": 0.001,
            "slip.yaw": float("nan"),
            "reference.start.speed": 0,
            "controller.0.label": "robust",
            "controller.1.slip_bound": 0.6,
            "controller.1.polle": 3,
            "sweep": {"slip.yawn": [1.0], "slip.yaw": []},
        },
    )
    assert {problem.key for problem in refused(wrong)} == {
        "tik",
        "tick",
        "robot.speed_limit",
        "ground",
        "plant.timestep",
        "slip.yaw",
        "reference.start.speed",
        "controller[1:robust].label",
        "controller[1:robust].slip_bound",
        "controller[1:robust].polle",
        "sweep.slip.yawn",
        "sweep.slip.yaw",
    }


def test_the_ode_has_no_floor_and_no_torques():
    assert only(changed(PAPER, {"ground": {}})).key == "ground"
    problem = only(changed(PAPER, {"robot.torque_limit": 4.0}))
    assert (problem.key, problem.found) == ("robot.torque_limit", "4.0")
    assert "ignore" in problem.allowed


def test_friction_is_given_once():
    both = only(changed(EIGHT, {"sweep": None, "ground.friction_left": 0.1, "ground.friction_right": 0.2}))
    assert both.key == "ground.friction"
    one = only(changed(EIGHT, {"sweep": None, "ground.friction": None, "ground.friction_left": 0.1}))
    assert one.key == "ground.friction_right"


def test_film_and_creep_exclude_each_other():
    assert only(changed(EIGHT, {"ground.creep_stiffness": 200.0})).key == "ground.film"


@pytest.mark.parametrize(
    ("tick", "timestep"), [(0.0105, 0.001), (0.0005, 0.001), (0.01, 0.0015), (0.001, 0.002)]
)
def test_the_tick_is_a_multiple_of_the_timestep(tick, timestep):
    problem = only(changed(EIGHT, {"tick": tick, "plant.timestep": timestep}))
    assert problem.key == "tick"
    assert f"plant.timestep ({timestep:g} s)" in problem.allowed


def test_the_default_timestep_counts():
    assert only(changed(EIGHT, {"tick": 0.0105, "plant": {"kind": "mujoco"}})).key == "tick"


@given(st.integers(1, 200), st.sampled_from([0.0005, 0.001, 0.002, 1 / 3000]))
def test_every_multiple_of_the_timestep_is_accepted(count, timestep):
    assert refused(changed(EIGHT, {"tick": count * timestep, "plant.timestep": timestep})) == []


def test_a_tick_is_no_longer_than_the_run():
    assert only(changed(PAPER, {"tick": 21.0})).allowed == "at most the reference's duration, 20 s"
    assert only(changed(PAPER, {"tick": 0.2, "duration": 0.1})).allowed == "at most duration, 0.1 s"
    assert only(changed(EIGHT, {"tick": 9.0, "duration": None, "reference.laps": 1})).key == "tick"
    assert refused(changed(PAPER, {"tick": 20.0})) == []


def test_a_run_has_a_bearable_number_of_ticks():
    assert f"{TICK_LIMIT:,}" in only(changed(PAPER, {"tick": 1e-9})).allowed


@pytest.mark.parametrize(
    ("uncertainty", "below", "at"),
    [("paper", 0.499, 0.5), ("independent", 0.499, 0.5), ("slip_ratio", 0.707, 0.7072)],
)
def test_the_slip_bound_stays_below_the_limit_of_its_uncertainty(uncertainty, below, at):
    robust = {"controller.1.uncertainty": uncertainty}
    assert refused(changed(PAPER, {**robust, "controller.1.slip_bound": below})) == []
    assert refused(changed(PAPER, {**robust, "controller.1.slip_bound": 0.0})) == []
    problem = only(changed(PAPER, {**robust, "controller.1.slip_bound": at}))
    assert problem.key == "controller[1:robust].slip_bound"
    assert uncertainty in problem.allowed
    assert only(changed(PAPER, {**robust, "controller.1.slip_bound": -0.1})).allowed == "a number ≥ 0 [1]"


def test_labels_are_unique_and_default_to_the_kind():
    twice = changed(PAPER, {"controller.1.label": "nominal_kinematic"})
    assert only(twice).key == "controller[1:nominal_kinematic].label"
    same = {"controller": [PAPER["controller"][0]] * 2}
    assert only(changed(PAPER, same)).found.startswith('"nominal_kinematic"')
    assert [law.label for law in read(PAPER).controller] == ["nominal_kinematic", "robust"]


def test_at_rest_needs_a_speed_floor():
    problem = only(changed(EIGHT, {"controller.0.speed_floor": 0}))
    assert problem.key == "controller[0:nominal_kinematic].speed_floor"
    assert "start.at_rest" in problem.found
    assert refused(changed(EIGHT, {"controller.0.speed_floor": 0.01})) == []


def test_the_speed_floor_lies_below_the_speed_limit():
    assert (
        only(changed(EIGHT, {"robot.speed_limit": 0.05})).key == "controller[0:nominal_kinematic].speed_floor"
    )


def test_a_circle_has_a_radius():
    circle = {"kind": "circle", "speed": 0.5, "radius": -1.0}
    assert refused(changed(EIGHT, {"reference": circle})) == []
    assert only(changed(EIGHT, {"reference": {**circle, "radius": 0}})).key == "reference.radius"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("controller.0.kind", "nominal_dynamic"),
        ("robot.drive", "wheel_torque"),
        ("plant.kind", "dynamic_ode"),
    ],
)
def test_a_controller_or_plant_that_does_not_fit_the_drive_is_told(key, value):
    fits = [
        str(problem) for problem in refused(changed(PAPER, {key: value})) if "does not fit" in problem.found
    ]
    assert fits
    assert all("wheel_speed" in text and "wheel_torque" in text for text in fits)


def test_a_model_by_path_must_be_there():
    problem = only(changed(PAPER, {"robot.model": "my/robot.xml"}))
    assert "my/robot.xml, where there is no file" in problem.found
