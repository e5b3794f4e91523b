"""The shipped robot as numbers that any engine can be told, read off MuJoCo's compiled model."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from slipctl.plants.model import compile_model, find_model
from slipctl.plants.standstill import inertia, settle
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import Array


@dataclass(frozen=True)
class Spring:
    """A contact that pushes with stiffness [N/m] and damping [N·s/m], and what it bears at rest [N]."""

    stiffness: float
    damping: float
    load: float

    @property
    def depth(self) -> float:
        """Return the penetration at rest [m]."""
        return self.load / self.stiffness


@dataclass(frozen=True)
class Robot:
    """Lengths [m] in the axle's frame, masses [kg], inertias [kg·m²] about each body's centre of mass.

    `yaw_inertia` is the whole robot's; `wheel_inertia` and `wheel_armature` are about the axle;
    `base_inertia` is about x, y, z. `inverse_mass` (2,) is what a wheel's contact point yields to a force
    along the heading and to the left of it [1/kg].
    """

    wheel_radius: float
    half_track: float
    base_mass: float
    base_com: float
    base_inertia: Array
    wheel_mass: float
    wheel_inertia: float
    wheel_cross_inertia: float
    wheel_armature: float
    caster_radius: float
    caster_reach: float
    tyre: Spring
    caster: Spring
    torque_limit: float
    yaw_inertia: float
    inverse_mass: Array

    @property
    def mass(self) -> float:
        """Return the whole robot's mass [kg]."""
        return self.base_mass + 2.0 * self.wheel_mass

    @property
    def com_height(self) -> float:
        """Return the height of the whole robot's centre of mass at rest [m]."""
        return self.wheel_radius + self.base_com * self.base_mass / self.mass


def _spring(model: mujoco.MjModel, data: mujoco.MjData, name: str) -> Spring:
    pair = model.pair(name)
    touching = [i for i, c in enumerate(data.contact) if {c.geom1, c.geom2} == {pair.geom1[0], pair.geom2[0]}]
    force = np.zeros(6)
    mujoco.mj_contactForce(model, data, touching[0], force)
    stiffness = force[0] / -data.contact[touching[0]].dist
    stiff, damp = model.pair_solref[pair.id]
    return Spring(float(stiffness), float(stiffness * damp / stiff), float(force[0]))


def _inverse_mass(model: mujoco.MjModel, data: mujoco.MjData, radius: float) -> Array:
    wheel = model.body("left_wheel").id
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, data.xpos[wheel] - np.array([0.0, 0.0, radius]), wheel)
    moved = np.zeros((2, model.nv))
    mujoco.mj_solveM(model, data, moved, jacobian[:2])
    return (moved * jacobian[:2]).sum(axis=1)


def magellan_pro(timestep: float = 0.001) -> Robot:
    """Return the shipped robot; its contacts are measured at rest: what MuJoCo makes of the file."""
    model = compile_model(find_model("magellan_pro"), timestep)
    standstill = settle(model)
    wheels = WheelGeometry(standstill.wheel_radius, standstill.half_track)
    data = mujoco.MjData(model)
    for _ in range(round(2.0 / timestep)):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    base, wheel = model.body("base"), model.body("left_wheel")
    return Robot(
        wheel_radius=standstill.wheel_radius,
        half_track=standstill.half_track,
        base_mass=float(base.mass[0]),
        base_com=float(base.ipos[2]),
        base_inertia=np.array(base.inertia),
        wheel_mass=float(wheel.mass[0]),
        wheel_inertia=float(wheel.inertia[1]),
        wheel_cross_inertia=float(wheel.inertia[0]),
        wheel_armature=float(model.joint("left_axle").armature[0]),
        caster_radius=float(model.geom("front_caster").size[0]),
        caster_reach=float(model.geom("front_caster").pos[0]),
        tyre=_spring(model, data, "left_tyre"),
        caster=_spring(model, data, "front_caster"),
        yaw_inertia=float(inertia(model, wheels).yaw_inertia),
        inverse_mass=_inverse_mass(model, data, standstill.wheel_radius),
        torque_limit=float(model.actuator("left_wheel").forcerange[1]),
    )
