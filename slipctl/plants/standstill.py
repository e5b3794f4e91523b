"""The robot at rest: what the compiled contacts and inertias say once it stands on flat ground."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from slipctl.plants.errors import ModelError
from slipctl.theory.dynamic import Inertia
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import WHEELS, Array


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
        radius.append(data.joint(f"{side}_axle").xanchor[2] - touching[0].pos[2])
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
    apart = np.asarray(data.geom(pair.geom2[0]).xpos - data.geom(model.pair("right_tyre").geom2[0]).xpos)
    return Standstill(
        height=float(data.qpos[root + 2]),
        quaternion=_straight(np.array(data.qpos[root + 3 : root + 7])),
        wheel_radius=round(float(radius[0] + radius[1]) / 2.0, 9),
        half_track=round(float(np.sqrt((apart * apart).sum())) / 2.0, 9),
        tyre=Tyre(
            softness=np.array(softness),
            rate=rate,
            impedance=impedance,
            impratio=float(model.opt.impratio),
        ),
    )


def _straight(quaternion: Array) -> Array:
    """Return an orientation without its heading, which a caster may turn while the robot comes to rest."""
    w, x, y, z = quaternion.tolist()
    if abs(z) < 1e-9:
        return quaternion
    half = np.arctan2(z, w)
    c, s = float(np.cos(half)), float(np.sin(half))
    return np.array([c * w + s * z, c * x + s * y, c * y - s * x, c * z - s * w])


def inertia(model: mujoco.MjModel, geometry: WheelGeometry) -> Inertia:
    """Return what resists the wheel torques, read off the compiled model where its file puts the robot.

    Mass and yaw inertia are the whole robot's, wheels and armature included, about the axle midpoint; the
    wheel inertia is what one axle feels with its wheel off the ground.
    """
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    root = int(model.jnt_dofadr[model.body("base").jntadr[0]])
    axles = [int(model.joint(f"{side}_axle").dofadr[0]) for side in WHEELS]
    return Inertia(
        geometry=geometry,
        mass=float(full[root, root]),
        yaw_inertia=float(full[root + 5, root + 5]),
        wheel_inertia=float(sum(full[axle, axle] for axle in axles) / 2.0),
        joint_friction=float(sum(model.dof_frictionloss[axle] for axle in axles) / 2.0),
    )
