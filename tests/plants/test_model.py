# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

import hashlib
import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from slipctl.plants.model import ModelError, compile_model, find_model, model_id, shapes
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.standstill import settle
from tests.plants.driving import MASS, WEIGHT, ground

SHIPPED = find_model("magellan_pro")


def saved(model: mujoco.MjModel) -> bytes:
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(SHIPPED))


@pytest.fixture(scope="module")
def resting(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def edited(folder: Path, old: str, new: str) -> Path:
    text = SHIPPED.read_text(encoding="utf-8")
    assert old in text
    path = folder / "edited.xml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


def normal_row(model: mujoco.MjModel, data: mujoco.MjData, pair: str) -> int:
    geoms = {int(model.pair(pair).geom1[0]), int(model.pair(pair).geom2[0])}
    return next(c.efc_address for c in data.contact[: data.ncon] if {c.geom1, c.geom2} == geoms)


def test_mass_and_yaw_inertia_are_those_of_the_paper(model: mujoco.MjModel, resting: mujoco.MjData) -> None:
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, resting, inertia)
    assert np.diag(inertia)[:3] == pytest.approx([18.2] * 3, rel=1e-6)
    assert inertia[5, 5] == pytest.approx(0.39375, rel=1e-6)
    # with the centre of mass above the axle's midpoint, turning and driving do not couple
    assert np.abs(inertia[5, :5]).max() < 1e-9
    assert np.abs(inertia[5, 6:]).max() < 1e-9


def test_lengths_are_those_of_the_paper(model: mujoco.MjModel) -> None:
    standstill = settle(model)
    assert (standstill.wheel_radius, standstill.half_track) == (0.0825, 0.1624)
    assert model.geom("left_rim").size[0] == 0.0825
    assert model.body("left_wheel").pos.tolist() == [0.0, 0.1624, 0.0]
    assert model.body("right_wheel").pos.tolist() == [0.0, -0.1624, 0.0]


def test_centre_of_mass_is_above_the_axle_ten_centimetres_over_the_floor(
    model: mujoco.MjModel, resting: mujoco.MjData
) -> None:
    assert resting.subtree_com[model.body("base").id] == pytest.approx([0.0, 0.0, 0.10], abs=5e-4)


def test_wheels_feel_like_twelve_percent_of_the_mass(model: mujoco.MjModel, resting: mujoco.MjData) -> None:
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, resting, inertia)
    assert 2.0 * inertia[6, 6] / 0.0825**2 / MASS == pytest.approx(0.12, abs=0.005)


def test_tyres_have_the_stiffness_and_damping_that_the_file_claims(
    model: mujoco.MjModel, resting: mujoco.MjData
) -> None:
    for name, stiffness in (
        ("left_tyre", 1e5),
        ("right_tyre", 1e5),
        ("front_caster", 4e3),
        ("rear_caster", 4e3),
    ):
        pair = model.pair(name)
        d = pair.solimp[0]
        inverse_mass = resting.efc_R[normal_row(model, resting, name)] * d / (1.0 - d)
        assert -pair.solref[0] / ((1.0 - d) * inverse_mass) == pytest.approx(stiffness, rel=1e-6)
        assert -pair.solref[1] / (2.0 * math.sqrt(-pair.solref[0])) == pytest.approx(0.4, rel=1e-6)


def test_pressing_a_tyre_deeper_gives_the_stiffness(model: mujoco.MjModel) -> None:
    data = mujoco.MjData(model)
    force = []
    for depth in (0.0, 1e-4):
        mujoco.mj_resetData(model, data)
        data.qpos[2] -= depth
        # with the robot's acceleration held at zero only the spring is left
        mujoco.mj_inverse(model, data)
        force.append(data.qfrc_constraint[2])
    assert (force[1] - force[0]) / 1e-4 == pytest.approx(2 * 1e5 + 2 * 4e3, rel=1e-3)


def test_friction_takes_slip_away_at_800_per_second(model: mujoco.MjModel) -> None:
    tyre = settle(model).tyre
    assert tyre.rate == pytest.approx(800.0, rel=1e-12)
    assert (tyre.impedance, tyre.impratio) == (0.002, 1e6)
    assert tyre.inverse_mass == pytest.approx([model.body("left_wheel").invweight0[0]] * 2, rel=1e-9)


def test_at_rest_the_file_is_in_balance_and_the_casters_carry_a_fifth(
    model: mujoco.MjModel, resting: mujoco.MjData
) -> None:
    assert np.abs(resting.qacc).max() < 1e-3
    wheels = [resting.sensor(f"{side}_tyre_force").data[2] for side in ("left", "right")]
    assert wheels == pytest.approx([0.4 * WEIGHT] * 2, rel=1e-4)
    standstill = settle(model)
    assert standstill.height == pytest.approx(model.body("base").pos[2], abs=1e-8)
    # the tyre's geom is larger than the wheel by half of what the weight presses it in
    assert model.geom("left_tyre").size[0] - 0.0825 == pytest.approx(0.5 * 0.4 * WEIGHT / 1e5, abs=1e-8)


def test_servos_are_those_of_the_file(model: mujoco.MjModel) -> None:
    for side in ("left", "right"):
        servo = model.actuator(f"{side}_wheel")
        assert (servo.gainprm[0], servo.biasprm[2]) == (20.0, -20.0)
        assert servo.forcerange.tolist() == [-4.0, 4.0]
        assert model.actuator_trnid[servo.id, 0] == model.joint(f"{side}_axle").id
    assert model.npair == 4
    assert not model.geom_contype.any()


