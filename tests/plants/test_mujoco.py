# MuJoCo's compiled modules carry no type stubs, so pyright knows none of their names.
# pyright: reportAttributeAccessIssue=false

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from mujoco.batch import SimulationError

from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.rows import MujocoState
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import Affine, ProportionalSlip, SlipLaw, measure_slip
from slipctl.tick import Slip, Start, Status
from tests.builders import start_of
from tests.plants.driving import MASS, command, drive, full, ground, pushed, start

WORLDS = 5
NAN = math.nan


def mixed(rows: slice = slice(None)) -> Ground:
    """Return grip, film, creep, a slope and ice in one batch."""
    return Ground(
        friction=np.array([[0.8, 0.8], [0.5, 0.5], [0.8, 0.8], [0.6, 0.6], [0.05, 0.1]])[rows],
        film=np.array([NAN, 100.0, NAN, NAN, NAN])[rows],
        creep_stiffness=np.array([NAN, NAN, 200.0, NAN, NAN])[rows],
        slope=np.array([0.0, 0.05, 0.0, 0.1, 0.0])[rows],
        downhill=np.array([0.0, 1.0, 0.0, 2.0, 0.0])[rows],
    )


def law(rows: slice = slice(None)) -> ProportionalSlip:
    share = np.array([0.4, 0.0, 0.1, -0.2, 0.3])[rows]
    return ProportionalSlip(share, 0.5 * share, -share)


def starts(rows: slice = slice(None)) -> Start:
    i = np.arange(WORLDS)[rows].astype(float)
    return start_of(np.stack([i, -i], axis=-1), 0.9 * i, 0.2 + 0.1 * i, 0.5 - 0.2 * i)


def bits(state: MujocoState, rows: slice = slice(None)) -> tuple[bytes, bytes, bytes]:
    return state.rows[rows].tobytes(), state.sensors[rows].tobytes(), state.status[rows].tobytes()


def run(plant: MujocoPlant, begin: Start, ticks: int = 40, rows: slice = slice(None)) -> MujocoState:
    state = plant.start(begin)
    i = np.arange(WORLDS)[rows].astype(float)
    for k in range(ticks):
        state = plant.step(state, command(0.3 + 0.02 * k - 0.05 * i, 1.0 - 0.4 * i + 0.01 * k), 0.01)
    return state


@pytest.mark.parametrize("slip_law", [None, law])
def test_batch_of_one_is_its_row_in_a_batch_of_many(slip_law: SlipLaw | None) -> None:
    together = MujocoPlant.build(ground=mixed(), slip_law=slip_law and law())
    many = run(together, starts())
    assert not many.status.any()
    for i in range(WORLDS):
        row = slice(i, i + 1)
        alone = MujocoPlant.build(ground=mixed(row), slip_law=slip_law and law(row))
        one = run(alone, starts(row), rows=row)
        assert bits(one) == bits(many, row)
        for at_one, at_many in zip(_seen(alone, one), _seen(together, many), strict=True):
            assert np.array_equal(at_one, at_many[row])


def _seen(plant: MujocoPlant, state: MujocoState) -> list[np.ndarray]:
    pose, contact = plant.details(state)
    return [
        getattr(part, field.name) for part in (plant.observe(state), pose, contact) for field in fields(part)
    ]


def test_any_number_of_threads_gives_the_same_bits() -> None:
    results = {
        bits(run(MujocoPlant.build(ground=mixed(), slip_law=law(), threads=threads), starts()))
        for threads in (1, 2, 3)
    }
    assert len(results) == 1


def test_rows_are_those_of_a_plain_loop_of_mj_step() -> None:
    """Both the states and the bound sensors, for every world's own model and without `mujoco.batch`."""
    plant = MujocoPlant.build(ground=replace(mixed(), creep_stiffness=full(WORLDS, NAN)))
    begun = plant.start(starts())
    ended = run(plant, starts())
    i = np.arange(WORLDS).astype(float)
    spec = mujoco.mjtState.mjSTATE_INTEGRATION
    for world in range(WORLDS):
        model = plant.batch.get_model(world)
        data = mujoco.MjData(model)
        mujoco.mj_setState(model, data, begun.rows[world], spec)
        for k in range(40):
            speed, turn = 0.3 + 0.02 * k - 0.05 * i, 1.0 - 0.4 * i + 0.01 * k
            data.ctrl[:] = MAGELLAN_PRO.wheel_rates(speed, turn)[world]
            for _ in range(10):
                mujoco.mj_step(model, data)
        row = np.empty(mujoco.mj_stateSize(model, spec))
        mujoco.mj_getState(model, data, row, spec)
        assert row.tobytes() == ended.rows[world].tobytes()
        assert data.sensordata.tobytes() == ended.sensors[world].tobytes()


