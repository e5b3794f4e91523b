"""The edits that make a robot's file into a model of slipctl."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from slipctl.plants.errors import UnusableModel
from slipctl.plants.own.contacts import SAG, WHEELS, Support, Touch, calibrated, carried
from slipctl.plants.own.wheels import Axles, driven_joints
from slipctl.theory.robot import GRAVITY
from slipctl.tick import Array

PREFIX = "own/"
"""Before every name of the file, so that none meets one of slipctl's."""

LEAST_LOAD = 0.05
"""A caster's contact is made for at least this share of what a wheel carries [1]."""

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


def add_drive(spec: mujoco.MjSpec, servo: float, limit: float) -> None:
    """Add slipctl's wheel servos and sensors.

    Parameters
    ----------
    spec : MjSpec
    servo : float
        kv [N·m·s/rad].
    limit : float
        Torque limit of a joint for which the file has none [N·m].
    """
    for side in WHEELS:
        joint = spec.joint(f"{side}_axle")
        own = float(joint.actfrcrange[1])
        most = own if own > 0.0 else limit
        actuator = spec.add_actuator(name=f"{side}_wheel", target=f"{side}_axle")
        actuator.trntype = mujoco.mjtTrn.mjTRN_JOINT
        actuator.set_to_velocity(kv=servo)
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


def put_tyres(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    touch: Touch,
    load: Array,
    casters: list[Support],
    caster_friction: float | None,
) -> None:
    """Replace the contacts with the floor by soft ones, calibrated as in ``models/magellan_pro.xml``.

    A wheel gets a sphere; the robot sinks by half of what its load presses the tyre in, so that it rolls on
    the file's own radius. A caster keeps its shape and friction; it is moved by what keeps its load.

    Parameters
    ----------
    spec, model : MjSpec, MjModel
        The model, and the same compiled.
    touch : Touch
    load : (2,) array
        Of the left and right wheel [N].
    casters : list of Support
    caster_friction : float or None
        Of casters without a joint of their own, in place of the compiled one [1].
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    radius, sag = float(touch.radius.mean()), SAG * float(touch.radius.mean())
    for index, side in enumerate(WHEELS):
        for geom in carried(model, f"{side}_axle"):
            part = spec.geom(model.geom(geom).name)
            part.contype = part.conaffinity = 0
        body = data.body(f"{side}_wheel")
        centre = data.joint(f"{side}_axle").xanchor - body.xpos
        centre[1] += touch.offset[index]
        turn = np.asarray(body.xmat).reshape(3, 3)
        spec.body(f"{side}_wheel").add_geom(
            name=f"{side}_tyre",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[radius + 0.5 * sag, 0.0, 0.0],
            pos=(turn * centre[:, None]).sum(axis=0),
            mass=0.0,
            contype=0,
            conaffinity=0,
            group=3,
        )
        wheel = int(model.body(f"{side}_wheel").id)
        _tyre_pair(
            spec,
            side,
            condim=3,
            friction=[0.8, 0.8, 0.005, 0.0001, 0.0001],
            **calibrated(float(load[index]) / sag, float(model.body_invweight0[wheel, 0])),
        )
    moved: set[str] = set()
    for caster in casters:
        rigid = int(model.body_weldid[model.geom_bodyid[caster.geom]]) == model.body("base").id
        if rigid and caster_friction is not None:
            sliding = np.array([caster_friction, caster_friction, 0.005, 0.0001, 0.0001])
            caster = replace(caster, dimension=3 if caster_friction > 0.0 else 1, friction=sliding)
        _soften(spec, model, data, caster, sag, float(load.mean()), moved)
    spec.body("base").pos = [0.0, 0.0, radius - 0.5 * sag]


def _soften(
    spec: mujoco.MjSpec,
    model: mujoco.MjModel,
    data: mujoco.MjData,
    caster: Support,
    sag: float,
    wheel_load: float,
    moved: set[str],
) -> None:
    """Give a caster a soft contact, and shift it so that it carries what it carried."""
    name, base = model.geom(caster.geom).name, model.body("base").id
    stiffness = max(caster.load, LEAST_LOAD * wheel_load) / sag
    for pair in list(spec.pairs):
        if pair.geomname2 == name:
            spec.delete(pair)
    part = spec.geom(name)
    part.contype = part.conaffinity = 0
    body = int(model.geom_bodyid[caster.geom])
    pair = spec.add_pair(name=name, geomname1="floor", geomname2=name)
    pair.condim, pair.friction = caster.dimension, caster.friction
    for key, value in calibrated(stiffness / caster.count, float(model.body_invweight0[body, 0])).items():
        setattr(pair, key, value)
    lift = 0.5 * sag - caster.load / stiffness
    if int(model.body_weldid[body]) != base:
        while int(model.body_weldid[model.body_parentid[body]]) != base:
            body = int(model.body_parentid[body])
        part = spec.body(model.body(body).name)
        body = int(model.body_parentid[body])
    if part.name not in moved:
        moved.add(part.name)
        part.pos = np.asarray(part.pos) + _in(data.xmat[body], lift)


def _in(frame: Array, lift: float) -> Array:
    """Return a vertical shift in the axes of a frame (9,)."""
    return lift * np.asarray(frame).reshape(3, 3)[2]


def keep_tyres(spec: mujoco.MjSpec, model: mujoco.MjModel, path: object) -> None:
    """Name the wheels' own contacts, so that the ground's friction reaches them; nothing else changes.

    Raises
    ------
    UnusableModel
        If a wheel has more than one geom that touches the floor.
    """
    floor = spec.geom("floor")
    for side in WHEELS:
        geoms = [spec.geom(model.geom(geom).name) for geom in carried(model, f"{side}_axle")]
        if len(geoms) != 1:
            raise UnusableModel(
                f"{path}: the {side} wheel has {len(geoms)} geoms that touch the floor; its contacts can "
                "only be replaced"
            )
        geom = geoms[0]
        stiff = geom.solref if geom.priority >= floor.priority else floor.solref
        geom.name = f"{side}_tyre"
        # the same damping as MuJoCo's reference motion has, in the direct format that slipctl reads
        damping = -2.0 / float(stiff[0]) if stiff[0] > 0.0 else float(stiff[1])
        _tyre_pair(
            spec,
            side,
            condim=3,
            friction=[0.8, 0.8, 0.005, 0.0001, 0.0001],
            solref=list(stiff),
            solimp=list(geom.solimp),
            solreffriction=[-1e-9, damping],
        )
        geom.contype = geom.conaffinity = 0


def _tyre_pair(spec: mujoco.MjSpec, side: str, **parameters: object) -> None:
    pair = spec.add_pair(name=f"{side}_tyre", geomname1="floor", geomname2=f"{side}_tyre")
    for name, value in parameters.items():
        setattr(pair, name, value)
    sensor = spec.add_sensor(
        name=f"{side}_tyre_force",
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname="floor",
        reftype=mujoco.mjtObj.mjOBJ_GEOM,
        refname=f"{side}_tyre",
    )
    sensor.intprm = [1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE), 3, 1]
