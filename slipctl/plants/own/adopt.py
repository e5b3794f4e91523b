"""A robot's file made into a model with the parts that the MuJoCo plant finds by name."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from slipctl.plants.errors import UnusableModel
from slipctl.plants.own.choice import OwnModel
from slipctl.plants.own.contacts import Support, Touch, carried, mean_forces, supports, touching
from slipctl.plants.own.reading import compiled, quiet, read_spec
from slipctl.plants.own.surgery import add_drive, graft, held_joints, lay_floor, start_spec
from slipctl.plants.own.tyres import keep_tyres, put_tyres
from slipctl.plants.own.wheels import Axles, find_axles
from slipctl.theory.robot import GRAVITY
from slipctl.tick import WHEELS, Array

SERVO_TIME = 0.00291
"""Time in which a servo takes up what its wheel feels of the robot, driving or turning, whichever is less:
the Magellan Pro's (assumed) [s]."""

STIFFEST_SERVO = 2.7
"""Largest (kv + damping)·timestep/(inertia of a wheel): the Magellan Pro's; above, robots overshoot their
wheels [1]."""

GRIP_SHARE = 0.54
"""Torque limit in shares of what slides the wheels at μ = 1, if the file has none: the Magellan Pro's."""


@dataclass(frozen=True)
class Adopted:
    """A robot that slipctl did not write, and what was made of it.

    Attributes
    ----------
    spec : MjSpec
        With every part that slipctl finds by name. Copy it before an edit.
    joints : tuple of str
        Names of the driven joints in the file, left and right.
    signs : tuple of int
        1 where a positive joint speed drove ahead, −1 where the axis was turned round.
    touch : Touch
        The file's own wheel contacts.
    mass_in_file : float
        Sum over the links of the robot in the file [kg].
    free_joint : str
        ``file`` or ``added``.
    notes : tuple of str
        What was changed or left out.
    """

    spec: mujoco.MjSpec
    joints: tuple[str, str]
    signs: tuple[int, int]
    touch: Touch
    mass_in_file: float
    free_joint: str
    notes: tuple[str, ...]


def adopt(own: OwnModel) -> Adopted:
    """Read a robot's file and give it what slipctl needs.

    The robot moves under a new body ``base`` with a free joint at the midpoint of its axle, x ahead, y left.
    The file's other bodies and its floor stay behind; its actuators give way to slipctl's.

    Raises
    ------
    ModelError
        If the file cannot be read.
    UnusableModel
        If the robot in it cannot be driven.
    """
    path = own.path
    foreign, notes = read_spec(path)
    before = compiled(foreign, path)
    axles = find_axles(before, path, own.left_wheel, own.right_wheel)
    joints = (before.joint(axles.joints[0]).name, before.joint(axles.joints[1]).name)
    root = _root(before, axles, path)
    free = _is_free(before, root)
    if not free:
        notes.append("the base is welded to the world in the file; a free joint was added")
    held = held_joints(before, axles)
    mass = float(before.body_subtreemass[root])
    left_out = [g for g in range(before.ngeom) if before.body_rootid[before.geom_bodyid[g]] != root]
    if len(left_out) > 1 or any(before.geom_type[g] != mujoco.mjtGeom.mjGEOM_PLANE for g in left_out):
        notes.append(f"{len(left_out)} geoms of the file's surroundings were left out")

    with quiet():
        spec = start_spec(foreign if own.keep_contacts else None)
        lay_floor(spec, foreign, before, root)
        graft(spec, foreign, before, root, axles)
    if held:
        notes.append(
            f"joints that slipctl does not drive are held where the file puts them: {', '.join(held)}"
        )
    for side, sign in zip(WHEELS, axles.signs, strict=True):
        if sign < 0:
            notes.append(f"the axis of the {side} wheel was turned round, so that positive drives ahead")

    model = compiled(spec, path)
    _verify(model, mass, axles, path)
    touch = touching(model, path)
    radius = float(touch.radius.mean())
    spec.body("base").pos = [0.0, 0.0, radius]
    motor = _motor(model, radius)
    add_drive(spec, motor.servo, motor.damping, motor.limit)
    if motor.armature > 0.0:
        for side in WHEELS:
            spec.joint(f"{side}_axle").armature = motor.armature
        notes.append(
            f"the file's motors have no inertia; {motor.armature:.2g} kg·m² at each wheel was added (assumed)"
        )
    if own.keep_contacts:
        keep_tyres(spec, model, path)
    else:
        load, casters = _standing(spec, own, mass, touch)
        put_tyres(spec, compiled(spec, path), touch, load, casters, own.caster_friction)
    return Adopted(
        spec,
        joints,
        (int(axles.signs[0]), int(axles.signs[1])),
        touch,
        mass,
        "file" if free else "added",
        tuple(notes),
    )