def test_a_step_is_pure() -> None:
    plant = MujocoPlant.build(ground=mixed(), slip_law=law())
    state = run(plant, starts(), ticks=10)
    before = bits(state)
    told = command(full(WORLDS, 0.4), full(WORLDS, 0.7))
    first = plant.step(state, told, 0.01)
    # something else entirely in between, even the end of a world
    wild = plant.step(pushed(plant, first, np.full((WORLDS, 2), 1e12)), told, 0.01)
    assert wild.status.all()
    plant.start(starts())
    assert bits(plant.step(state, told, 0.01)) == bits(first)
    assert bits(state) == before


def test_start_is_the_planned_pose_at_the_planned_rates() -> None:
    plant = MujocoPlant.build(ground=mixed())
    begin = starts()
    motion = plant.observe(plant.start(begin))
    assert np.array_equal(motion.position, begin.position)
    assert motion.heading_vector == pytest.approx(
        np.stack([np.cos(begin.heading), np.sin(begin.heading)], axis=-1), abs=1e-15
    )
    assert motion.forward_speed == pytest.approx(begin.forward_speed, rel=1e-14)
    assert motion.yaw_rate == pytest.approx(begin.yaw_rate, rel=1e-13)
    assert np.array_equal(motion.heading_rate, begin.yaw_rate)
    slip = measure_slip(motion)
    for part in (slip.longitudinal, slip.lateral, slip.yaw):
        assert np.abs(part).max() < 1e-14
    pose, contact = plant.details(plant.start(begin))
    assert pose.height == pytest.approx(0.082142916, abs=1e-8)
    assert contact.normal_force[0] == pytest.approx([0.4 * MASS * 9.81] * 2, rel=1e-4)


def test_start_includes_prescribed_slip() -> None:
    plant = MujocoPlant.build(ground=mixed(), slip_law=law())
    begin = starts()
    slip = measure_slip(plant.observe(plant.start(begin)))
    wanted = law().affine(0.0).at(begin.forward_speed)
    assert slip.longitudinal == pytest.approx(wanted.longitudinal, abs=1e-14)
    assert slip.lateral == pytest.approx(wanted.lateral, abs=1e-14)
    assert slip.yaw == pytest.approx(wanted.yaw, abs=1e-14)


def test_standing_still_on_flat_grip_nothing_moves() -> None:
    plant = MujocoPlant.build(ground=ground())
    _, seen = drive(plant, plant.start(start(heading=1.0)), 0.0, 0.0, 0.5)
    assert np.abs(seen.motion[-1].velocity).max() < 1e-9
    assert np.abs(seen.motion[-1].position).max() < 1e-9


def test_a_left_turn_has_the_signs_of_a_left_turn() -> None:
    plant = MujocoPlant.build(ground=ground())
    state, seen = drive(plant, plant.start(start(forward_speed=0.5, yaw_rate=1.0)), 0.5, 1.0, 1.0)
    motion, contact = seen.motion[-1], seen.contact[-1]
    assert motion.position[0] == pytest.approx([0.5 * math.sin(1.0), 0.5 * (1.0 - math.cos(1.0))], rel=5e-3)
    assert motion.heading_vector[0] == pytest.approx([math.cos(1.0), math.sin(1.0)], abs=2e-3)
    assert motion.heading_rate[0] == pytest.approx(1.0, rel=2e-3)
    assert motion.wheel_rate[0, 0] < motion.wheel_rate[0, 1]
    assert motion.forward_speed[0] == pytest.approx(0.5, rel=1e-4)
    # towards the centre, on the left; the outer wheel carries more
    assert contact.lateral_force.sum() == pytest.approx(MASS * 0.5 * 1.0, rel=5e-3)
    assert contact.normal_force[0, 1] > contact.normal_force[0, 0]
    pose, _ = plant.details(state)
    assert seen.motion[-1].wheel_angle[0] == pytest.approx(
        MAGELLAN_PRO.wheel_rates(full(1, 0.5), full(1, 1.0))[0], rel=1e-3
    )
    assert 2.0 * math.atan2(pose.quaternion[0, 3], pose.quaternion[0, 0]) == pytest.approx(1.0, abs=2e-3)


