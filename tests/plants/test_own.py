# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from slipctl.plants.errors import ModelError, UnusableModel
from slipctl.plants.model import adopted, compile_model, find_model, model_id, shapes
from slipctl.plants.own import OwnModel
from slipctl.plants.own.contacts import DAMPING, FRICTION_RATE, IMPEDANCE, SAG
from slipctl.plants.own.wheels import driven_joints
from slipctl.plants.standstill import inertia, settle
from slipctl.theory.robot import GRAVITY, WheelGeometry
from tests.plants.robots import (
    BRAKING_CASTER,
    FREE_CASTER,
    HALF_TRACK,
    MASS,
    RADIUS,
    SWIVEL_CASTER,
    mjcf,
    urdf,
    wheel,
    written,
)


def own(path: Path, **choice) -> OwnModel:
    return OwnModel(path, **choice)


def made(path: Path, **choice):
    found = adopted(own(path, **choice))
    assert found is not None
    return found


@pytest.mark.parametrize("turned", [0.0, 137.0])
def test_lengths_and_masses_are_those_of_the_file_wherever_it_puts_the_robot(tmp_path, turned):
    path = written(tmp_path, mjcf(turned=turned))
    model = compile_model(path)
    at_rest = settle(model)
    assert at_rest.wheel_radius == pytest.approx(RADIUS, rel=1e-4)
    assert at_rest.half_track == pytest.approx(HALF_TRACK, rel=1e-6)
    felt = inertia(model, WheelGeometry(at_rest.wheel_radius, at_rest.half_track))
    assert felt.mass == pytest.approx(MASS, rel=1e-9)
    # box about its own centre and displaced, wheels displaced and about a diameter, ball displaced
    hull = 4.0 * ((0.24**2 + 0.16**2) / 12.0 + 0.03**2)
    wheels = 2 * 0.1 * (HALF_TRACK**2 + (3 * RADIUS**2 + 0.03**2) / 12.0)
    ball = 0.1 * (0.15**2 + 0.4 * 0.02**2)
    assert felt.yaw_inertia == pytest.approx(hull + wheels + ball, rel=1e-6)
    # heading 0 in its own world, whatever it was in the file
    assert abs(at_rest.quaternion[3]) < 1e-6


def test_tyres_follow_the_stated_rule(tmp_path):
    model = compile_model(written(tmp_path, mjcf()))
    data = mujoco.MjData(model)
    at_rest = settle(model)
    data.qpos[2], data.qpos[3:7] = at_rest.height, at_rest.quaternion
    mujoco.mj_forward(model, data)
    for side in ("left", "right"):
        pair = model.pair(f"{side}_tyre")
        load = float(data.sensor(f"{side}_tyre_force").data[2])
        row = next(c.efc_address for c in data.contact if model.geom(f"{side}_tyre").id in c.geom)
        inverse_mass = data.efc_R[row] * IMPEDANCE / (1.0 - IMPEDANCE)
        stiffness = -pair.solref[0] / ((1.0 - IMPEDANCE) * inverse_mass)
        assert stiffness == pytest.approx(load / (SAG * RADIUS), rel=0.01)
        assert -pair.solref[1] / (2.0 * math.sqrt(-pair.solref[0])) == pytest.approx(DAMPING)
        assert model.pair_solreffriction[pair.id, 1] == pytest.approx(-FRICTION_RATE * IMPEDANCE)
        assert model.geom(f"wheel_{side}_geom".join(("own/", ""))).contype[0] == 0
    assert model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC
    assert model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert (model.opt.impratio, model.opt.timestep) == (1e6, 0.001)


def test_casters_carry_what_statics_gives_them(tmp_path):
    model = compile_model(written(tmp_path, mjcf()))
    data = mujoco.MjData(model)
    at_rest = settle(model)
    data.qpos[2], data.qpos[3:7] = at_rest.height, at_rest.quaternion
    mujoco.mj_forward(model, data)
    wheels = sum(float(data.sensor(f"{side}_tyre_force").data[2]) for side in ("left", "right"))
    behind = (4.0 * 0.03 + 0.1 * 0.15) / MASS
    assert wheels == pytest.approx(MASS * GRAVITY * (1.0 - behind / 0.15), rel=2e-3)


