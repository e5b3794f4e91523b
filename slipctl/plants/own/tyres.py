"""The calibrated wheel contacts in place of a file's own, or the file's own under slipctl's names."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from slipctl.plants.errors import UnusableModel
from slipctl.plants.own.contacts import SAG, Support, Touch, calibrated, carried
from slipctl.tick import WHEELS, Array

LEAST_LOAD = 0.05
"""A caster's contact is made for at least this share of what a wheel carries [1]."""


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