def test_speeding_up_takes_forward_force_and_torque() -> None:
    plant = MujocoPlant.build(ground=ground())
    _, seen = drive(plant, plant.start(start()), lambda time: 0.5 * time, 0.0, 1.0, tick=0.001)
    contact = seen.contact[-1]
    assert contact.longitudinal_force.sum() == pytest.approx(MASS * 0.5, rel=1e-2)
    spin = (0.003403125 + 0.004) * 0.5 / 0.0825
    assert contact.torque[0] == pytest.approx([MASS * 0.5 * 0.0825 / 2.0 + spin] * 2, rel=1e-2)


def test_torque_is_limited() -> None:
    plant = MujocoPlant.build(ground=ground(2), torque_limit=1.5)
    _, seen = drive(plant, plant.start(start(2)), 5.0, 0.0, 0.05)
    assert (seen.contact[-1].torque == 1.5).all()


def test_position_and_velocity_belong_to_one_instant() -> None:
    """A velocity or heading that lagged by a physics step would show as lateral slip v·w·step, 0.5 mm/s."""
    plant = MujocoPlant.build(ground=ground())
    state = plant.start(start(forward_speed=0.5, yaw_rate=1.0))
    told = command(full(1, 0.5), full(1, 1.0))
    slips = []
    for _ in range(300):
        state = plant.step(state, told, 0.001)
        slips.append(measure_slip(plant.observe(state)).lateral[0])
    # what remains is the curve's own v·w/b_t
    assert slips[-1] == pytest.approx(0.5 / 800.0, rel=0.01)


@pytest.mark.parametrize("planted", [math.nan, math.inf, 1e12])
def test_a_state_gone_wild_diverges_and_the_others_go_on(planted: float) -> None:
    plant = MujocoPlant.build(ground=ground(3))
    state = plant.start(start(3, forward_speed=0.2))
    velocity = np.array(plant.observe(state).velocity)
    velocity[1, 0] = planted
    wild = pushed(plant, state, velocity)
    told = command(full(3, 0.2), full(3, 0.0))
    after = plant.step(wild, told, 0.01)
    assert after.status.tolist() == [Status.RUNNING, Status.DIVERGED, Status.RUNNING]
    calm = plant.step(state, told, 0.01)
    assert not calm.status.any()
    assert bits(after, slice(0, 1)) == bits(calm, slice(0, 1))
    assert bits(after, slice(2, 3)) == bits(calm, slice(2, 3))
    # it stays where it was, and stays ended
    again = plant.step(after, told, 0.01)
    assert again.status.tolist() == after.status.tolist()
    assert again.rows[1].tobytes() == wild.rows[1].tobytes()
    assert again.rows[0].tobytes() == plant.step(calm, told, 0.01).rows[0].tobytes()