def test_a_turned_axis_is_turned_round(tmp_path):
    wheels = wheel("wheel_left", HALF_TRACK) + wheel("wheel_right", -HALF_TRACK, axis="0 0 -1")
    found = made(written(tmp_path, mjcf(wheels=wheels)))
    assert found.signs == (1, -1)
    assert any("right wheel was turned round" in note for note in found.notes)
    model = found.spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for side in ("left", "right"):
        assert data.joint(f"{side}_axle").xaxis == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_a_welded_urdf_gets_a_free_joint_and_keeps_its_mass(tmp_path):
    path = written(tmp_path, urdf(), "robot.urdf")
    as_it_comes = mujoco.MjModel.from_xml_path(str(path))
    assert (as_it_comes.nv, as_it_comes.body_mass.sum()) == (2, pytest.approx(0.2))
    found = made(path)
    assert found.free_joint == "added"
    assert any("welded to the world" in note for note in found.notes)
    model = compile_model(path, torque_limit=4.0)
    assert model.nv == 8
    assert model.body("base").subtreemass[0] == pytest.approx(MASS, rel=1e-9)
    # the effort limit of the joints holds below the scenario's
    assert model.actuator("left_wheel").forcerange.tolist() == [-2.0, 2.0]


def test_what_else_the_file_drives_is_held_and_its_surroundings_stay_behind(tmp_path):
    arm = '<body pos="0 0 0.08"><joint name="arm" axis="0 1 0"/><geom size="0.02" mass="0.1"/></body>'
    wall = '<geom type="plane" size="5 5 0.1"/><geom name="wall" type="box" size="0.1 1 1" pos="2 2 0"/>'
    extra = '<sensor><jointpos joint="arm"/></sensor><keyframe><key qpos="0 0 1 1 0 0 0 0 0 0"/></keyframe>'
    text = mjcf(
        caster=FREE_CASTER + arm, world=wall, extra=extra, actuators='<position name="a" joint="arm"/>'
    )
    found = made(written(tmp_path, text))
    assert any("held" in note and "arm" in note for note in found.notes)
    assert any("surroundings" in note for note in found.notes)
    model = found.spec.compile()
    assert [model.joint(j).name for j in range(model.njnt)] == ["base", "left_axle", "right_axle"]
    assert (model.nu, model.nkey) == (2, 0)
    assert "own/wall" not in [model.geom(g).name for g in range(model.ngeom)]


def test_wheels_driven_through_tendons_are_found(tmp_path):
    both = '<joint joint="wheel_left" coef="0.5"/><joint joint="wheel_right" coef="0.5"/>'
    extra = f'<tendon><fixed name="forward">{both}</fixed></tendon>'
    text = mjcf(extra=extra, actuators='<motor name="forward" tendon="forward"/>')
    found = made(written(tmp_path, text))
    assert found.joints == ("wheel_left", "wheel_right")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    assert driven_joints(model) == {model.joint("wheel_left").id, model.joint("wheel_right").id}
    assert not any("held" in note for note in found.notes)


def test_named_wheels_need_no_telling_names(tmp_path):
    text = mjcf(actuators="").replace("wheel_left", "a").replace("wheel_right", "b")
    path = written(tmp_path, text)
    with pytest.raises(UnusableModel, match=r"not obvious.*left_wheel.*'a', 'b'"):
        adopted(path)
    assert made(path, left_wheel="a", right_wheel="b").joints == ("a", "b")
    with pytest.raises(UnusableModel, match="no hinge joint 'c'"):
        adopted(own(path, left_wheel="a", right_wheel="c"))
    with pytest.raises(UnusableModel, match="same joint"):
        adopted(own(path, left_wheel="a", right_wheel="a"))


def test_a_swivelling_caster_stays_as_it_is(tmp_path):
    path = written(tmp_path, mjcf(caster=SWIVEL_CASTER))
    model = compile_model(path)
    assert {"own/swivel", "own/roll"} <= {model.joint(j).name for j in range(model.njnt)}
    assert settle(model).wheel_radius == pytest.approx(RADIUS, rel=1e-3)


