"""The robot as MuJoCo sees it: find the file, edit what varies in structure, compile, read back."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import difflib
import hashlib
from functools import lru_cache
from pathlib import Path
from typing import overload

import mujoco
import numpy as np

from slipctl import shipped
from slipctl.plants.errors import ModelError
from slipctl.plants.own import Adopted, OwnModel, adopt
from slipctl.plants.own.reading import quiet
from slipctl.plants.relief import give_planes
from slipctl.shape import Shape
from slipctl.tick import WHEELS

_GEOM_KINDS = {
    mujoco.mjtGeom.mjGEOM_PLANE: "plane",
    mujoco.mjtGeom.mjGEOM_SPHERE: "sphere",
    mujoco.mjtGeom.mjGEOM_CAPSULE: "capsule",
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: "ellipsoid",
    mujoco.mjtGeom.mjGEOM_CYLINDER: "cylinder",
    mujoco.mjtGeom.mjGEOM_BOX: "box",
    mujoco.mjtGeom.mjGEOM_MESH: "mesh",
}


_MARKS = ("left_tyre", "right_tyre", "left_tyre_force", "right_tyre_force")
"""Pairs and sensors: a file with one of these was written for slipctl."""


@overload
def find_model(model: str | Path) -> Path: ...
@overload
def find_model(model: OwnModel) -> OwnModel: ...
@overload
def find_model(model: str | Path | OwnModel) -> Path | OwnModel: ...


def find_model(model: str | Path | OwnModel) -> Path | OwnModel:
    """Return the file of a model given by path or by the name of a shipped one.

    Parameters
    ----------
    model : str, Path or OwnModel
        ``magellan_pro`` or the path of an MJCF or URDF file; `OwnModel` adds what the file does not tell.

    Raises
    ------
    ModelError
        If there is no such file.
    """
    if isinstance(model, OwnModel):
        find_model(model.path)
        return model
    path = Path(model)
    if not path.suffix and len(path.parts) == 1:
        names = shipped.model_names()
        if str(model) not in names:
            near = difflib.get_close_matches(str(model), names, 1)
            hint = f"; did you mean {near[0]!r}?" if near else ""
            raise ModelError(
                f"there is no model file {str(model)!r}, and no shipped model of this name; "
                f"allowed: a path, or {', '.join(names)}{hint}"
            )
        path = Path(shipped.model_path(str(model)))
    if not path.is_file():
        raise ModelError(f"no model file at {path}")
    return path


def adopted(model: Path | OwnModel) -> Adopted | None:
    """Return what slipctl made of a robot that was not written for it; None for one that was.

    Raises
    ------
    ModelError
        If the file cannot be read or used.
    """
    own = model if isinstance(model, OwnModel) else OwnModel(model)
    try:
        stamp = own.path.stat()
        return _adopted(own, stamp.st_mtime_ns, stamp.st_size)
    except OSError as error:
        raise ModelError(f"{own}: it cannot be read ({error.strerror or error})") from error


@lru_cache(maxsize=4)
def _adopted(own: OwnModel, written: int, size: int) -> Adopted | None:
    if own.path.suffix.lower() != ".urdf":
        spec = _spec(own.path)
        if {part.name for part in (*spec.pairs, *spec.sensors)} & set(_MARKS):
            if own != OwnModel(own.path):
                raise ModelError(
                    f"{own}: it was written for slipctl and names its own parts: "
                    "no left_wheel, right_wheel, keep_contacts or caster_friction"
                )
            return None
    return adopt(own)


def _spec(path: Path) -> mujoco.MjSpec:
    try:
        with quiet():
            return mujoco.MjSpec.from_file(str(path))
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error


def load_spec(model: Path | OwnModel) -> mujoco.MjSpec:
    """Return the editable model of a file, with every part that slipctl finds by name.

    A file that was not written for slipctl, one without its pairs and sensors, is adopted.

    Raises
    ------
    ModelError
        If MuJoCo cannot read the file, it has no part of a name that slipctl needs, or its robot cannot be
        driven.
    """
    own = adopted(model)
    if own is not None:
        return own.spec.copy()
    path = model.path if isinstance(model, OwnModel) else model
    spec = _spec(path)
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


def _compiled(spec: mujoco.MjSpec, path: Path | OwnModel) -> mujoco.MjModel:
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise ModelError(f"{path}: {error}") from error


def compile_model(
    path: Path | OwnModel,
    timestep: float | None = None,
    speed_drive: bool = True,
    torque_limit: float | None = None,
    moving_floor: bool = False,
    uneven_floor: bool = False,
) -> mujoco.MjModel:
    """Compile a model with the edits that change its structure.

    Parameters
    ----------
    path : Path or OwnModel
    timestep : float, optional
        Physics step [s]; the file's own by default.
    speed_drive : bool
        Keep the file's wheel speed servos; otherwise replace them by torque motors.
    torque_limit : float, optional
        Largest wheel torque [N·m]; the file's own by default. Torque motors need one. A smaller limit of the
        wheel's joint in the file holds, too.
    moving_floor : bool
        Compile a floor whose surface may be moved later. MuJoCo ignores a surface velocity that is written
        into a model compiled without any, so it gets one of 1e-12 m/s.
    uneven_floor : bool
        Give every sphere that touches the floor a plane of its own, which can be moved later.

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
        joint = float(spec.joint(f"{side}_axle").actfrcrange[1])
        most = torque_limit if torque_limit is None or joint <= 0.0 else min(torque_limit, joint)
        if not speed_drive:
            if most is None:
                raise ModelError(f"{path}: a torque drive needs a torque limit")
            actuator.set_to_motor()
            actuator.ctrlrange = [-most, most]
        if most is not None:
            actuator.forcerange = [-most, most]
    if uneven_floor:
        give_planes(spec)
    if moving_floor:
        spec.geom("floor").surfacevel = [1e-12, 0.0, 0.0, 0.0, 0.0, 0.0]
    return _compiled(spec, path)


