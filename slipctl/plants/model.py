"""The robot as MuJoCo sees it: find the file, edit what varies in structure, compile, read back."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import hashlib
from pathlib import Path

import mujoco
import numpy as np

from slipctl import shipped
from slipctl.tick import Shape

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
