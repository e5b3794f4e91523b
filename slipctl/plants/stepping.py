"""Stepping the worlds of a batch, and what place and time decide anew before every physics step."""

# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco.batch import Batch, SimulationError
from numpy.typing import NDArray

from slipctl.plants.film import LARGEST_SHARE, LEAST_FRICTION, contact_slip, film_force
from slipctl.plants.ground import Ground, rub, soften, viscosity
from slipctl.plants.model import ModelError
from slipctl.plants.patches import contact_points
from slipctl.plants.pushes import Push, lever, mean_force
from slipctl.plants.relief import Relief
from slipctl.plants.rows import Columns, MujocoState
from slipctl.plants.standstill import Standstill, inertia
from slipctl.theory.robot import WheelGeometry
from slipctl.tick import WHEELS, Array, Motion

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Acting:
    """What acts in a physics step.

    Attributes
    ----------
    friction : (N, 2) array
        Under the wheels [1].
    film : (N, 2, 2) array
        Force of a film in places on the wheels, world x, y [N].
    normal : (N, 2, 3) array or None
        Of the floor under the wheels; None where it is level.
    """

    friction: Array
    film: Array
    normal: Array | None


@dataclass(frozen=True)
class Surroundings:
    """What patches, changes of the floor and pushes do in the physics step that comes next.

    Attributes
    ----------
    ground : Ground
    pushes : tuple of Push
    standstill : Standstill
    columns : Columns
    bodies : (3,) int array
        MuJoCo's ids of the base and of the left and right wheel.
    arm : (3,) array
        From the base's own centre of mass to that of the whole robot, body axes [m].
    wet_in_places : (N,) bool array
        Worlds in which films are forces of their own.
    softened : (N,) bool array
        Worlds in which a film lies everywhere or nowhere, and comes or goes with time.
    relief : Relief or None
        Of an uneven floor.
    """

    ground: Ground
    pushes: tuple[Push, ...]
    standstill: Standstill
    columns: Columns
    bodies: NDArray[np.intp]
    arm: Array
    wet_in_places: Flags
    softened: Flags
    relief: Relief | None

    @classmethod
    def of(
        cls, batch: Batch, ground: Ground, pushes: tuple[Push, ...], standstill: Standstill, columns: Columns
    ) -> Surroundings:
        """Return the surroundings of a batch.

        Raises
        ------
        ModelError
            If a film in a patch is so viscous that it would swing at the physics step.
        """
        model = batch.model
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        base = model.body("base").id
        arm = data.xmat[base].reshape(3, 3).T @ (data.subtree_com[base] - data.xipos[base])
        wet = ground.wet_in_places()
        films = [part.film[wet] for part in (ground, *ground.patches, *ground.changes)]
        most = max((float(film) for part in films for film in part if not np.isnan(film)), default=0.0)
        turning = inertia(model, WheelGeometry(standstill.wheel_radius, standstill.half_track))
        mass = turning.wheel_inertia / standstill.wheel_radius**2
        largest = LARGEST_SHARE * mass / float(model.opt.timestep)
        if most > largest:
            raise ModelError(
                f"a film of {most:g} N·s/m on a floor with patches is too viscous for a physics step of "
                f"{model.opt.timestep:g} s: at most {largest:.4g} N·s/m, or a shorter plant.timestep"
            )
        coming = ~np.isnan(ground.film)
        for change in ground.changes:
            coming = coming | ~np.isnan(change.film)
        return cls(
            ground=ground,
            pushes=pushes,
            standstill=standstill,
            columns=columns,
            bodies=np.array([base, *(model.body(f"{side}_wheel").id for side in WHEELS)]),
            arm=np.array(arm),
            wet_in_places=wet,
            softened=coming & ~wet,
            relief=None if ground.terrain is None else Relief.of(batch, ground.terrain, columns),
        )

    def surround(
        self, batch: Batch, time: float, motion: Motion, rows: Array, sensors: Array, timestep: float
    ) -> Acting:
        """Write what acts in the next physics step into the batch.

        Parameters
        ----------
        batch : mujoco.batch.Batch
        time : float
            At which the step begins [s].
        motion : Motion
            At that time.
        rows, sensors : arrays
            The engine's states at that time and the sensors' last readings.
        timestep : float
            [s].
        """
        columns, ground = self.columns, self.ground
        acting = batch.bind("xfrc_applied")
        points = contact_points(motion.position, motion.heading_vector, self.standstill.half_track)
        friction, film = ground.under(points, time)
        force = np.zeros((*film.shape, 2))
        if ground.varies:
            in_place = self.wet_in_places[:, None] & ~np.isnan(film)
            rub(batch, np.where(in_place, LEAST_FRICTION, friction))
            if self.softened.any():
                wheel_speed = motion.wheel_rate * self.standstill.wheel_radius
                wanted = viscosity(replace(ground, film=film[:, 0]), wheel_speed)
                soften(batch, wanted, self.standstill.tyre, self.softened)
            if self.wet_in_places.any():
                radius = self._rolling_radius(rows)
                tilt_rate = rows[:, columns.yaw_rate - 2 : columns.yaw_rate]
                slip = contact_slip(motion, tilt_rate, radius, self.standstill.half_track)
                load = np.stack([sensors[:, part.stop - 1] for part in columns.force], axis=-1)
                force = film_force(
                    slip, motion.heading_vector, np.where(in_place, film, np.nan), friction * load
                )
                for wheel, body in enumerate(self.bodies[1:].tolist()):
                    x, y = force[:, wheel, 0], force[:, wheel, 1]
                    acting[:, body, 0], acting[:, body, 1] = x, y
                    acting[:, body, 3], acting[:, body, 4] = radius[:, wheel] * y, -radius[:, wheel] * x
        if self.pushes:
            push = mean_force(self.pushes, time, timestep)
            acting[:, self.bodies[0], :2] = push
            acting[:, self.bodies[0], 3:] = lever(push, rows[:, columns.quaternion], self.arm)
        normal = None if self.relief is None else self.relief.lay(batch, rows)
        return Acting(friction, force, normal)

    def _rolling_radius(self, rows: Array) -> Array:
        """Return how far below its axle each wheel touches the floor (N, 2) [m]: midway in the overlap."""
        at = self.columns.quaternion.start
        rise = rows[:, self.columns.position.stop - 1] - self.standstill.height
        tilt = 2.0 * (rows[:, at + 2] * rows[:, at + 3] + rows[:, at] * rows[:, at + 1])
        apart = self.standstill.half_track * tilt
        return self.standstill.wheel_radius + 0.5 * np.stack([rise + apart, rise - apart], axis=-1)

    def told(self, sensors: Array, acting: Acting) -> Array:
        """Return the sensors' readings with films in places added, as if the floor were level."""
        sensors = sensors.copy()
        for wheel, part in enumerate(self.columns.force):
            sensors[:, part.start : part.start + 2] += acting.film[:, wheel]
        if self.relief is None or acting.normal is None:
            return sensors
        return self.relief.told(sensors, acting.normal)

    def set_down(self, rows: Array) -> Array:
        """Return rows (N, nstate) at rest height on level floor as they are on this floor."""
        return rows if self.relief is None else self.relief.set_down(rows, self.standstill.half_track)

    def forward(
        self, batch: Batch, state: MujocoState, observe: Callable[[MujocoState], Motion]
    ) -> tuple[Array, Array]:
        """Return what the sensors read at the start (N, nsensordata) and the friction (N, 2) there."""
        motion, timestep = observe(state), float(batch.model.opt.timestep)
        loaded = np.zeros_like(batch.bind("sensordata"))
        self.surround(batch, state.time, motion, state.rows, loaded, timestep)
        batch.forward()  # a film in places is limited by the load, which is known only now
        loaded = np.array(batch.bind("sensordata"))
        acting = self.surround(batch, state.time, motion, state.rows, loaded, timestep)
        batch.forward()
        return self.told(np.array(batch.bind("sensordata")), acting), acting.friction

    def advance(
        self,
        batch: Batch,
        state: MujocoState,
        observe: Callable[[MujocoState], Motion],
        running: Flags,
        steps: int,
    ) -> tuple[Flags, Array, Array]:
        """Step the running worlds, the state being loaded already.

        Returns
        -------
        good : (N,) bool array
            Running worlds without an error.
        sensors : (N, nsensordata) array
        friction : (N, 2) array
            Under the wheels in the last step.
        """
        timestep = float(batch.model.opt.timestep)
        stepping, sensors = running.copy(), state.sensors
        acting = Acting(state.friction, np.zeros((*state.friction.shape, 2)), None)
        for k in range(steps):
            if not stepping.any():
                break
            with np.errstate(invalid="ignore"):
                motion = observe(replace(state, rows=batch.state))
                acting = self.surround(
                    batch, state.time + k * timestep, motion, batch.state, sensors, timestep
                )
            stepping = advance(batch, stepping, 1)
            sensors = np.array(batch.bind("sensordata"))
        sensors = np.where(running[:, None], self.told(sensors, acting), state.sensors)
        return stepping, sensors, np.where(running[:, None], acting.friction, state.friction)


def advance(batch: Batch, running: Flags, steps: int) -> Flags:
    """Step the running worlds; return those of them without an error."""
    good = running.copy()
    # MuJoCo must not write MUJOCO_LOG.TXT into the user's folder: the status of the world says it all
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(_unheard)
    try:
        batch.step(None if np.count_nonzero(running) == len(running) else running, steps)
    except SimulationError as error:
        good[error.ids] = False
    finally:
        mujoco.set_mju_user_warning(before)
    return good


def _unheard(message: str) -> None:
    pass