def test_a_command_that_is_no_number_diverges(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo would put zero in its place, warn, and leave a log file where the user stands."""
    monkeypatch.chdir(tmp_path)
    plant = MujocoPlant.build(ground=ground(2))
    told = command(np.array([0.2, NAN]), full(2, 0.0))
    after = plant.step(plant.start(start(2)), told, 0.01)
    assert after.status.tolist() == [Status.RUNNING, Status.DIVERGED]
    assert list(tmp_path.iterdir()) == []


def test_an_engine_error_ends_its_world_only(monkeypatch: pytest.MonkeyPatch) -> None:
    plant = MujocoPlant.build(ground=ground(3))
    step = plant.batch.step

    def failing(*args: Any) -> None:
        step(*args)
        raise SimulationError(np.array([2]), "planted")

    monkeypatch.setattr(plant.batch, "step", failing)
    state = plant.start(start(3, forward_speed=0.2))
    after = plant.step(state, command(full(3, 0.2), full(3, 0.0)), 0.01)
    assert after.status.tolist() == [Status.RUNNING, Status.RUNNING, Status.DIVERGED]
    assert after.rows[2].tobytes() == state.rows[2].tobytes()
    assert after.rows[0, 0] == pytest.approx(0.01)


def test_leaving_the_arena_ends_a_world() -> None:
    plant = MujocoPlant.build(ground=ground(2), arena=np.array([1.0, 50.0]))
    begin = replace(start(2, forward_speed=1.0), position=np.array([[0.6, 0.78], [0.6, 0.78]]))
    told = command(full(2, 1.0), full(2, 0.0))
    state = plant.start(begin)
    while not state.status.any():
        state = plant.step(state, told, 0.01)
    assert state.status.tolist() == [Status.LEFT_THE_ARENA, Status.RUNNING]
    # the row in which it left is kept
    assert 1.0 < np.hypot(*plant.observe(state).position[0]) < 1.011
    assert plant.step(state, told, 0.01).rows[0].tobytes() == state.rows[0].tobytes()


@pytest.mark.parametrize("axis", [1, 2])
def test_tipping_beyond_thirty_degrees_ends_a_world(axis: int) -> None:
    plant = MujocoPlant.build(ground=ground(2))
    state = plant.start(start(2))
    rows = state.rows.copy()
    for world, lean in enumerate((math.radians(31.0), math.radians(29.0))):
        quaternion = np.array([math.cos(lean / 2.0), 0.0, 0.0, 0.0])
        quaternion[axis] = math.sin(lean / 2.0)
        rows[world, plant._columns.quaternion] = quaternion
    rows[:, plant._columns.position.start + 2] = 1.0  # in the air, so that nothing rights it
    after = plant.step(replace(state, rows=rows), command(full(2, 0.0), full(2, 0.0)), 0.001)
    assert after.status.tolist() == [Status.TIPPED, Status.RUNNING]


def test_a_tick_must_be_a_multiple_of_the_physics_step() -> None:
    plant = MujocoPlant.build(ground=ground())
    state = plant.start(start())
    for tick in (0.0105, 0.0004):
        with pytest.raises(ValueError, match="not a multiple"):
            plant.step(state, command(full(1, 0.0), full(1, 0.0)), tick)


class Listening(ProportionalSlip):
    """Proportional slip that keeps what it was asked."""

    def __init__(self, longitudinal: float):
        super().__init__(full(1, longitudinal), full(1, 0.0), full(1, 0.0))
        object.__setattr__(self, "times", [])
        object.__setattr__(self, "speeds", [])
        self.times: list[float]
        self.speeds: list[float]

    def affine(self, time: float) -> Affine:
        self.times.append(time)
        speeds = self.speeds

        class Told(Affine):
            def at(self, forward_speed: np.ndarray) -> Slip:
                speeds.append(float(forward_speed[0]))
                return super().at(forward_speed)

        plain = super().affine(time)
        return Told(plain.fraction, plain.offset)


def test_time_advances_by_ticks_and_reaches_the_slip_law() -> None:
    law = Listening(0.0)
    plant = MujocoPlant.build(ground=ground(), slip_law=law)
    state = plant.start(start())
    for _ in range(3):
        state = plant.step(state, command(full(1, 0.1), full(1, 0.0)), 0.02)
    assert state.time == pytest.approx(0.06)
    assert law.times[-3:] == pytest.approx([0.0, 0.02, 0.04])


def test_the_slip_law_follows_the_measured_signed_wheel_speed() -> None:
    """Not the commanded one, and not its size: stopping from full speed, slip fades with the wheels."""
    law = Listening(0.2)
    plant = MujocoPlant.build(ground=ground(), slip_law=law)
    state = plant.start(start(forward_speed=-0.5))
    measured = []
    for _ in range(5):
        measured.append(float(plant.observe(state).forward_speed[0]))
        state = plant.step(state, command(full(1, 0.3), full(1, 0.0)), 0.01)
    assert law.speeds[-5:] == measured
    assert measured[0] == pytest.approx(-0.5)
    assert measured[1] not in (-0.5, 0.3)
