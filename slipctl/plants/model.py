"""The robot as MuJoCo sees it: find the file, edit what varies in structure, compile, read back."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from slipctl import shipped
from slipctl.tick import Array, Shape

WHEELS = ("left", "right")

_GEOM_KINDS = {
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}


class ModelError(ValueError):
    """A model file that cannot be read, or that lacks a part slipctl needs."""


def find_model(model: str | Path) -> Path:
    """Return the file of a model given by path or by the name of a shipped one.

    Parameters
    ----------
    model : str or Path
        ``magellan_pro`` or the path of an MJCF or URDF file.

    Raises
    ------
    ModelError
        If there is no such file.
    """
    path = Path(model)
    if not path.suffix and len(path.parts) == 1:
        path = Path(shipped.model_path(str(model)))
    if not path.is_file():
        raise ModelError(f"no model file at {path}")
    return path


def load_spec(path: Path) -> mujoco.MjSpec:
    """Return the editable model of a file.

    Raises
    ------
    ModelError
        If MuJoCo cannot read the file, or it has no part of a name that slipctl needs.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error
    needed = {
        "body": (spec.bodies, ["base", "left_wheel", "right_wheel"]),
        "geom": (spec.geoms, ["floor"]),
        "joint": (spec.joints, ["left_axle", "right_axle"]),
        "actuator": (spec.actuators, ["left_wheel", "right_wheel"]),
        "pair": (spec.pairs, ["left_tyre", "right_tyre"]),
        "sensor": (
            spec.sensors,
            [
                "left_tyre_force",
                "right_tyre_force",
                "left_wheel_torque",
                "right_wheel_torque",
                "forward",
                "velocity",
            ],
        ),
    }
    missing = []
    for kind, (elements, names) in needed.items():
        found = {element.name for element in elements}
        missing += [
            f"no {kind} named {name!r} (there are: {', '.join(sorted(found - {''})) or 'none'})"
            for name in names
            if name not in found
        ]
    if missing:
        raise ModelError(f"{path}: " + "; ".join(missing))
    return spec


