"""A compiled robot on a test bench: one world, stepped by hand, so that models which no plant takes can be judged."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from slipctl.certify.rest import Rest
from slipctl.plants.model import WHEELS, ModelError, compile_model
from slipctl.theory.robot import GRAVITY, WheelGeometry
from slipctl.tick import Array

ROUGH = 1.0
"""Friction on which nothing here slides [1]; no more, since a pyramidal cone softens the contact with it."""

BRAKE = 1e6
"""Damping of a locked axle [N·m·s/rad]."""


@dataclass(frozen=True)
class Trace:
    """What was seen at the beginning of every step, and the forces over it; S steps.

    Attributes
    ----------
    time : (S,) array
        [s].
    position, velocity : (S, 3) arrays
        Of the body origin, world [m], [m/s].
    momentum : (S, 3) array
        Velocity of the robot's centre of mass, world [m/s].
    heading, yaw_rate : (S,) arrays
        [rad], [rad/s].
    pitch : (S,) array
        Nose down [rad].
    wheel_rate : (S, 2) array
        [rad/s].
    force : (S, 2, 3) array
        Of the floor on each wheel over the step that begins here, world [N].
    caster : (S, C) array
        Normal force on every other geom that touches the floor at rest [N].
    rubbing : (S,) array
        Power of the wheels' friction [W]; zero where it was not asked for.
    energy : (S,) array
        Kinetic and potential [J].
    """

    time: Array
    position: Array
    velocity: Array
    momentum: Array
    heading: Array
    yaw_rate: Array
    pitch: Array
    wheel_rate: Array
    force: Array
    caster: Array
    rubbing: Array
    energy: Array

    @property
    def load(self) -> Array:
        """Normal force on each wheel (S, 2) [N]."""
        return self.force[:, :, 2]

    def along(self, vectors: Array) -> tuple[Array, Array]:
        """Return the parts of world vectors (S, 3) along body forward and body left."""
        c, s = np.cos(self.heading), np.sin(self.heading)
        return c * vectors[:, 0] + s * vectors[:, 1], c * vectors[:, 1] - s * vectors[:, 0]

    def since(self, time: float) -> slice:
        """Return the steps from a time on."""
        return slice(int(np.searchsorted(self.time, time - 1e-9)), None)


class Specimen:
    """The compiled model, before ground edits, and the robot at rest on it.

    Parameters
    ----------
    path : Path
        MJCF or URDF file.
    timestep : float
        Physics step [s].

    Raises
    ------
    ModelError
        If the file cannot be used, or the robot does not come to rest on its wheels.
    """

    def __init__(self, path: Path, timestep: float):
        self.path = path
        self.model = compile_model(path, timestep)
        self.floor = self.model.geom("floor").id
        self.wheel_bodies = [self.model.body(f"{side}_wheel").id for side in WHEELS]
        self.axles = [int(self.model.joint(f"{side}_axle").dofadr[0]) for side in WHEELS]
        base = self.model.body("base")
        self.base = base.id
        if int(self.model.body_jntnum[self.base]) < 1 or self.model.jnt_type[base.jntadr[0]] != 0:
            raise ModelError(f"{path}: the base has no free joint: it is fixed to the world")
        self.q = int(self.model.jnt_qposadr[base.jntadr[0]])
        self.v = int(self.model.jnt_dofadr[base.jntadr[0]])

    @property
    def timestep(self) -> float:
        """Physics step [s]."""
        return float(self.model.opt.timestep)

    @property
    def pairs(self) -> list[int]:
        """The tyre pairs, left and right."""
        return [self.model.pair(f"{side}_tyre").id for side in WHEELS]

    def rig(
        self,
        friction: float | None = None,
        slope: float = 0.0,
        downhill: float = 0.0,
        locked: bool = False,
        free: bool = False,
    ) -> Rig:
        """Return the robot where its file puts it, on ground of its own.

        Parameters
        ----------
        friction : float, optional
            The file's own by default.
        slope, downhill : float
            [rad].
        locked : bool
            Brake the axles.
        free : bool
            Take the motors away; torques are then applied to the axles.
        """
        model = copy.copy(self.model)
        model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
        model.opt.gravity[:] = GRAVITY * np.array(
            [
                math.sin(slope) * math.cos(downhill),
                math.sin(slope) * math.sin(downhill),
                -math.cos(slope),
            ]
        )
        if locked:
            model.dof_damping[self.axles] = BRAKE
        if free or locked:
            model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
        rig = Rig(self, model)
        if friction is not None:
            rig.friction = friction
        return rig

    @cached_property
    def rest(self) -> Rest:
        """The robot at rest on level ground, wheels locked.

        Raises
        ------
        ModelError
            If it does not come to rest on both wheels.
        """
        rig = self.rig(locked=True)
        trace = rig.run(2.0)
        data = rig.data
        if not np.isfinite(data.qpos).all() or np.abs(data.qvel).max() > 2e-3:
            raise ModelError(f"{self.path}: the robot does not come to rest where its file puts it")
        radius, depth = [], []
        for body in self.wheel_bodies:
            touching = [c for c in rig.contacts() if self.model.geom_bodyid[rig.other(c)] == body]
            if not touching:
                raise ModelError(f"{self.path}: {self.model.body(body).name} does not touch the floor at rest")
            radius.append(float(data.xpos[body][2] - np.mean([c.pos[2] for c in touching])))
            depth.append(-float(np.mean([c.dist for c in touching])))
        apart = data.xpos[self.wheel_bodies[0]] - data.xpos[self.wheel_bodies[1]]
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, data, full)
        last = trace.since(trace.time[-1] - 0.2)
        return Rest(
            qpos=data.qpos.copy(),
            geometry=WheelGeometry(sum(radius) / 2.0, float(np.sqrt((apart * apart).sum())) / 2.0),
            inertia=full,
            load=trace.load[last].mean(axis=0),
            caster=trace.caster[last].mean(axis=0),
            caster_place=np.array([data.geom_xpos[g] - data.xpos[self.base] for g in rig.casters]).reshape(-1, 3),
            wheel_depth=np.array(depth),
            centre=data.subtree_com[self.base] - data.xpos[self.base],
            height=float(data.subtree_com[self.base][2]),
            mass=float(full[self.v, self.v]),
            wheel_inertia=float(sum(full[a, a] for a in self.axles) / 2.0),
            spin_inertia=float(sum(full[self.v + 4, a] for a in self.axles)),
            caster_depth=np.array(
                [-sum(c.dist for c in rig.contacts() if rig.other(c) == g) for g in rig.casters]
            ),
        )

    @property
    def slip_rate(self) -> float:
        """b_t, at which MuJoCo's reference motion takes slip away: as compiled, whatever the format [1/s]."""
        pair = self.pairs[0]
        damping = float(self.model.pair_solreffriction[pair, 1])
        widest = float(self.model.pair_solimp[pair, 1])
        if damping < 0.0:
            return -damping / widest
        first, second = (float(x) for x in self.model.pair_solref[pair])
        return 2.0 / (widest * max(first, 2.0 * self.timestep)) if first > 0.0 else -second / widest


