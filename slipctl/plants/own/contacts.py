"""The wheel contacts of a robot that slipctl did not write, and the calibrated ones in their place."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from slipctl.plants.errors import UnusableModel
from slipctl.plants.own.reading import quiet
from slipctl.tick import WHEELS, Array

DEPTH = 1e-6
"""How deep a wheel is pressed into the floor to see where it touches [m]."""

SAG = 0.006
"""Share of the wheel's radius by which its load presses the tyre in (assumed) [1].

Less than the Magellan Pro's 0.0087: small robots pitch more, and a film would miss its constant.
The rule for a tyre: K = (load of the wheel at rest)/(SAG·r), with the damping ratio `DAMPING`; a caster that
carries a share likewise, so that all sink alike and carry what they did on the rigid contacts of the file.
"""

DAMPING = 0.4
"""Damping ratio of a tyre (assumed) [1]."""

IMPEDANCE = 0.002
"""MuJoCo's d: so small that force depends on penetration alone and a sliding wheel does not hop [1]."""

FRICTION_RATE = 800.0
"""b_t, at which slip is taken away: near 1/timestep, at which curves cost no slip [1/s]."""


@dataclass(frozen=True)
class Touch:
    """Where the wheels touch the floor as the file has them.

    Attributes
    ----------
    radius : (2,) array
        From the axle down to the contact, left and right [m].
    offset : (2,) array
        From the joint's anchor to the middle of the tread along the axle, to the left [m].
    count : (2,) array of int
        Contacts per wheel.
    """

    radius: Array
    offset: Array
    count: Array


def carried(model: mujoco.MjModel, joint: str) -> list[int]:
    """Return the geoms that turn with a joint and can touch something."""
    wheel = int(model.jnt_bodyid[model.joint(joint).id])
    moving = [body for body in range(model.nbody) if _below(model, body, wheel)]
    return [
        geom
        for geom in range(model.ngeom)
        if model.geom_bodyid[geom] in moving and (model.geom_contype[geom] or model.geom_conaffinity[geom])
    ]


def _below(model: mujoco.MjModel, body: int, ancestor: int) -> bool:
    while body and body != ancestor:
        body = int(model.body_parentid[body])
    return body == ancestor


def touching(model: mujoco.MjModel, path: object) -> Touch:
    """Press each wheel a little into the floor, and read where the compiled contact is.

    Raises
    ------
    UnusableModel
        If a wheel has nothing that touches the floor.
    """
    data = mujoco.MjData(model)
    floor = model.geom("floor").id
    radius, offset, count = [], [], []
    for side in WHEELS:
        geoms = carried(model, f"{side}_axle")
        if not geoms:
            raise UnusableModel(f"{path}: the {side} wheel has no geom that can touch the floor")
        mujoco.mj_resetData(model, data)
        data.qpos[2] = 100.0
        mujoco.mj_kinematics(model, data)
        lowest = min(mujoco.mj_geomDistance(model, data, floor, geom, 1e3, None) for geom in geoms)
        data.qpos[2] -= lowest + DEPTH
        mujoco.mj_forward(model, data)
        found = [
            c for c in data.contact[: data.ncon] if floor in c.geom and set(c.geom.tolist()) & set(geoms)
        ]
        if not found:
            raise UnusableModel(
                f"{path}: the {side} wheel cannot touch the floor (see its contype and conaffinity)"
            )
        anchor = data.joint(f"{side}_axle").xanchor
        bottom = sum(float(c.pos[2] + 0.5 * c.dist) for c in found) / len(found)
        radius.append(round(float(anchor[2]) - bottom, 9))
        # the middle of the tread, not the contact: an axle that is 0.05 degrees off stands on one edge
        met = [geom for geom in geoms if any(geom in c.geom for c in found)]
        middle = sum(float(data.geom_xpos[geom][1]) for geom in met) / len(met)
        offset.append(round(middle - float(anchor[1]), 9))
        count.append(len(found))
    if min(radius) <= 0.0 or abs(radius[0] - radius[1]) > 0.01 * max(radius):
        raise UnusableModel(f"{path}: the wheels have radii of {radius[0]:.4g} and {radius[1]:.4g} m")
    return Touch(np.array(radius), np.array(offset), np.array(count))