def model_id(path: Path | OwnModel) -> str:
    """Return ``sha256:…`` of the compiled model before any edit of a scenario.

    That is as it stands in a file written for slipctl, and as adopted from any other.
    """
    model = _compiled(load_spec(path), path)
    buffer = np.zeros(mujoco.mj_sizeModel(model), dtype=np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return "sha256:" + hashlib.sha256(buffer.tobytes()).hexdigest()


def shapes(model: mujoco.MjModel) -> list[Shape]:
    """Return what a viewer draws of the robot: its geoms in the groups shown by default, 0–2.

    Poses are in frames whose axes are those of the base at rest, a wheel's with its origin on the axle.
    Bodies on joints of their own, such as casters that swivel, are drawn where the file puts them.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = model.body("base").id
    wheels = {model.body(f"{side}_wheel").id: side for side in WHEELS}
    drawn = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if int(model.body_rootid[body]) != base or model.geom_group[geom] > 2:
            continue
        kind = _GEOM_KINDS.get(mujoco.mjtGeom(model.geom_type[geom]))
        if kind is None:
            continue
        while body != base and body not in wheels:
            body = int(model.body_parentid[body])
        position, quaternion = np.array(model.geom_pos[geom]), np.array(model.geom_quat[geom])
        if int(model.geom_bodyid[geom]) != body or (model.body_quat[body] != [1, 0, 0, 0]).any():
            position, quaternion = _seen(model, data, geom, wheels.get(body))
        material = int(model.geom_matid[geom])
        colour = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
        drawn.append(
            Shape(
                body="base" if body == base else f"{wheels[body]}_wheel",
                kind=kind,
                size=np.array(model.geom_size[geom]),
                position=position,
                quaternion=quaternion,
                rgba=np.array(colour, dtype=np.float64),
            )
        )
    return drawn


def _seen(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, side: str | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pose of a geom in the axes of the base, about its origin or about a wheel's axle."""
    base = data.body("base")
    origin = base.xpos if side is None else data.joint(f"{side}_axle").xanchor
    back, turn, position, quaternion = np.zeros(4), np.zeros(4), np.zeros(3), np.zeros(4)
    mujoco.mju_negQuat(back, base.xquat)
    mujoco.mju_rotVecQuat(position, data.geom_xpos[geom] - origin, back)
    mujoco.mju_mat2Quat(turn, data.geom_xmat[geom])
    mujoco.mju_mulQuat(quaternion, back, turn)
    return position, quaternion