SKID = "".join(
    wheel(f"{end}_{side}_wheel", y, x)
    for end, x in (("front", 0.1), ("rear", -0.1))
    for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK))
)
SKID_DRIVE = "".join(
    f'<velocity joint="{end}_{side}_wheel"/>' for end in ("front", "rear") for side in ("left", "right")
)
FRONT = {"left_wheel": "front_left_wheel", "right_wheel": "front_right_wheel"}


@pytest.mark.parametrize(
    ("text", "choice", "message"),
    [
        (mjcf(wheels=SKID, caster="", actuators=SKID_DRIVE), {}, "skidding"),
        (mjcf(wheels=SKID, caster="", actuators=SKID_DRIVE), FRONT, "4 wheels are driven"),
        (mjcf(wheels="", actuators=""), {}, "hinge joints: none"),
        (mjcf(wheels=wheel("wheel_left", 0.1), actuators=""), {}, "not obvious"),
        (mjcf(caster=""), {}, "does not stand still"),
        (mjcf().replace('axis="0 0 1"', 'axis="0 1 0"', 1), {}, "not parallel and level"),
        (mjcf().replace('axis="0 0 1"', 'axis="0 0 1" range="-90 90"', 1), {}, "is limited to"),
        (mjcf().replace('size="0.05 0.015"', 'size="0.05 0.015" contype="0" conaffinity="0"'), {}, "no geom"),
        (mjcf().replace('size="0.05 0.015"', 'size="0.04 0.015"', 1), {}, "radii of 0.04 and 0.05"),
        (
            mjcf(wheels=wheel("left_wheel", 0.1) + wheel("right_wheel", -0.1, 0.2), actuators=""),
            {},
            "side by",
        ),
    ],
)
def test_what_cannot_be_driven_is_refused_with_the_reason(tmp_path, text, choice, message):
    with pytest.raises(UnusableModel, match=message):
        compile_model(own(written(tmp_path, text), **choice))


@pytest.mark.parametrize(
    ("text", "name", "message"),
    [
        (urdf().replace('value="4.1"', 'value="${mass}"'), "robot.urdf", r"\$\{mass\} is a placeholder"),
        (urdf().replace("base_link", "$(arg base)"), "robot.urdf", "xacro"),
        (mjcf().replace("</mujoco>", ""), "robot.xml", "robot.xml"),
        (
            urdf().replace(
                '<sphere radius="0.02"/>', '<mesh filename="package://somebody/meshes/ball.stl"/>'
            ),
            "robot.urdf",
            "ball.stl of a collision geom is not beside",
        ),
    ],
)
def test_what_cannot_be_read_is_refused_with_the_reason(tmp_path, text, name, message):
    with pytest.raises(ModelError, match=message) as refused:
        adopted(written(tmp_path, text, name))
    assert not isinstance(refused.value, UnusableModel)


def test_a_mesh_that_is_only_seen_may_be_missing(tmp_path):
    seen = '<geom type="mesh" mesh="shell" contype="0" conaffinity="0" mass="0"/>'
    asset = '<asset><mesh name="shell" file="shell.stl"/></asset>'
    found = made(written(tmp_path, mjcf(caster=FREE_CASTER + seen, extra=asset)))
    assert any("shell.stl" in note for note in found.notes)
    assert found.mass_in_file == pytest.approx(MASS)


def test_kept_contacts_are_those_of_the_file(tmp_path):
    path = written(tmp_path, mjcf(option='cone="pyramidal"'))
    model = compile_model(own(path, keep_contacts=True))
    assert model.opt.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL
    assert model.opt.impratio == 1.0
    assert model.geom("left_tyre").type[0] == mujoco.mjtGeom.mjGEOM_CYLINDER
    assert model.pair("left_tyre").solref.tolist() == [0.02, 1.0]
    # b of MuJoCo's reference motion, 2/(d·timeconst), as before
    tyre = settle(model).tyre
    assert tyre.rate == pytest.approx(2.0 / (0.95 * 0.02))


