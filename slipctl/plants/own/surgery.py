"""The edits that make a robot's file into a model of slipctl."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import mujoco
import numpy as np

from slipctl.plants.own.wheels import Axles, driven_joints
from slipctl.theory.robot import GRAVITY
from slipctl.tick import WHEELS

PREFIX = "own/"
"""Before every name of the file, so that none meets one of slipctl's."""

_PAIR = ("condim", "friction", "solref", "solimp", "solreffriction", "margin", "gap")


def start_spec(options_of: mujoco.MjSpec | None) -> mujoco.MjSpec:
    """Return a model of nothing, with slipctl's contact options or those of a file."""
    spec = mujoco.MjSpec()
    spec.modelname = "own robot"
    option = spec.option
    if options_of is None:
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        option.impratio = 1e6
        option.noslip_iterations = 0
    else:
        for name in ("cone", "impratio", "noslip_iterations", "noslip_tolerance", "solver", "iterations"):
            setattr(option, name, getattr(options_of.option, name))
    option.timestep = 0.001
    option.gravity = [0.0, 0.0, -GRAVITY]
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    return spec


def lay_floor(spec: mujoco.MjSpec, foreign: mujoco.MjSpec, model: mujoco.MjModel, root: int) -> None:
    """Add the floor, with the contact parameters of the file's own where it has a level plane."""
    floor = spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 0.05])
    floor.rgba = [0.8, 0.8, 0.78, 1.0]
    own = [g for g in range(model.ngeom) if model.body_rootid[model.geom_bodyid[g]] == root]
    for geom in range(model.ngeom):
        if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_PLANE or geom in own:
            continue
        if not model.geom_contype[geom] and not model.geom_conaffinity[geom]:
            continue
        floor.contype, floor.conaffinity = int(model.geom_contype[geom]), int(model.geom_conaffinity[geom])
        floor.condim, floor.priority = int(model.geom_condim[geom]), int(model.geom_priority[geom])
        floor.solmix, floor.margin, floor.gap = (
            float(values[geom]) for values in (model.geom_solmix, model.geom_margin, model.geom_gap)
        )
        floor.friction, floor.solref, floor.solimp = (
            values[geom].copy() for values in (model.geom_friction, model.geom_solref, model.geom_solimp)
        )
        return
    touches = int(np.bitwise_or.reduce([*model.geom_contype[own], *model.geom_conaffinity[own], 1]))
    floor.contype = floor.conaffinity = touches


def held_joints(model: mujoco.MjModel, axles: Axles) -> list[str]:
    """Return the joints beside the wheels that actuators of the file push."""
    return [model.joint(j).name for j in sorted(driven_joints(model) - set(axles.joints))]


def graft(
    spec: mujoco.MjSpec, foreign: mujoco.MjSpec, model: mujoco.MjModel, root: int, axles: Axles
) -> None:
    """Move the robot of a file under a free body at the midpoint of its axle."""
    held = held_joints(model, axles)
    own = {model.geom(g).name for g in range(model.ngeom) if model.body_rootid[model.geom_bodyid[g]] == root}
    kept = _pairs_with_the_floor(foreign, own)
    for elements in (foreign.keys, foreign.sensors, foreign.actuators, foreign.tendons, foreign.pairs):
        for element in list(elements):
            foreign.delete(element)
    robot = foreign.body(model.body(root).name)
    for joint in list(robot.joints):
        foreign.delete(joint)
    for name in held:
        foreign.delete(foreign.joint(name))
    for name in dir(spec.option):
        if not name.startswith("_"):
            setattr(foreign.option, name, getattr(spec.option, name))

    base = spec.worldbody.add_body(name="base", pos=[0.0, 0.0, 1.0])
    base.add_freejoint(name="base")
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, axles.frame.flatten())
    middle = axles.anchors.mean(axis=0)
    # by elements and not by `@`, whose rounding is the library's own affair
    seat = -(axles.frame * middle).sum(axis=1)
    base.add_frame(pos=seat, quat=quaternion).attach_body(robot, PREFIX, "")
    for side, joint, sign in zip(WHEELS, axles.joints, axles.signs, strict=True):
        axle = spec.joint(PREFIX + model.joint(joint).name)
        axle.name = f"{side}_axle"
        axle.axis = np.asarray(axle.axis) * sign
        spec.body(PREFIX + model.body(int(model.jnt_bodyid[joint])).name).name = f"{side}_wheel"
    for geom, parameters in kept:
        pair = spec.add_pair(name=PREFIX + geom, geomname1="floor", geomname2=PREFIX + geom)
        for name, value in parameters.items():
            setattr(pair, name, value)


def _pairs_with_the_floor(foreign: mujoco.MjSpec, own: set[str]) -> list[tuple[str, dict]]:
    found = []
    for pair in foreign.pairs:
        names = [pair.geomname1, pair.geomname2]
        inside = [name for name in names if name in own]
        if len(inside) == 1:
            found.append((inside[0], {name: getattr(pair, name) for name in _PAIR}))
    return found


def add_drive(spec: mujoco.MjSpec, servo: float, damping: tuple[float, ...], limit: float) -> None:
    """Add slipctl's wheel servos and sensors.

    Parameters
    ----------
    spec : MjSpec
    servo : float
        kv [N·m·s/rad].
    damping : tuple of float
        Of the left and right joint, which the servo makes up for as the integral part of a real one does
        [N·m·s/rad].
    limit : float
        Torque limit of a joint for which the file has none [N·m].
    """
    for side, drag in zip(WHEELS, damping, strict=True):
        joint = spec.joint(f"{side}_axle")
        own = float(joint.actfrcrange[1])
        most = own if own > 0.0 else limit
        actuator = spec.add_actuator(name=f"{side}_wheel", target=f"{side}_axle")
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.set_to_velocity(kv=servo)
        actuator.gainprm[0] = servo + drag
        actuator.forcelimited, actuator.forcerange = True, [-most, most]
    for side in WHEELS:
        spec.add_sensor(
            name=f"{side}_wheel_torque",
            type=mujoco.mjtSensor.mjSENS_ACTUATORFRC,
            objtype=mujoco.mjtObj.mjOBJ_ACTUATOR,
            objname=f"{side}_wheel",
        )
    spec.add_sensor(
        name="forward",
        type=mujoco.mjtSensor.mjSENS_FRAMEXAXIS,
        objtype=mujoco.mjtObj.mjOBJ_XBODY,
        objname="base",
    )
