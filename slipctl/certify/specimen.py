"""A compiled robot on a test bench, so that models which no plant takes can be judged, too."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import copy
import math
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from slipctl.certify.rest import Rest
from slipctl.certify.rig import Rig
from slipctl.plants.errors import ModelError
from slipctl.plants.model import compile_model
from slipctl.plants.own import OwnModel
from slipctl.theory.robot import GRAVITY, WheelGeometry
from slipctl.tick import WHEELS

ROUGH = 1.0
"""Friction on which nothing here slides [1]; no more, since a pyramidal cone softens the contact with it."""

BRAKE = 1e6
"""Damping of a locked axle [N·m·s/rad]."""


class Specimen:
    """The compiled model, before ground edits, and the robot at rest on it.

    Parameters
    ----------
    path : Path or OwnModel
        MJCF or URDF file.
    timestep : float
        Physics step [s].

    Raises
    ------
    ModelError
        If the file cannot be used, or the robot does not come to rest on its wheels.
    """

    def __init__(self, path: Path | OwnModel, timestep: float):
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
        """The tyre pairs, left and right; none where the file's own contacts were kept."""
        named = {self.model.pair(pair).name: pair for pair in range(self.model.npair)}
        names = [f"{side}_tyre" for side in WHEELS]
        return [named[name] for name in names] if set(names) <= set(named) else []

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
                raise ModelError(
                    f"{self.path}: {self.model.body(body).name} does not touch the floor at rest"
                )
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
            caster_place=np.array([data.geom_xpos[g] - data.xpos[self.base] for g in rig.casters]).reshape(
                -1, 3
            ),
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
        if self.pairs:
            pair = self.pairs[0]
            damping = float(self.model.pair_solreffriction[pair, 1])
            widest, reference = float(self.model.pair_solimp[pair, 1]), self.model.pair_solref[pair]
            if damping < 0.0:
                return -damping / widest
        else:
            widest, reference = (
                float(self.model.geom_solimp[self.floor, 1]),
                self.model.geom_solref[self.floor],
            )
        first, second = (float(x) for x in reference)
        return 2.0 / (widest * max(first, 2.0 * self.timestep)) if first > 0.0 else -second / widest
