"""One robot that is being tried, stepped by hand."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from slipctl.certify.trace import Trace
from slipctl.tick import Array

if TYPE_CHECKING:
    from slipctl.certify.specimen import Specimen


class Rig:
    """One robot that is being tried; scratch space."""

    def __init__(self, specimen: Specimen, model: Any):
        self.specimen, self.model, self.data = specimen, model, mujoco.MjData(model)
        mujoco.mj_forward(model, self.data)
        self.casters = sorted(
            {
                self.other(c)
                for c in self.contacts()
                if self.model.geom_bodyid[self.other(c)] not in specimen.wheel_bodies
            }
        )

    def contacts(self) -> list[Any]:
        """Return the present contacts with the floor."""
        floor = self.specimen.floor
        return [c for c in self.data.contact[: self.data.ncon] if floor in (c.geom1, c.geom2)]

    def other(self, contact: Any) -> int:
        """Return what touches the floor there."""
        return int(contact.geom2 if contact.geom1 == self.specimen.floor else contact.geom1)

    @property
    def friction(self) -> float:
        """Under both wheels."""
        pairs = self.specimen.pairs
        return float(
            self.model.pair_friction[pairs[0], 0]
            if pairs
            else max(self.model.geom_friction[geom, 0] for geom in self._rubbing)
        )

    @friction.setter
    def friction(self, value: float) -> None:
        pairs = self.specimen.pairs
        if pairs:
            self.model.pair_friction[pairs, :2] = value
        else:
            self.model.geom_friction[self._rubbing, 0] = value

    @property
    def _rubbing(self) -> list[int]:
        """Geoms of the wheels, and the floor: the larger friction of two geoms holds."""
        wheels = self.specimen.wheel_bodies
        return [
            self.specimen.floor,
            *(g for g in range(self.model.ngeom) if self.model.geom_bodyid[g] in wheels),
        ]

    def stand(
        self, velocity: tuple[float, float] = (0.0, 0.0), rolling: tuple[float, float] = (0.0, 0.0)
    ) -> Rig:
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

    def run(
        self, duration: float, act: Callable[[Rig, float], None] | None = None, work: bool = False
    ) -> Trace:
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