class Rig:
    """One robot that is being tried; scratch space."""

    def __init__(self, specimen: Specimen, model: mujoco.MjModel):
        self.specimen, self.model, self.data = specimen, model, mujoco.MjData(model)
        mujoco.mj_forward(model, self.data)
        self.casters = sorted(
            {
                self.other(c)
                for c in self.contacts()
                if self.model.geom_bodyid[self.other(c)] not in specimen.wheel_bodies
            }
        )

    def contacts(self) -> list:
        """Return the present contacts with the floor."""
        floor = self.specimen.floor
        return [c for c in self.data.contact[: self.data.ncon] if floor in (c.geom1, c.geom2)]

    def other(self, contact) -> int:
        """Return what touches the floor there."""
        return int(contact.geom2 if contact.geom1 == self.specimen.floor else contact.geom1)

    @property
    def friction(self) -> float:
        """Under both wheels."""
        return float(self.model.pair_friction[self.specimen.pairs[0], 0])

    @friction.setter
    def friction(self, value: float) -> None:
        self.model.pair_friction[self.specimen.pairs, :2] = value

    def stand(self, velocity: tuple[float, float] = (0.0, 0.0), rolling: tuple[float, float] = (0.0, 0.0)) -> Rig:
        """Put the robot at rest height; moving over the floor, or rolling at v [m/s] and w [rad/s]."""
        specimen, data = self.specimen, self.data
        mujoco.mj_resetData(self.model, data)
        data.qpos[:] = specimen.rest.qpos
        data.qpos[specimen.q : specimen.q + 2] = 0.0
        data.qvel[specimen.v] = velocity[0] + rolling[0]
        data.qvel[specimen.v + 1] = velocity[1]
        data.qvel[specimen.v + 5] = rolling[1]
        data.qvel[specimen.axles] = self.rates(*rolling)
        data.ctrl[:] = self.rates(*rolling)
        mujoco.mj_forward(self.model, data)
        return self

    def parts(self) -> tuple[Array, Array, Array]:
        """Return mass (K,), place (K, 3) from the body origin, and yaw inertia (K,) of the robot's bodies."""
        model, data, base = self.model, self.data, self.specimen.base
        bodies = [b for b in range(1, model.nbody) if model.body_rootid[b] == base]
        frames = data.ximat[bodies].reshape(-1, 3, 3)
        yaw = (frames[:, 2, :] ** 2 * model.body_inertia[bodies]).sum(axis=1)
        return model.body_mass[bodies], data.xipos[bodies] - data.xpos[base], yaw

    def drive(self, acceleration: float) -> None:
        """Apply the torques that accelerate a robot in grip [m/s²]."""
        self.data.qfrc_applied[self.specimen.axles] = self.specimen.rest.torque(acceleration)

    def tow(self, force: tuple[float, float]) -> None:
        """Pull at the centre of mass with a world force from now on [N]."""
        base = self.specimen.base
        # at the centre of mass of the base; a moment moves it to that of the robot
        arm = self.data.subtree_com[base] - self.data.xipos[base]
        self.data.xfrc_applied[base, :3] = [force[0], force[1], 0.0]
        self.data.xfrc_applied[base, 3:] = np.array(
            [-arm[2] * force[1], arm[2] * force[0], arm[0] * force[1] - arm[1] * force[0]]
        )

    def rates(self, forward_speed: float, yaw_rate: float) -> Array:
        """Return the wheel rates of v and w [rad/s]."""
        geometry = self.specimen.rest.geometry
        return geometry.wheel_rates(np.array([forward_speed]), np.array([yaw_rate]))[0]

    def run(self, duration: float, act: Callable[[Rig, float], None] | None = None, work: bool = False) -> Trace:
        """Step for a while [s]; `act` is called with the rig and the time before every step."""
        model, data, sp = self.model, self.data, self.specimen
        count = round(duration / model.opt.timestep)
        wheels = {
            g: i
            for i, body in enumerate(sp.wheel_bodies)
            for g in range(model.ngeom)
            if model.geom_bodyid[g] == body
        }
        casters = {g: i for i, g in enumerate(self.casters)}
        body, vel = np.empty((count, 7)), np.empty((count, 8))
        momentum, force = np.empty((count, 3)), np.zeros((count, 2, 3))
        caster, rubbing = np.zeros((count, len(casters))), np.zeros(count)
        time, energy = np.empty(count), np.empty(count)
        wrench, jacobian = np.zeros(6), np.zeros((3, model.nv))
        for k in range(count):
            if act is not None:
                act(self, data.time)
            mujoco.mj_step1(model, data)
            mujoco.mj_subtreeVel(model, data)
            body[k] = data.qpos[sp.q : sp.q + 7]
            vel[k, :6] = data.qvel[sp.v : sp.v + 6]
            vel[k, 6:] = data.qvel[sp.axles]
            momentum[k] = data.subtree_linvel[sp.base]
            time[k] = data.time
            energy[k] = data.energy[0] + data.energy[1]
            before = data.qvel.copy()
            # all of one instant: the forces that follow act on what was just read
            mujoco.mj_step2(model, data)
            for c in range(data.ncon):
                contact = data.contact[c]
                if sp.floor not in (contact.geom1, contact.geom2) or contact.efc_address < 0:
                    continue
                geom = self.other(contact)
                mujoco.mj_contactForce(model, data, c, wrench)
                if geom in casters:
                    caster[k, casters[geom]] += wrench[0]
                elif geom in wheels:
                    sign = 1.0 if contact.geom1 == sp.floor else -1.0
                    push = sign * (contact.frame.reshape(3, 3).T * wrench[:3]).sum(axis=1)
                    force[k, wheels[geom]] += push
                    if work:
                        mujoco.mj_jac(model, data, jacobian, None, contact.pos, model.geom_bodyid[geom])
                        moving = (jacobian * before).sum(axis=1)
                        rubbing[k] += push[0] * moving[0] + push[1] * moving[1]
        w, x, y, z = body[:, 3], body[:, 4], body[:, 5], body[:, 6]
        return Trace(
            time=time,
            position=body[:, :3],
            velocity=vel[:, :3],
            momentum=momentum,
            heading=np.arctan2(2.0 * (x * y + w * z), w * w + x * x - y * y - z * z),
            yaw_rate=vel[:, 5],
            pitch=np.arcsin(np.clip(-2.0 * (x * z - w * y), -1.0, 1.0)),
            wheel_rate=vel[:, 6:],
            force=force,
            caster=caster,
            rubbing=rubbing,
            energy=energy,
        )
