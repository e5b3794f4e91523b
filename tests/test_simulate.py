from dataclasses import replace

import numpy as np
import pytest

from slipctl.plants.ode import KinematicOde
from slipctl.simulate import simulate
from slipctl.theory.reference import Line, Placement
from slipctl.theory.robot import MAGELLAN_PRO
from slipctl.theory.slip import NoSlip, ProportionalSlip
from slipctl.tick import Status
from tests.builders import at_origin, full, nominal_law, ode_plant, planned_start, rows_of, start_of, track

TICK = 0.02


def lines(*speeds):
    return Line(np.array(speeds), at_origin(len(speeds)))


def test_every_row_is_written_once_and_in_order():
    references = rows_of(lines(0.3), TICK, 1.0)
    seen = []
    ending = simulate(
        ode_plant(NoSlip(1), 1),
        nominal_law(full(1, -1.0)),
        references,
        planned_start(references),
        TICK,
        lambda k, row: seen.append((k, float(row.reference.position[0, 0]))),
    )
    assert [k for k, _ in seen] == list(range(51))
    np.testing.assert_array_equal([x for _, x in seen], references.position[:, 0, 0])
    assert list(ending.status) == [Status.RUNNING]
    assert list(ending.last_row) == [50]


def test_the_decision_of_a_row_acts_after_it_and_the_last_one_never():
    """Row 0 is the start; row k + 1 is one step of the plant away from row k under row k's command."""

    class Counting(KinematicOde):
        steps = 0

        def step(self, state, command, tick):
            Counting.steps += 1
            return super().step(state, command, tick)

    slip = ProportionalSlip(full(2, 0.3), full(2, -0.2), full(2, 0.5))
    plant = Counting(MAGELLAN_PRO, slip, full(2, 50.0))
    references = rows_of(lines(0.3, 0.6), TICK, 0.4)
    start = planned_start(references)
    run = track(plant, nominal_law(full(2, -1.0)), references, TICK, start)
    assert Counting.steps == len(run.rows) - 1 == 20

    state = plant.start(start)
    for k, row in enumerate(run.rows):
        np.testing.assert_array_equal(row.motion.position, state.position)
        np.testing.assert_array_equal(row.motion.velocity, plant.observe(state).velocity)
        np.testing.assert_array_equal(row.motion.forward_speed, state.forward_speed)
        np.testing.assert_allclose(row.slip.lateral, -0.2 * state.forward_speed, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(row.reference.position, references.position[k])
        state = plant.step(state, row.decision.command, TICK)


def test_memory_goes_from_decision_to_decision():
    references = rows_of(lines(0.3), TICK, 0.4)
    law = nominal_law(full(1, -1.0))
    run = track(ode_plant(ProportionalSlip(*(full(1, 0.3),) * 3), 1), law, references, TICK)
    memory = law.start(planned_start(references))
    for row in run.rows:
        again = law.update(memory, row.reference, row.motion, TICK)
        np.testing.assert_array_equal(again.command.wheel_rate, row.decision.command.wheel_rate)
        memory = again.memory
    assert memory.forward_speed[0] != 0.3


def test_world_that_ends_early_keeps_the_row_before_its_end_and_the_others_run_on():
    arena = np.array([0.5, 50.0, 0.9])
    plant = KinematicOde(MAGELLAN_PRO, NoSlip(len(arena)), arena)
    run = track(plant, nominal_law(full(3, -1.0)), rows_of(lines(1.0, 1.0, 1.0), TICK, 2.0), TICK)
    assert len(run.rows) == 101
    expected = [Status.LEFT_THE_ARENA, Status.RUNNING, Status.LEFT_THE_ARENA]
    assert list(run.ending.status) == expected
    assert run.ending.last_row[1] == 100
    x = run.stack("motion", "position")[..., 0]
    for world in (0, 2):
        last = run.ending.last_row[world]
        assert x[last, world] <= arena[world] < x[last + 1, world]
        assert x[last, world] == pytest.approx(arena[world], abs=TICK)
    assert x[-1, 1] == pytest.approx(2.0)


def test_loop_stops_when_every_world_has_ended():
    plant = KinematicOde(MAGELLAN_PRO, NoSlip(2), np.array([0.5, 0.7]))
    run = track(plant, nominal_law(full(2, -1.0)), rows_of(lines(1.0, 1.0), TICK, 100.0), TICK)
    assert len(run.rows) == run.ending.last_row.max() + 1 < 40
    assert list(run.ending.status) == [Status.LEFT_THE_ARENA] * 2


def test_diverged_world_is_counted_at_its_last_good_row():
    references = rows_of(lines(0.5, 0.5), TICK, 0.4)
    start = planned_start(references)
    references.acceleration[7:, 0] = np.nan  # the command of row 7 is no number
    run = track(ode_plant(NoSlip(2), 2), nominal_law(full(2, -1.0)), references, TICK, start)
    assert list(run.ending.status) == [Status.DIVERGED, Status.RUNNING]
    assert list(run.ending.last_row) == [7, 20]
    assert np.isfinite(run.stack("motion", "velocity")).all()
    clean = track(ode_plant(NoSlip(1), 1), nominal_law(full(1, -1.0)), rows_of(lines(0.5), TICK, 0.4), TICK)
    np.testing.assert_array_equal(
        run.stack("motion", "position")[:, 1], clean.stack("motion", "position")[:, 0]
    )


def test_controller_starts_with_the_planned_speed():
    references = rows_of(lines(0.5), TICK, 0.1)
    start = start_of(np.zeros((1, 2)), np.zeros(1), full(1, 0.2), np.zeros(1))
    run = track(ode_plant(NoSlip(1), 1), nominal_law(full(1, -1.0)), references, TICK, start)
    assert run.rows[0].motion.forward_speed[0] == 0.2
    command = run.rows[0].decision.command
    assert command.forward_speed[0] == 0.2 + command.forward_acceleration[0] * TICK


def test_offset_start_is_pulled_in_at_the_rate_of_the_poles():
    """Without slip the error obeys ë + 2p ė + p² e = 0: e(t) = e₀ (1 + p t) e^{−pt}, here across the line."""
    tick, pole = 0.002, -1.5
    line = Line(np.array([0.4]), Placement(np.zeros(1), np.zeros(1), np.zeros(1)))
    references = rows_of(line, tick, 4.0)
    plan = planned_start(references)
    start = replace(plan, position=plan.position + np.array([[0.0, 0.1]]))
    run = track(ode_plant(NoSlip(1), 1), nominal_law(full(1, pole)), references, tick, start)
    y = run.stack("motion", "position")[:, 0, 1]
    t = np.arange(len(y)) * tick
    np.testing.assert_allclose(y, 0.1 * (1.0 - pole * t) * np.exp(pole * t), rtol=0, atol=3e-4)


def test_progress_is_told_now_and_then():
    references = rows_of(lines(0.3), TICK, 6.0)
    told = []
    simulate(
        ode_plant(NoSlip(1), 1),
        nominal_law(full(1, -1.0)),
        references,
        planned_start(references),
        TICK,
        lambda *_: None,
        told.append,
    )
    assert len(told) > 2
    assert told == sorted(told)
    assert told[-1] <= 300