def test_default_scenario_is_the_shipped_model_byte_for_byte(model: mujoco.MjModel) -> None:
    assert saved(compile_model(SHIPPED, timestep=0.001, torque_limit=4.0)) == saved(model)
    plant = MujocoPlant.build(ground=ground())
    assert saved(plant.batch.get_model(0)) == saved(model)
    other = MujocoPlant.build(ground=ground(friction=0.7))
    assert saved(other.batch.get_model(0)) != saved(model)


def test_model_id_hashes_what_was_compiled(model: mujoco.MjModel, tmp_path: Path) -> None:
    assert model_id(SHIPPED) == "sha256:" + hashlib.sha256(saved(model)).hexdigest()
    copy = tmp_path / "copy.xml"
    copy.write_bytes(SHIPPED.read_bytes())
    assert model_id(copy) == model_id(SHIPPED)
    assert model_id(edited(tmp_path, 'kv="20"', 'kv="21"')) != model_id(SHIPPED)
    # a comment is not part of the model
    assert model_id(edited(tmp_path, "<worldbody>", "<!-- said otherwise --><worldbody>")) == model_id(
        SHIPPED
    )


def test_model_id_is_that_of_the_file_whatever_the_scenario_edits() -> None:
    plant = MujocoPlant.build(ground=ground(friction=0.1, slope_deg=3.0), timestep=0.002, torque_limit=2.0)
    assert plant.model_id == model_id(SHIPPED)
    assert plant.batch.model.opt.timestep == 0.002
    assert plant.batch.model.actuator("left_wheel").forcerange.tolist() == [-2.0, 2.0]


def test_torque_drive_gives_the_torque_it_is_told_up_to_the_limit() -> None:
    model = compile_model(SHIPPED, speed_drive=False, torque_limit=3.0)
    data = mujoco.MjData(model)
    # at a wheel speed that a servo would brake
    data.joint("left_axle").qvel[:] = 7.0
    data.ctrl[:] = [2.0, -5.0]
    mujoco.mj_forward(model, data)
    assert data.actuator("left_wheel").force[0] == 2.0
    assert data.actuator("right_wheel").force[0] == -3.0
    with pytest.raises(ModelError, match="torque limit"):
        compile_model(SHIPPED, speed_drive=False)


def test_only_a_moving_floor_is_compiled_to_move() -> None:
    assert not compile_model(SHIPPED).flg_surfacevel
    assert compile_model(SHIPPED, moving_floor=True).flg_surfacevel


def test_a_model_may_be_a_path(tmp_path: Path) -> None:
    path = edited(tmp_path, 'mass="16.2"', 'mass="20.0"')
    plant = MujocoPlant.build(str(path), ground=ground())
    assert plant.batch.model.body("base").subtreemass[0] == 22.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<geom name="floor"', '<geom name="ground"', r"no geom named 'floor' \(there are: .*ground"),
        ("<mujoco model", "<mujoko model", "edited.xml"),
        ('integrator="implicitfast"', 'integrator="fast"', "edited.xml"),
        ('solreffriction="-1e-9 -1.6"', "", "direct format"),
        ('pos="0 0 0.082142916"', 'pos="0 0 50"', "come to rest"),
        (
            'name="left_wheel" pos="0 0.1624 0"',
            'name="left_wheel" pos="0 0.1624 0.1"',
            "tyre does not touch the floor",
        ),
    ],
)
def test_unusable_models_are_refused_with_the_reason(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    text = SHIPPED.read_text(encoding="utf-8")
    if old.startswith("<geom name"):
        text = text.replace('geom1="floor"', 'geom1="ground"')
    path = tmp_path / "edited.xml"
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ModelError, match=message):
        MujocoPlant.build(path, ground=ground())


def test_missing_files_are_refused(tmp_path: Path) -> None:
    for name in ("no_such_robot", str(tmp_path / "robot.xml"), tmp_path):
        with pytest.raises(ModelError, match="no model file"):
            find_model(name)


def test_a_physics_step_too_long_for_the_tyres_is_refused() -> None:
    MujocoPlant.build(ground=ground(), timestep=0.002)
    with pytest.raises(ModelError, match=r"must stay below 0\.0025 s"):
        MujocoPlant.build(ground=ground(), timestep=0.005)


def test_a_viewer_gets_the_body_and_not_the_collision_spheres(model: mujoco.MjModel) -> None:
    drawn = shapes(model)
    assert {shape.body for shape in drawn} == {"base", "left_wheel", "right_wheel"}
    round_red = [s for s in drawn if s.kind == "cylinder" and s.rgba[0] > 0.5 > s.rgba[1]]
    assert round_red
    assert all(s.body == "base" for s in round_red)
    wheels = [s for s in drawn if s.body == "left_wheel"]
    assert {s.kind for s in wheels} == {"cylinder", "box"}
    rim = max(wheels, key=lambda s: s.size[0])
    assert rim.size[0] == 0.0825
    # the cylinder's axis, z in its own frame, lies along the axle
    axis = np.zeros(3)
    mujoco.mju_rotVecQuat(axis, np.array([0.0, 0.0, 1.0]), rim.quaternion)
    assert np.abs(axis) == pytest.approx([0.0, 1.0, 0.0], abs=1e-9)
    casters = [s for s in drawn if s.kind == "sphere"]
    assert sorted(s.position[0] for s in casters) == [-0.168, 0.168]