def _root(model: mujoco.MjModel, axles: Axles, path: object) -> int:
    roots = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in axles.joints}
    wheels = {int(model.jnt_bodyid[joint]) for joint in axles.joints}
    if len(roots) != 1 or roots & wheels or len(wheels) != 2:
        raise UnusableModel(f"{path}: the wheels do not hang on one body of the robot")
    return roots.pop()


def _is_free(model: mujoco.MjModel, root: int) -> bool:
    first = int(model.body_jntadr[root])
    return first >= 0 and model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE


def _verify(model: mujoco.MjModel, mass: float, axles: Axles, path: object) -> None:
    """Hold the grafted robot against the file: nothing may be lost on the way."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = data.body("base").xpos
    half = float(np.linalg.norm(axles.anchors[0] - axles.anchors[1])) / 2.0
    for side, y in zip(WHEELS, (half, -half), strict=True):
        axle = data.joint(f"{side}_axle")
        apart = np.abs(axle.xanchor - base - [0.0, y, 0.0]).max()
        if apart > 1e-6 or axle.xaxis[1] < 0.999:
            raise UnusableModel(f"{path}: its frames could not be carried over (nested frames or keyframes)")
    now = float(model.body("base").subtreemass[0])
    if abs(now - mass) > 1e-6 * mass:
        raise UnusableModel(f"{path}: {now:g} kg of {mass:g} kg were carried over")


@dataclass(frozen=True)
class _Motor:
    armature: float  # of each wheel, added [kg·m²]
    servo: float  # kv [N·m·s/rad]
    damping: tuple[float, ...]  # of the joints, which the servos make up for [N·m·s/rad]
    limit: float  # [N·m]


def _motor(model: mujoco.MjModel, radius: float) -> _Motor:
    """Return a motor that is to this robot what the Magellan Pro's is to it.

    A file without any armature gets one: MuJoCo weighs the contacts without the servo's share of the step,
    and a stiff servo on a wheel of no inertia makes the robot overshoot what its wheels turn.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    axles = [model.joint(f"{side}_axle") for side in WHEELS]
    mass = float(full[0, 0])
    wheel = sum(float(full[a.dofadr[0], a.dofadr[0]]) for a in axles) / 2.0
    half = abs(float(data.joint("left_axle").xanchor[1] - data.joint("right_axle").xanchor[1])) / 2.0
    felt = radius * radius / 2.0 * min(mass, float(full[5, 5]) / (half * half))
    damping = tuple(float(a.damping[0]) for a in axles)
    share = float(model.opt.timestep) / STIFFEST_SERVO
    armature = 0.0
    if all(float(a.armature[0]) == 0.0 for a in axles):
        # what lets a servo of that time be no stiffer than the stiffest
        enough = share * (felt / SERVO_TIME + max(damping)) / (1.0 - share / SERVO_TIME)
        armature = max(0.0, enough - wheel)
    wheel += armature
    servo = (felt + wheel) / SERVO_TIME
    servo = min(servo, max(wheel / share - max(damping), 0.1 * servo))
    return _Motor(armature, servo, damping, GRIP_SHARE * mass * GRAVITY * radius / 2.0)


def _standing(spec: mujoco.MjSpec, own: OwnModel, mass: float, touch: Touch) -> tuple[Array, list[Support]]:
    """Return what the wheels carry at rest on the contacts of the file (2,) [N], and the casters."""
    calm = spec.copy()
    calm.option.impratio = 1.0  # the stiff friction that soft tyres are made for shakes rigid contacts
    model = compiled(calm, own.path)
    weight = mass * GRAVITY
    forces, upright = mean_forces(model)
    if not upright:
        raise UnusableModel(
            f"{own}: the robot does not stand still on its wheels and casters (a robot that must be "
            "balanced, or one whose centre of mass no caster holds, cannot be used)"
        )
    load = np.array([sum(forces.get(g, 0.0) for g in carried(model, f"{side}_axle")) for side in WHEELS])
    if load.min() < 0.02 * weight:
        raise UnusableModel(
            f"{own}: at rest the wheels carry {load[0] / weight:.0%} and {load[1] / weight:.0%} of the "
            "weight; something else holds the robot up"
        )
    return load, supports(model, touch, forces)