def _compiled(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error


def compile_model(
    path: Path,
    timestep: float | None = None,
    speed_drive: bool = True,
    torque_limit: float | None = None,
    moving_floor: bool = False,
) -> mujoco.MjModel:
    """Compile a model with the edits that change its structure.

    Parameters
    ----------
    path : Path
    timestep : float, optional
        Physics step [s]; the file's own by default.
    speed_drive : bool
        Keep the file's wheel speed servos; otherwise replace them by torque motors.
    torque_limit : float, optional
        Largest wheel torque [N·m]; the file's own by default. Torque motors need one.
    moving_floor : bool
        Compile a floor whose surface may be moved later. MuJoCo ignores a surface velocity that is written
        into a model compiled without any, so it gets one of 1e-12 m/s.

    Raises
    ------
    ModelError
        If the file cannot be read or compiled, or a torque drive has no torque limit.
    """
    spec = load_spec(path)
    if timestep is not None:
        spec.option.timestep = timestep
    for side in WHEELS:
        actuator = spec.actuator(f"{side}_wheel")
        if not speed_drive:
            if torque_limit is None:
                raise ModelError(f"{path}: a torque drive needs a torque limit")
            actuator.set_to_motor()
            actuator.ctrlrange = [-torque_limit, torque_limit]
        if torque_limit is not None:
            actuator.forcerange = [-torque_limit, torque_limit]
    if moving_floor:
        spec.geom("floor").surfacevel = [1e-12, 0.0, 0.0, 0.0, 0.0, 0.0]
    return _compiled(spec, path)


def model_id(path: Path) -> str:
    """Return ``sha256:…`` of the compiled model as it stands in the file, before any edit."""
    model = _compiled(load_spec(path), path)
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return "sha256:" + hashlib.sha256(buffer.tobytes()).hexdigest()


@dataclass(frozen=True)
class Tyre:
    """The wheel contact as compiled, and what follows from it.

    In stick MuJoCo's friction force is C·(slip velocity) − (C/b_t)·(contact acceleration), with
    C = b_t·impratio/R: a viscous film of C newton-seconds per metre, very stiff at the model's own impratio.

    Attributes
    ----------
    softness : (2,) array
        R = A(1−d)/d of the normal direction, left and right [1/kg], A the inverse mass at the contact and d
        the impedance.
    rate : float
        b_t, at which MuJoCo's reference motion takes slip away [1/s].
    impedance : float
        d of the friction directions [1].
    impratio : float
        MuJoCo's ratio of frictional to normal impedance in the model file [1].
    """

    softness: Array
    rate: float
    impedance: float
    impratio: float

    @property
    def largest_film(self) -> Array:
        """C at the model's own impratio, left and right [N·s/m]: what a wheel in grip creeps at."""
        return self.rate * self.impratio / self.softness

    @property
    def inverse_mass(self) -> Array:
        """A = R·d/(1−d), left and right [1/kg]."""
        return self.softness * self.impedance / (1.0 - self.impedance)


@dataclass(frozen=True)
class Standstill:
    """The robot at rest on flat ground, in balance.

    Attributes
    ----------
    height : float
        z of the body origin [m].
    quaternion : (4,) array
        Orientation, w, x, y, z.
    wheel_radius : float
        From the axle down to the contact point, to 1e-9 [m].
    half_track : float
        Half the distance between the wheels, to 1e-9 [m].
    tyre : Tyre
    """

    height: float
    quaternion: Array
    wheel_radius: float
    half_track: float
    tyre: Tyre


def settle(model: mujoco.MjModel, duration: float = 2.0) -> Standstill:
    """Let the robot come to rest where the model file puts it, wheels held, and read the contacts back.

    Parameters
    ----------
    model : MjModel
    duration : float
        How long to wait for rest at most [s].

    Raises
    ------
    ModelError
        If the robot does not come to rest on both wheels, or its friction would be unstable at the timestep.
    """
    data = mujoco.MjData(model)
    steps = round(duration / model.opt.timestep)
    for step in range(steps):
        mujoco.mj_step(model, data)
        if step * model.opt.timestep > 0.1 and np.abs(data.qvel).max() < 1e-9:
            break
    mujoco.mj_forward(model, data)
    if not np.isfinite(data.qpos).all() or np.abs(data.qvel).max() > 1e-3:
        raise ModelError(f"the robot does not come to rest within {duration} s where its model file puts it")

    base = model.body("base").id
    root = model.jnt_qposadr[model.body_jntadr[base]]
    radius, softness = [], []
    for side in WHEELS:
        tyre = model.pair(f"{side}_tyre")
        touching = [
            c for c in data.contact[: data.ncon] if {c.geom1, c.geom2} == {tyre.geom1[0], tyre.geom2[0]}
        ]
        if not touching or touching[0].efc_address < 0:
            raise ModelError(f"the {side} tyre does not touch the floor at rest")
        wheel = data.body(f"{side}_wheel")
        radius.append(wheel.xpos[2] - touching[0].pos[2])
        softness.append(data.efc_R[touching[0].efc_address])
    pair = model.pair("left_tyre")
    impedance = float(pair.solimp[0])
    friction_damping = float(model.pair_solreffriction[pair.id, 1])
    if friction_damping >= 0.0:
        raise ModelError(
            "the tyre pairs need solreffriction in the direct format: -1e-9 and minus b_t times d"
        )
    rate = -friction_damping / float(pair.solimp[1])
    if rate * model.opt.timestep >= 2.0:
        raise ModelError(
            f"a physics step of {model.opt.timestep} s is too long for tyres that take slip away "
            f"at {rate:.0f}/s; it must stay below {2.0 / rate:g} s"
        )
    apart = np.asarray(data.body("left_wheel").xpos - data.body("right_wheel").xpos)
    return Standstill(
        height=float(data.qpos[root + 2]),
        quaternion=np.array(data.qpos[root + 3 : root + 7]),
        wheel_radius=round(float(radius[0] + radius[1]) / 2.0, 9),
        half_track=round(float(np.sqrt((apart * apart).sum())) / 2.0, 9),
        tyre=Tyre(
            softness=np.array(softness),
            rate=rate,
            impedance=impedance,
            impratio=float(model.opt.impratio),
        ),
    )


def shapes(model: mujoco.MjModel) -> list[Shape]:
    """Return what a viewer draws of the robot: its geoms in the groups shown by default, 0–2."""
    bodies = {model.body(name).id: name for name in ("base", "left_wheel", "right_wheel")}
    drawn = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if body not in bodies or model.geom_group[geom] > 2:
            continue
        material = int(model.geom_matid[geom])
        colour = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
        drawn.append(
            Shape(
                body=bodies[body],
                kind=_GEOM_KINDS[mujoco.mjtGeom(model.geom_type[geom])],
                size=np.array(model.geom_size[geom]),
                position=np.array(model.geom_pos[geom]),
                quaternion=np.array(model.geom_quat[geom]),
                rgba=np.array(colour, dtype=np.float64),
            )
        )
    return drawn
