"""What a model file says about a robot, and how well it drives: what ``slipctl inspect`` shows."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from slipctl.plants.errors import ModelError, UnusableModel
from slipctl.plants.model import adopted, compile_model, find_model, model_id
from slipctl.plants.own import OwnModel
from slipctl.plants.own.contacts import floor_forces
from slipctl.plants.own.reading import quiet
from slipctl.plants.standstill import Standstill, inertia, settle
from slipctl.theory.robot import GRAVITY, WheelGeometry
from slipctl.tick import WHEELS

LEAST_YAW = 0.97
"""Share of the yaw of the wheels that a good differential drive realises at least [1]."""

LARGEST_DROOP = 0.005
"""Share by which a wheel may stay behind its set point before that is worth a warning [1]."""

LEAST_SHARE = 0.5
"""Share of the weight that the driven wheels should carry [1]."""


@dataclass(frozen=True)
class Wheel:
    """A driven wheel: its joint, the sign of its axis, and the contact in the file.

    Attributes
    ----------
    joint : str
    sign : int
        1 where positive drives ahead in the file.
    radius : float
        From the axle down to the compiled contact [m].
    contacts : int
        With a level floor.
    """

    joint: str
    sign: int
    radius: float
    contacts: int


@dataclass(frozen=True)
class Caster:
    """What else touches the floor, at rest or in the arc.

    Attributes
    ----------
    geom : str
    condim : int
        As compiled, with the floor's share.
    friction : float
        As compiled; 0 where `condim` is 1.
    weight_share : float
        At rest [1].
    moves : bool
        On a joint of its own: it swivels or rolls.
    brakes : bool
        Rubs on the floor as the robot moves.
    """

    geom: str
    condim: int
    friction: float
    weight_share: float
    moves: bool
    brakes: bool


@dataclass(frozen=True)
class Drive:
    """How the robot drives an arc of 5 s on its speed servos.

    Attributes
    ----------
    yaw_realised : float
        Yaw over yaw of the wheels, once under way [1].
    droop : float
        Share by which the wheels stay behind their set point [1].
    saturation : float
        Share of the time at the torque limit [1].
    touched : tuple of str
        Geoms that touched the floor beside the wheels.
    """

    yaw_realised: float
    droop: float
    saturation: float
    touched: tuple[str, ...]


@dataclass(frozen=True)
class Inspection:
    """A robot as found; lengths [m], mass [kg], None where the robot could not be used so far."""

    model: str
    model_id: str | None = None
    written_for_slipctl: bool = False
    wheel_radius: float | None = None
    half_track: float | None = None
    mass: float | None = None
    mass_in_file: float | None = None
    yaw_inertia: float | None = None
    weight_share: float | None = None
    wheels: tuple[Wheel, ...] = ()
    casters: tuple[Caster, ...] = ()
    free_joint: str | None = None
    servo: float | None = None
    torque_limit: float | None = None
    yaw_realised: float | None = None
    servo_droop: float | None = None
    saturation: float | None = None
    notes: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    usable: bool = False

    def json(self) -> dict[str, Any]:
        """Return it as the object that ``--json`` prints."""
        return {
            key: list(value) if isinstance(value, tuple) else value for key, value in asdict(self).items()
        }


def inspect(model: str | Path | OwnModel) -> Inspection:
    """Look at a robot: a shipped one by name, or a file.

    Raises
    ------
    ModelError
        If the file cannot be read. A robot that cannot be used raises nothing: it is told.
    """
    path = find_model(model)
    try:
        found = adopted(path)
        compiled = compile_model(path)
        notes = () if found is None else found.notes
        seen = Inspection(str(path), model_id(path), written_for_slipctl=found is None, notes=notes)
        if found is None:
            seen = replace(seen, free_joint="file", mass_in_file=float(compiled.body("base").subtreemass[0]))
        else:
            seen = replace(seen, free_joint=found.free_joint, mass_in_file=found.mass_in_file)
    except UnusableModel as error:
        return Inspection(str(path), warnings=(_reason(error, path),))
    try:
        at_rest = settle(compiled)
    except ModelError as error:
        return replace(seen, warnings=(_reason(error, path),))
    felt = inertia(compiled, WheelGeometry(at_rest.wheel_radius, at_rest.half_track))
    casters, share = standing(compiled, at_rest)
    drive = drive_arc(compiled, at_rest)
    if found is None:
        wheels = tuple(Wheel(f"{side}_axle", 1, at_rest.wheel_radius, 1) for side in WHEELS)
    else:
        wheels = tuple(
            Wheel(joint, sign, float(radius), int(count))
            for joint, sign, radius, count in zip(
                found.joints, found.signs, found.touch.radius, found.touch.count, strict=True
            )
        )
    seen = replace(
        seen,
        wheel_radius=at_rest.wheel_radius,
        half_track=at_rest.half_track,
        mass=felt.mass,
        yaw_inertia=felt.yaw_inertia,
        weight_share=share,
        wheels=wheels,
        casters=casters,
        servo=-float(compiled.actuator("left_wheel").biasprm[2]),
        torque_limit=float(compiled.actuator("left_wheel").forcerange[1]),
        yaw_realised=drive.yaw_realised,
        servo_droop=drive.droop,
        saturation=drive.saturation,
    )
    return replace(seen, warnings=tuple(_warnings(seen, drive)), usable=bool(drive.yaw_realised >= LEAST_YAW))


def standing(model: mujoco.MjModel, at_rest: Standstill) -> tuple[tuple[Caster, ...], float]:
    """Return what touches the floor beside the wheels, and the share of the weight on the wheels."""
    data = _placed(model, at_rest)
    mujoco.mj_forward(model, data)
    weight = float(model.body("base").subtreemass[0]) * GRAVITY
    tyres = _tyres(model)
    forces = floor_forces(model, data)
    casters = []
    for geom, force in sorted(forces.items()):
        if geom in tyres:
            continue
        contact = next(c for c in data.contact[: data.ncon] if geom in c.geom)
        friction = float(contact.friction[0]) if contact.dim > 1 else 0.0
        moves = int(model.body_weldid[model.geom_bodyid[geom]]) != model.body("base").id
        name = model.geom(geom).name.removeprefix("own/")
        brakes = friction > 1e-3 and not moves
        casters.append(Caster(name, int(contact.dim), friction, force / weight, moves, brakes))
    on_wheels = sum(force for geom, force in forces.items() if geom in tyres)
    return tuple(casters), on_wheels / weight


def drive_arc(model: mujoco.MjModel, at_rest: Standstill) -> Drive:
    """Drive an arc for 5 s: 1 s to get under way, then steadily at 0.2·√(g·r) round four half tracks."""
    data = _placed(model, at_rest)
    speed = 0.2 * math.sqrt(GRAVITY * at_rest.wheel_radius)
    yaw_rate = speed / (4.0 * at_rest.half_track)
    wanted = WheelGeometry(at_rest.wheel_radius, at_rest.half_track).wheel_rates(
        np.array([speed]), np.array([yaw_rate])
    )[0]
    tyres = _tyres(model)
    steps, start = round(5.0 / model.opt.timestep), round(1.0 / model.opt.timestep)
    limit = model.actuator_forcerange[:, 1]
    yaw, before, wheels_before = 0.0, 0.0, np.zeros(2)
    rate, full, touched = np.zeros(2), 0, set()
    with quiet():
        for step in range(steps):
            data.ctrl[:] = wanted * min(1.0, (step + 1) / start)
            mujoco.mj_step(model, data)
            heading = _heading(data)
            if step >= start:
                yaw += math.remainder(heading - before, 2.0 * math.pi)
                rate += _axles(data, "qvel")
                full += bool((np.abs(data.actuator_force) >= 0.999 * limit).any())
            if step == start - 1 or not step:
                wheels_before = _axles(data, "qpos")
            before = heading
            if step % 10 == 0:
                touched |= set(floor_forces(model, data)) - tyres
    if not np.isfinite(data.qpos).all():
        return Drive(0.0, 1.0, 1.0, ())
    count = steps - start
    turned = _axles(data, "qpos") - wheels_before
    of_the_wheels = at_rest.wheel_radius * (turned[1] - turned[0]) / (2.0 * at_rest.half_track)
    return Drive(
        yaw_realised=float(yaw / of_the_wheels) if of_the_wheels > 0.0 else 0.0,
        droop=float((1.0 - rate / count / wanted).max()),
        saturation=full / count,
        touched=tuple(sorted(model.geom(g).name.removeprefix("own/") for g in touched)),
    )


def _tyres(model: mujoco.MjModel) -> set[int]:
    pairs = [model.pair(f"{side}_tyre") for side in WHEELS]
    return {int(geom[0]) for pair in pairs for geom in (pair.geom1, pair.geom2)} - {model.geom("floor").id}


def _placed(model: mujoco.MjModel, at_rest: Standstill) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[2] = at_rest.height
    data.qpos[3:7] = at_rest.quaternion
    return data


def _heading(data: mujoco.MjData) -> float:
    matrix = data.body("base").xmat
    return math.atan2(matrix[3], matrix[0])


def _axles(data: mujoco.MjData, name: str) -> np.ndarray:
    return np.array([float(getattr(data.joint(f"{side}_axle"), name)[0]) for side in WHEELS])


def _reason(error: ModelError, path: Path | OwnModel) -> str:
    return str(error).removeprefix(f"{path}: ")


def _warnings(seen: Inspection, drive: Drive) -> list[str]:
    said = [
        f"caster {caster.geom!r} brakes: friction {caster.friction:g} (condim {caster.condim}) under "
        f"{caster.weight_share:.1%} of the weight, which looks like slip (caster_friction = 0 lets it slide)"
        for caster in seen.casters
        if caster.brakes
    ]
    if drive.yaw_realised < LEAST_YAW:
        said.append(
            f"the robot turns by only {drive.yaw_realised:.1%} of what its wheels say in an arc "
            f"(a differential drive: {LEAST_YAW:.0%} or more); something beside the wheels holds it"
        )
    if seen.weight_share is not None and seen.weight_share < LEAST_SHARE:
        said.append(f"the driven wheels carry only {seen.weight_share:.0%} of the weight")
    rest = {caster.geom for caster in seen.casters}
    said += [f"{geom!r} touches the floor in the arc" for geom in drive.touched if geom not in rest]
    if drive.droop > LARGEST_DROOP:
        said.append(f"the wheels stay {drive.droop:.1%} behind their set point")
    if drive.saturation > 0.0:
        said.append(f"a wheel was at its torque limit for {drive.saturation:.0%} of the arc")
    return said
