"""The dynamic laws' bounds, and starts that a law cannot make."""

from math import hypot

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.scenario import read
from tests.scenario.documents import SCALED, TORQUE, changed, only, refused

BOUNDS = {
    "yaw_slip_bound": 0.1,
    "lateral_slip_bound": 0.05,
    "lateral_slip_rate_bound": 0.02,
    "lateral_slip_acceleration_bound": 0.01,
}
GENERAL = changed(
    TORQUE,
    {
        "controller.1.uncertainty": "general",
        **{f"controller.1.{key}": value for key, value in BOUNDS.items()},
    },
)


def test_dynamic_laws_are_read():
    nominal, robust = read(TORQUE).controller
    assert (nominal.kind, nominal.speed_floor, nominal.believes.mass) == ("nominal_dynamic", 0.05, None)
    assert robust.kind == "robust_dynamic"
    assert (robust.slip_bound, robust.uncertainty, robust.coupling_bound) == (0.3, "proportional", 0.0)
    assert (robust.believes.wheel_radius, robust.believes.half_track) == (0.08, 0.17)
    assert (robust.believes.mass, robust.believes.yaw_inertia) == (20.0, 0.3)
    general = read(GENERAL).controller[1]
    assert general.kind == "robust_dynamic"
    assert {key: getattr(general, key) for key in BOUNDS} == BOUNDS


@pytest.mark.parametrize("form", ["paper", "proportional"])
def test_the_slip_bound_of_a_dynamic_law_stays_below_one_half(form):
    law = {"controller.1.uncertainty": form}
    assert refused(changed(TORQUE, {**law, "controller.1.slip_bound": 0.499})) == []
    problem = only(changed(TORQUE, {**law, "controller.1.slip_bound": 0.5}))
    assert problem.key == "controller[1:robust_dynamic].slip_bound"
    assert form in problem.allowed


@pytest.mark.parametrize("key", BOUNDS)
def test_the_general_form_needs_all_its_bounds(key):
    problem = only(changed(GENERAL, {f"controller.1.{key}": None}))
    assert problem.key == f"controller[1:robust_dynamic].{key}"
    assert "general" in problem.found
    assert only(changed(GENERAL, {f"controller.1.{key}": -0.1})).allowed.startswith("a number ≥ 0")
    assert refused(changed(GENERAL, {f"controller.1.{key}": 0})) == []


@given(st.floats(0, 1.5), st.floats(0, 1.5))
def test_the_general_form_needs_a_small_gain(bound, coupling):
    document = changed(GENERAL, {"controller.1.slip_bound": bound, "controller.1.coupling_bound": coupling})
    problems = refused(document)
    assert bool(problems) == (hypot(coupling, bound + coupling) >= 1)
    assert {problem.key for problem in problems} <= {"controller[1:robust_dynamic].slip_bound"}


def test_a_dynamic_law_starts_from_rest_with_a_speed_floor_only():
    rest = {"start": {"at_rest": True}}
    assert refused(changed(TORQUE, rest)) == []
    problem = only(changed(TORQUE, {**rest, "controller.1.speed_floor": 0}))
    assert problem.key == "controller[1:robust_dynamic].speed_floor"
    assert refused(changed(TORQUE, {"controller.1.speed_floor": 0})) == []


def test_only_a_law_in_real_time_needs_a_floor_from_rest_to_rest():
    assert refused(changed(SCALED, {"controller.0.speed_floor": 0})) == []
    assert only(changed(SCALED, {"controller.1.speed_floor": 0})).key == "controller[1:floor].speed_floor"


def test_laws_run_in_the_path_s_time_unless_told_otherwise():
    assert [getattr(law, "time_scaled", None) for law in read(SCALED).controller] == [True, False]
    plain = read(changed(SCALED, {"reference.time_scaling": False, "controller.1.time_scaled": None}))
    assert not any(getattr(law, "time_scaled", None) for law in plain.controller)


def test_time_scaling_is_not_for_torques_nor_for_other_paths():
    assert only(changed(TORQUE, {"reference.time_scaling": True})).key == "reference.time_scaling"
    line = {"kind": "line", "speed": 0.2, "distance": 2.0, "time_scaling": True}
    problem = only(changed(SCALED, {"reference": line, "controller.1.time_scaled": None}))
    assert problem.key == "reference.time_scaling"
    assert "point_to_point" in problem.found


@pytest.mark.parametrize(
    ("changes", "keys"),
    [
        ({"plant": {"kind": "kinematic_ode"}, "ground": None, "robot.torque_limit": None}, {"plant.kind"}),
        (
            {"robot.drive": "wheel_speed"},
            {"controller[0:nominal_dynamic].kind", "controller[1:robust_dynamic].kind"},
        ),
        (
            {"robot.drive": "wheel_speed", "plant": {"kind": "dynamic_ode"}, "ground": None},
            {"plant.kind", "controller[0:nominal_dynamic].kind", "controller[1:robust_dynamic].kind"},
        ),
        (
            {"controller.0": {"kind": "nominal_kinematic", "pole": -1.0}},
            {"controller[0:nominal_kinematic].kind"},
        ),
    ],
)
def test_what_does_not_fit_the_drive(changes, keys):
    problems = refused(changed(TORQUE, changes))
    assert {problem.key for problem in problems} == keys
    assert all("does not fit" in problem.found for problem in problems)


def test_a_belief_in_the_wrong_place_is_sent_to_the_right_one():
    assert only(changed(TORQUE, {"controller.0.yaw_inertia": 0.3})).nearest == "believes.yaw_inertia"
    assert only(changed(TORQUE, {"controller.1.believes.mas": 3.0})).nearest == "mass"
    assert only(changed(TORQUE, {"controller.1.believes.mass": 0.0})).allowed == "a number > 0 [kg]"