def mean_forces(model: mujoco.MjModel, duration: float = 2.0) -> tuple[dict[int, float], bool]:
    """Return the force of the floor on every geom, wheels held [N], and whether the robot stands.

    The force is the mean over the last second: rigid contacts need not come to rest.
    """
    data = mujoco.MjData(model)
    steps = round(duration / model.opt.timestep)
    total: dict[int, float] = {}
    count = 0
    with quiet():
        for step in range(steps):
            mujoco.mj_step(model, data)
            if 2 * step >= steps and step % 10 == 0:
                count += 1
                for geom, force in floor_forces(model, data).items():
                    total[geom] = total.get(geom, 0.0) + force
    still = bool(np.isfinite(data.qpos).all()) and float(data.body("base").xmat[8]) > 0.98
    means = {geom: force / count for geom, force in total.items()}
    return means, still and float(np.abs(data.qpos[:2]).max()) < 0.05


def floor_forces(model: mujoco.MjModel, data: mujoco.MjData) -> dict[int, float]:
    """Return the normal force of the floor on every geom that touches it [N]."""
    floor, force = model.geom("floor").id, np.zeros(6)
    found: dict[int, float] = {}
    for index in range(data.ncon):
        pair = data.contact[index].geom.tolist()
        if floor in pair:
            mujoco.mj_contactForce(model, data, index, force)
            geom = pair[1] if pair[0] == floor else pair[0]
            found[geom] = found.get(geom, 0.0) + float(force[0])
    return found


@dataclass(frozen=True)
class Support:
    """A geom beside the wheels that is, or comes, near the floor: a caster.

    Attributes
    ----------
    geom : int
    dimension : int
        MuJoCo's ``condim`` as compiled, with the floor's share.
    friction : (5,) array
        As compiled [1].
    count : int
        Contacts with a level floor.
    load : float
        Force of the floor at rest [N].
    """

    geom: int
    dimension: int
    friction: Array
    count: int
    load: float


def supports(model: mujoco.MjModel, touch: Touch, forces: dict[int, float]) -> list[Support]:
    """Return the casters: what is within a quarter of a wheel radius of the floor, beside the wheels."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    floor, base = model.geom("floor").id, model.body("base").id
    wheels = {geom for side in WHEELS for geom in carried(model, f"{side}_axle")}
    paired = {int(geom) for geom in (*model.pair_geom1, *model.pair_geom2)}
    ground = float(data.body("base").xpos[2] - touch.radius.mean())
    found = []
    for geom in range(model.ngeom):
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom] or geom in paired
        if geom in wheels or not collides or int(model.body_rootid[model.geom_bodyid[geom]]) != base:
            continue
        mujoco.mj_resetData(model, data)
        data.qpos[2] += 100.0
        mujoco.mj_kinematics(model, data)
        lowest = mujoco.mj_geomDistance(model, data, floor, geom, 1e3, None)
        if lowest - 100.0 - ground > 0.25 * touch.radius.mean():
            continue
        data.qpos[2] -= lowest + DEPTH
        mujoco.mj_forward(model, data)
        own = [c for c in data.contact[: data.ncon] if set(c.geom.tolist()) == {floor, geom}]
        if own:
            found.append(
                Support(geom, int(own[0].dim), np.array(own[0].friction), len(own), forces.get(geom, 0.0))
            )
    return found


def calibrated(stiffness: float, inverse_mass: float) -> dict[str, list[float]]:
    """Return the parameters of a tyre's pair.

    Parameters
    ----------
    stiffness : float
        K [N/m].
    inverse_mass : float
        MuJoCo's compiled inverse mass at the contact, A [1/kg].
    """
    scaled = stiffness * (1.0 - IMPEDANCE) * inverse_mass
    return {
        "solref": [-scaled, -2.0 * DAMPING * math.sqrt(scaled)],
        "solimp": [IMPEDANCE, IMPEDANCE, 0.001, 0.5, 2.0],
        "solreffriction": [-1e-9, -FRICTION_RATE * IMPEDANCE],
    }
