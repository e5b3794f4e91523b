"""Many robots on MuJoCo, one per world, stepped together."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from slipctl.plants.ground import Ground, floor_motion, lay, soften, viscosity
from slipctl.plants.model import compile_model, find_model, model_id, shapes
from slipctl.plants.own import OwnModel
from slipctl.plants.pushes import Push
from slipctl.plants.rows import Columns, MujocoState, ahead, turned
from slipctl.plants.standstill import Standstill, settle
from slipctl.plants.stepping import Surroundings, advance
from slipctl.shape import Shape
from slipctl.theory.flatness import apply_decoupling
from slipctl.theory.robot import WheelGeometry
from slipctl.theory.slip import NoSlip, SlipLaw, slipping_velocity
from slipctl.tick import Array, BodyPose, Command, Motion, SpeedCommand, Start, Status, WheelContact

Statuses = NDArray[np.int8]
Flags = NDArray[np.bool_]

LEAST_UPRIGHT = math.sqrt(0.75)
"""Cosine of the tilt at which a robot has tipped, 30 degrees."""


@dataclass(frozen=True, eq=False)
class MujocoPlant:
    """The robot of a model file on the ground of every world; `build` makes one.

    The batch is scratch space: `step` writes all it reads, so the same state and command give the same bits,
    whatever was stepped before, in whatever company and on however many threads.

    Attributes
    ----------
    batch : mujoco.batch.Batch
    ground : Ground
    slip_law : SlipLaw or None
        Prescribes slip by moving the floor's surface under each robot.
    standstill : Standstill
        The robot at rest.
    arena : (N,) array
        Distance from the world's origin at which a run ends [m].
    geometry : list of Shape
        What a viewer draws.
    model_id : str
        ``sha256:…`` of the compiled model file before any edit.
    wheel_rate_limit : float
        Above it a torque motor does not push [rad/s].
    """

    batch: Batch
    ground: Ground
    slip_law: SlipLaw | None
    standstill: Standstill
    arena: Array
    geometry: list[Shape]
    model_id: str
    wheel_rate_limit: float
    _columns: Columns
    _surroundings: Surroundings | None

    @classmethod
    def build(
        cls,
        model: str | Path | OwnModel = "magellan_pro",
        *,
        ground: Ground,
        slip_law: SlipLaw | None = None,
        timestep: float = 0.001,
        speed_drive: bool = True,
        torque_limit: float = 4.0,
        wheel_rate_limit: float = math.inf,
        arena: float | Array = 50.0,
        threads: int = 1,
        pushes: tuple[Push, ...] = (),
    ) -> MujocoPlant:
        """Compile a model and put it on its ground, one robot per world of `ground`.

        Parameters
        ----------
        model : str, Path or OwnModel
            A shipped model's name or a path.
        ground : Ground
            (N,) worlds.
        slip_law : SlipLaw, optional
            Prescribed slip; none by default.
        timestep : float
            Physics step [s].
        speed_drive : bool
            Wheel speed servos, told by `SpeedCommand`; otherwise torque motors, told by `TorqueCommand`.
        torque_limit : float
            Of each wheel [N·m].
        wheel_rate_limit : float
            A torque motor stops pushing a wheel that is faster, as if it had run out of voltage [rad/s].
        arena : float or (N,) array
            [m].
        threads : int
            On which the worlds are stepped; 0 takes every core.
        pushes : tuple of Push
            On every world.

        Raises
        ------
        ModelError
            If the model cannot be used.
        """
        path = find_model(model)
        compiled = compile_model(
            path,
            timestep,
            speed_drive,
            torque_limit,
            moving_floor=slip_law is not None,
            uneven_floor=ground.terrain is not None,
        )
        count = len(ground.friction)
        batch = Batch(compiled, nsim=count, nthread=threads)
        # on grip that does not move, whatever the ground
        standstill = settle(compile_model(path, timestep, speed_drive, torque_limit))
        lay(batch, ground, standstill.tyre)
        batch.bind("sensordata")
        columns, surroundings = Columns.of(batch), None
        if ground.varies or pushes or ground.terrain is not None:
            surroundings = Surroundings.of(batch, ground, pushes, standstill, columns)
        return cls(
            batch=batch,
            ground=ground,
            slip_law=slip_law,
            standstill=standstill,
            arena=np.array(np.broadcast_to(np.asarray(arena, dtype=np.float64), (count,))),
            geometry=shapes(compiled),
            model_id=model_id(path),
            wheel_rate_limit=wheel_rate_limit,
            _columns=columns,
            _surroundings=surroundings,
        )

    @property
    def _wheels(self) -> WheelGeometry:
        return WheelGeometry(self.wheel_radius, self.half_track)

    @property
    def wheel_radius(self) -> float:
        """R of the compiled model at rest [m]."""
        return self.standstill.wheel_radius

    @property
    def half_track(self) -> float:
        """B of the compiled model [m]."""
        return self.standstill.half_track

    def start(self, start: Start) -> MujocoState:
        """Return the robots at rest height on their planned poses, wheels and bodies at the planned rates.

        The body's velocity includes prescribed slip, but none that film or friction will cause.
        """
        columns, heading = self._columns, start.heading.tolist()
        cosine = np.array([math.cos(angle) for angle in heading])
        sine = np.array([math.sin(angle) for angle in heading])
        law = self.slip_law or NoSlip(len(heading))
        slip = law.affine(0.0).at(start.forward_speed)

        self.batch.reset(stage=int(mujoco.mjtStage.mjSTAGE_NONE))
        rows = self.batch.state.copy()
        rows[:, columns.position] = np.column_stack(
            [start.position, np.full(len(heading), self.standstill.height)]
        )
        rows[:, columns.quaternion] = [turned(angle, self.standstill.quaternion) for angle in heading]
        velocity = slipping_velocity(start.forward_speed, slip, cosine, sine)
        rows[:, columns.velocity] = np.stack(velocity, axis=-1)
        rows[:, columns.yaw_rate] = start.yaw_rate + slip.yaw
        wheel_rate = self._wheels.wheel_rates(start.forward_speed, start.yaw_rate)
        rows[:, columns.wheel_rate] = wheel_rate
        if self._columns.motor.servo:
            rows[:, columns.control] = wheel_rate

        if self._surroundings is not None:
            rows = self._surroundings.set_down(rows)

        planned = apply_decoupling(
            start.forward_speed, cosine, sine, start.forward_acceleration, start.yaw_rate + slip.yaw
        )
        status = np.zeros(len(rows), dtype=np.int8)
        state = MujocoState(rows, np.empty(0), planned, 0.0, status, self.ground.friction)
        self._load(state, rows[:, columns.control], tick=0.0)
        if self._surroundings is None:
            self.batch.forward()
            return replace(state, sensors=np.array(self.batch.bind("sensordata")))
        sensors, friction = self._surroundings.forward(self.batch, state, self.observe)
        return replace(state, sensors=sensors, friction=friction)

    def observe(self, state: MujocoState) -> Motion:
        """Return the motion at the state's instant."""
        return self._columns.motion(state, self._wheels)

    def details(self, state: MujocoState) -> tuple[BodyPose, WheelContact]:
        """Return the poses, and the wheels' forces over the last physics step (at the start: the first)."""
        return self._columns.pose(state.rows), self._columns.contact(
            state.rows, state.sensors, state.friction
        )

    def step(self, state: MujocoState, command: Command, tick: float) -> MujocoState:
        """Return the state one tick [s] later; worlds that ended stay as they are.

        Raises
        ------
        ValueError
            If the tick is not a multiple of the physics step.
        """
        timestep = float(self.batch.model.opt.timestep)
        steps = round(tick / timestep)
        if steps < 1 or abs(steps * timestep - tick) > 1e-9 * tick:
            raise ValueError(f"the tick of {tick} s is not a multiple of the physics step of {timestep} s")
        running = state.status == int(Status.RUNNING)
        if not np.count_nonzero(running):
            return replace(state, time=state.time + tick)
        self._load(state, self._told(state, command), tick)
        warned = self.batch.warning[..., 1].copy()
        if self._surroundings is None:
            good, sensors = advance(self.batch, running, steps), self.batch.bind("sensordata").copy()
            friction = state.friction
        else:
            good, sensors, friction = self._surroundings.advance(
                self.batch, state, self.observe, running, steps
            )

        # A bad world resets itself: only a warning, or a clock that did not advance, tells.
        rows = self.batch.state.copy()
        now = self.batch.warning[..., 1]
        if now.tobytes() != warned.tobytes():
            good &= (now == warned).all(axis=1)
        good &= np.abs(rows[:, 0] - state.rows[:, 0] - tick) < 0.5 * timestep
        columns = self._columns
        with np.errstate(invalid="ignore", over="ignore"):
            # a sum is finite where all its terms are, but for overflow
            if not math.isfinite(np.add.reduce(rows, axis=None)):
                good &= np.isfinite(rows).all(axis=1)
            acceleration = (rows[:, columns.velocity] - state.rows[:, columns.velocity]) / tick
        if np.count_nonzero(good) < len(good):
            rows[~good], sensors[~good] = state.rows[~good], state.sensors[~good]
            acceleration[~good] = state.acceleration[~good]
        status = self._judged(state.status, rows, running, good)
        return MujocoState(rows, sensors, acceleration, state.time + tick, status, friction)

    def _judged(self, status: Statuses, rows: Array, running: Flags, good: Flags) -> Statuses:
        outside = self._columns.distance(rows) > self.arena
        tipped = self._columns.upright(rows) < LEAST_UPRIGHT
        ended = outside | tipped | ~good
        if not np.count_nonzero(ended):
            return status
        new = status.copy()
        new[running & outside] = Status.LEFT_THE_ARENA
        new[running & tipped] = Status.TIPPED
        new[running & ~good] = Status.DIVERGED
        return new

    def _told(self, state: MujocoState, command: Command) -> Array:
        """Return what the actuators are told (N, 2): set points of servos, or torques held for the tick.

        Raises
        ------
        TypeError
            If the command is of the other drive.
        """
        if isinstance(command, SpeedCommand) is not self._columns.motor.servo:
            raise TypeError(f"a {type(command).__name__} does not fit the drive of this plant")
        if isinstance(command, SpeedCommand):
            return command.wheel_rate
        torque = (command.wheel_torque_start + command.wheel_torque_end) / 2.0
        rate = state.rows[:, self._columns.wheel_rate]
        spent = (np.abs(rate) >= self.wheel_rate_limit) & (torque * rate > 0.0)
        return np.where(spent, 0.0, torque)

    def _load(self, state: MujocoState, wheel_command: Array, tick: float) -> None:
        """Write the state, the command, and whatever the ground makes of them into the batch."""
        batch = self.batch
        batch.state[...] = state.rows
        batch.state[:, self._columns.control] = wheel_command
        speed = state.rows[:, self._columns.wheel_rate] * self.wheel_radius
        if self.ground.creeps:
            soften(batch, viscosity(self.ground, speed), self.standstill.tyre)
        if self.slip_law is not None:
            motion = self.observe(state)
            slip = self.slip_law.affine(state.time).at(motion.forward_speed)
            surface = floor_motion(slip, *ahead(motion, 0.5 * tick))
            batch.expand("geom_surfacevel")[:, batch.model.geom("floor").id] = surface