def test_the_model_id_is_that_of_the_adopted_model(tmp_path):
    path = written(tmp_path, mjcf())
    copy = written(tmp_path, "<!-- said otherwise -->" + mjcf(), "copy.xml")
    assert model_id(path) == model_id(own(path)) == model_id(copy)
    other = written(tmp_path, mjcf().replace('mass="4"', 'mass="4.1"'), "other.xml")
    assert model_id(other) != model_id(path)
    assert model_id(own(path, keep_contacts=True)) != model_id(path)
    braking = written(tmp_path, mjcf(caster=BRAKING_CASTER), "braking.xml")
    assert model_id(own(braking, caster_friction=0.0)) != model_id(braking)


def test_a_model_written_for_slipctl_is_told_nothing(tmp_path):
    assert adopted(find_model("magellan_pro")) is None
    with pytest.raises(ModelError, match="written for slipctl"):
        adopted(own(find_model("magellan_pro"), left_wheel="left_axle"))


def test_a_viewer_sees_the_wheels_on_their_axles(tmp_path):
    drawn = shapes(compile_model(written(tmp_path, mjcf(turned=40.0))))
    hull = next(shape for shape in drawn if shape.kind == "box")
    assert (hull.body, hull.position.tolist()) == ("base", pytest.approx([-0.03, 0.0, 0.03], abs=1e-9))
    rims = [shape for shape in drawn if shape.kind == "cylinder"]
    assert sorted(shape.body for shape in rims) == ["left_wheel", "right_wheel"]
    for rim in rims:
        assert rim.position == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
        axis = np.zeros(3)
        mujoco.mju_rotVecQuat(axis, np.array([0.0, 0.0, 1.0]), rim.quaternion)
        assert np.abs(axis) == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)


def test_servos_are_as_quick_as_the_magellan_pro_s_and_make_up_for_damping(tmp_path):
    """The motor that a file without one gets makes (kv + damping)·timestep/(wheel inertia) 2.7, as there."""
    text = mjcf().replace('axis="0 0 1"', 'axis="0 0 1" damping="0.1"')
    model = compile_model(written(tmp_path, text))
    at_rest = settle(model)
    felt = inertia(model, WheelGeometry(at_rest.wheel_radius, at_rest.half_track))
    kv = -float(model.actuator("left_wheel").biasprm[2])
    assert float(model.actuator("left_wheel").gainprm[0]) == pytest.approx(kv + 0.1)
    assert (kv + 0.1) * 0.001 / felt.wheel_inertia == pytest.approx(2.7, rel=1e-6)
    turning = felt.yaw_inertia / HALF_TRACK**2
    assert (0.5 * RADIUS**2 * min(felt.mass, turning) + felt.wheel_inertia) / kv == pytest.approx(
        0.00291, rel=1e-3
    )
    data = mujoco.MjData(model)
    data.qpos[2], data.qpos[3:7] = at_rest.height, at_rest.quaternion
    data.ctrl[:] = 2.0
    for _ in range(500):
        mujoco.mj_step(model, data)
    assert data.joint("left_axle").qvel[0] == pytest.approx(2.0, rel=2e-3)
    assert made(written(tmp_path, text)).notes[-1].startswith("the file's motors have no inertia")


def test_a_motor_in_the_file_stays_as_it_is(tmp_path):
    text = mjcf().replace('axis="0 0 1"', 'axis="0 0 1" armature="0.002"')
    model = compile_model(written(tmp_path, text))
    assert model.joint("left_axle").armature[0] == 0.002
    assert not any("motors" in note for note in made(written(tmp_path, text)).notes)


def test_wheels_roll_on_the_middle_of_their_treads(tmp_path):
    """An axle that is off by 0.05 degrees, as -1.57 for a right angle, stands on one edge of its cylinder."""
    model = compile_model(written(tmp_path, mjcf().replace("-90 0 0", "-89.95 0 0")))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for side, y in (("left", HALF_TRACK), ("right", -HALF_TRACK)):
        assert data.geom(f"{side}_tyre").xpos[1] == pytest.approx(y, abs=1e-6)
