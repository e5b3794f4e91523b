"""Keys that the rest of a file leaves without effect: refused, neither swept nor dumped."""

from typing import Any

import pytest

from slipctl.scenario import dump, read, template
from slipctl.scenario.applies import ignored
from slipctl.scenario.grid import sweepable
from tests.scenario.documents import EIGHT, EXPERIMENT, PAPER, SCALED, TORQUE, changed, only, refused

BASE = changed(EIGHT, {"sweep": None})
ODE = changed(TORQUE, {"plant": {"kind": "dynamic_ode"}, "ground": None})


@pytest.mark.parametrize(
    ("document", "changes", "key"),
    [
        (PAPER, {"ground": {}}, "ground"),
        (PAPER, {"robot.torque_limit": 4.0}, "robot.torque_limit"),
        (ODE, {"ground": {}}, "ground"),
        (ODE, {"robot.compensate_wheels": True}, "robot.compensate_wheels"),
        (ODE, {"robot.wheel_inertia": 0.01}, "robot.wheel_inertia"),
        (BASE, {"robot.compensate_wheels": False}, "robot.compensate_wheels"),
        (BASE, {"robot.joint_friction": 0.1}, "robot.joint_friction"),
        (
            TORQUE,
            {"robot.compensate_wheels": False, "robot.wheel_inertia": 0.01},
            "robot.wheel_inertia",
        ),
        (BASE, {"sensing.acceleration": "true"}, "sensing.acceleration"),
        (BASE, {"sensing.acceleration_delay": 0.01}, "sensing.acceleration_delay"),
        (BASE, {"sensing.camera_rate": 3.0}, "sensing.camera_rate"),
        (BASE, {"sensing.camera_gain": 1.0}, "sensing.camera_gain"),
        (
            TORQUE,
            {"sensing": {"acceleration": "model", "acceleration_noise": 0.1}},
            "sensing.acceleration_noise",
        ),
        (PAPER, {"controller.1.believes": {"mass": 20.0}}, "controller[1:robust].believes.mass"),
        (PAPER, {"controller.0.time_scaled": False}, "controller[0:nominal_kinematic].time_scaled"),
        (EXPERIMENT, {"controller.0.time_scaled": True}, "controller[0:nominal_kinematic].time_scaled"),
        (TORQUE, {"controller.1.coupling_bound": 0.0}, "controller[1:robust_dynamic].coupling_bound"),
        (TORQUE, {"controller.1.yaw_slip_bound": 0.1}, "controller[1:robust_dynamic].yaw_slip_bound"),
    ],
)
def test_a_key_without_effect_is_refused(document, changes, key):
    assert refused(document) == []
    problem = only(changed(document, changes))
    assert problem.key == key
    assert "ignored" in problem.allowed


@pytest.mark.parametrize(
    ("document", "changes"),
    [
        (ODE, {"robot.torque_limit": 2.0}),
        (TORQUE, {"robot.wheel_inertia": 0.0, "robot.joint_friction": 0.1}),
        (TORQUE, {"sensing": {"acceleration": "imu", "acceleration_noise": 0.1, "acceleration_delay": 0.01}}),
        (TORQUE, {"controller.0.believes": {"mass": 20.0, "yaw_inertia": 0.5, "half_track": 0.2}}),
        (PAPER, {"controller.0.believes": {"wheel_radius": 0.08}}),
        (SCALED, {"controller.0.time_scaled": False, "controller.1.time_scaled": True}),
        (EXPERIMENT, {"sensing.camera_delay": 0.123, "sensing.camera_gain": 0.5}),
    ],
)
def test_the_same_keys_are_accepted_where_they_count(document, changes):
    assert refused(changed(document, changes)) == []


def swept_name(path, document):
    if path[0] != "controller":
        return ".".join(path)
    law = document["controller"][path[1]]
    return ".".join(["controller", law.get("label", law["kind"]), *path[2:]])


@pytest.mark.parametrize("document", [PAPER, BASE, ODE, TORQUE, EXPERIMENT, SCALED])
def test_what_is_refused_is_neither_swept_nor_dumped_nor_explained(document):
    keys, tables = sweepable(document), dump(read(document))
    assert ignored(document)
    for path in ignored(document):
        name = swept_name(path, document)
        table: Any = tables
        for step in path[:-1]:
            table = table[step] if isinstance(step, int) or step in table else {}
        assert path[-1] not in table
        assert name not in keys
        if len(path) == 1:
            assert not [key for key in keys if key.startswith(f"{name}.")]


def test_a_template_explains_only_what_counts(tmp_path):
    text = template("paper-kinematic", "mine")
    assert "# believes: " in text
    assert "{ wheel_radius, half_track }" in text
    for word in ("mass", "compensate", "camera_rate", "time_scaled =", "acceleration ="):
        assert word not in text
    assert "{ wheel_radius, half_track, mass, yaw_inertia }" in template("paper-dynamic", "mine")
    assert "# camera_gain = 1.0" in template("paper-experiment", "mine")


def test_a_swept_key_without_effect_is_told_apart_from_one_that_does_not_exist():
    problem = only(changed(BASE, {"sweep": {"sensing.camera_rate": [1.0, 3.0]}}))
    assert problem.found == "a key that would be ignored"
    assert "odometry_camera" in problem.allowed
    assert only(changed(PAPER, {"sweep": {"ground.film": [1.0]}})).found == "a key that would be ignored"
    law = "controller.robust.believes.mass"
    assert only(changed(PAPER, {"sweep": {law: [1.0]}})).found == "a key that would be ignored"
    assert "does not exist" in only(changed(BASE, {"sweep": {"sensing.camera": [1.0]}})).found
