"""A law that is wrong about its robot: the wheels obey, the robot does something else."""

from dataclasses import replace

import numpy as np
import pytest

from slipctl.control.believing import BelievingLaw
from slipctl.control.drive import DriveLimits
from slipctl.theory.robot import MAGELLAN_PRO, WheelGeometry
from slipctl.theory.slip import NoSlip, ProportionalSlip
from tests.builders import full, nominal_law, ode_plant, planned_start, rows_of, table_one, track

TICK = 0.01
TRUE = MAGELLAN_PRO


def limits(geometry):
    return DriveLimits(geometry, full(1, 50.0), full(1, 500.0), full(1, 1e-3))


def misled(radius=1.0, track_width=1.0):
    """Return a law that believes in scaled lengths, and what it believes."""
    one = np.ones(1)
    believed = WheelGeometry(one * (radius * TRUE.wheel_radius), one * (track_width * TRUE.half_track))
    return BelievingLaw(nominal_law(full(1, -0.5), limits(believed)), believed, TRUE), believed


def one_tick(law):
    references = rows_of(table_one(), TICK, 1.0)
    start = planned_start(references)
    plant = ode_plant(NoSlip(1), 1)
    state = plant.start(replace(start, yaw_rate=full(1, 0.2)))
    decision = law.update(law.start(start), references.row(5), plant.observe(state), TICK)
    return decision, plant.step(state, decision.command, TICK), plant


def test_wheels_believed_too_large_turn_too_slowly():
    honest, _, _ = one_tick(misled()[0])
    wrong, after, plant = one_tick(misled(radius=1.05)[0])
    np.testing.assert_allclose(wrong.command.wheel_rate * 1.05, honest.command.wheel_rate, rtol=1e-14)
    assert plant.observe(after).forward_speed[0] * 1.05 == pytest.approx(honest.command.forward_speed[0])
    assert plant.observe(after).yaw_rate[0] * 1.05 == pytest.approx(honest.command.yaw_rate[0])
    assert wrong.memory.forward_speed[0] == honest.memory.forward_speed[0]


def test_a_track_believed_too_wide_turns_the_robot_too_much_and_drives_it_right():
    honest, _, _ = one_tick(misled()[0])
    wrong, after, plant = one_tick(misled(track_width=1.25)[0])
    seen = plant.observe(after)
    assert seen.yaw_rate[0] == pytest.approx(1.25 * honest.command.yaw_rate[0], rel=1e-14)
    assert seen.forward_speed[0] == honest.command.forward_speed[0]
    np.testing.assert_allclose(seen.wheel_rate, wrong.command.wheel_rate, rtol=1e-12)


@pytest.mark.parametrize(("radius", "track_width"), [(0.9, 1.0), (1.0, 1.3), (1.2, 0.7)])
def test_the_plant_s_speeds_are_those_of_the_commanded_wheels(radius, track_width):
    decision, after, plant = one_tick(misled(radius, track_width)[0])
    np.testing.assert_allclose(plant.observe(after).wheel_rate, decision.command.wheel_rate, rtol=1e-12)
    step = decision.command.forward_acceleration * TICK
    before = decision.command.forward_speed - step
    along = 1.0 / radius
    references = rows_of(table_one(), TICK, 1.0)
    np.testing.assert_allclose(before, planned_start(references).forward_speed * along, rtol=1e-12)


def test_what_the_law_reckons_from_the_wheels_is_by_its_own_lengths():
    law, believed = misled(radius=1.1, track_width=0.8)
    plant = ode_plant(NoSlip(1), 1)
    references = rows_of(table_one(), TICK, 1.0)
    motion = plant.observe(plant.start(replace(planned_start(references), yaw_rate=full(1, 0.3))))
    seen = []

    class Listens:
        def start(self, start):
            return law.law.start(start)

        def update(self, memory, reference, motion, tick):
            seen.append(motion)
            return law.law.update(memory, reference, motion, tick)

    BelievingLaw(Listens(), believed, TRUE).update(
        law.start(planned_start(references)), references.row(0), motion, TICK
    )
    speed, turn = believed.body_rates(motion.wheel_rate)
    np.testing.assert_allclose(seen[0].forward_speed, speed, rtol=1e-12)
    np.testing.assert_allclose(seen[0].yaw_rate, turn, rtol=1e-12)
    assert speed[0] == pytest.approx(1.1 * motion.forward_speed[0])
    assert turn[0] == pytest.approx(1.1 / 0.8 * motion.yaw_rate[0])
    np.testing.assert_array_equal(seen[0].wheel_rate, motion.wheel_rate)


def test_true_beliefs_change_no_bit():
    references = rows_of(table_one(), TICK, 5.0)
    slip = ProportionalSlip(full(1, 0.4), full(1, 0.4), full(1, 0.4))
    plain = track(ode_plant(slip, 1), nominal_law(full(1, -0.5), limits(TRUE)), references, TICK)
    told = track(ode_plant(slip, 1), misled()[0], references, TICK)
    for path in (("motion", "position"), ("motion", "heading_vector"), ("decision", "command", "wheel_rate")):
        assert plain.stack(*path).tobytes() == told.stack(*path).tobytes()


def test_a_wrong_radius_is_a_longitudinal_slip_and_a_yaw_slip_along_with_the_turn():
    """The paper's claim, where it is exact: v_t = (r/r̂ − 1) v̂ and w_s = (r/r̂ − 1) ŵ of the robot that the
    law believes in. The same path comes from the true robot under a wrong belief, and from a believed robot
    that slips so."""
    references = rows_of(table_one(), TICK, 10.0)
    wrong = track(ode_plant(NoSlip(1), 1), misled(radius=0.8)[0], references, TICK)
    gained = 1.0 / 0.8 - 1.0
    believed_speed = wrong.stack("motion", "forward_speed")[1:] * 0.8
    moved = wrong.stack("motion", "velocity")[1:]
    along = np.sqrt(moved[..., 0] ** 2 + moved[..., 1] ** 2)
    np.testing.assert_allclose(along - believed_speed, gained * believed_speed, rtol=1e-9)
    slip = ProportionalSlip(full(1, gained), full(1, 0.0), full(1, 0.0))
    slipping = track(ode_plant(slip, 1), _Turned(misled()[0], 1.0 + gained), references, TICK)
    gap = wrong.stack("motion", "position") - slipping.stack("motion", "position")
    # but for the first tick, at whose start the wheels already turn as planned
    assert np.abs(gap).max() < 1e-3 * np.abs(wrong.position_error).max() + 5e-4
    assert wrong.position_error.max() > 5e-3


class _Turned:
    """A law whose robot yaws by a factor more than it is told."""

    def __init__(self, law, factor):
        self.law, self.factor = law, factor

    def start(self, start):
        return self.law.start(start)

    def update(self, memory, reference, motion, tick):
        decision = self.law.update(memory, reference, motion, tick)
        command = decision.command
        return replace(decision, command=replace(command, yaw_rate=command.yaw_rate * self.factor))


def test_torque_commands_pass_as_they_are():
    from slipctl.tick import Decision, DecisionTrace, TorqueCommand

    zero, pair = np.zeros(1), np.full((1, 2), 0.3)
    told = Decision(
        TorqueCommand(zero, zero, pair, pair), None, DecisionTrace(pair, pair, np.zeros(1, dtype=bool))
    )

    class Pushes:
        def start(self, start):
            return None

        def update(self, memory, reference, motion, tick):
            return told

    references = rows_of(table_one(), TICK, 1.0)
    plant = ode_plant(NoSlip(1), 1)
    motion = plant.observe(plant.start(planned_start(references)))
    law = BelievingLaw(Pushes(), misled(radius=2.0)[1], TRUE)
    assert law.update(None, references.row(0), motion, TICK) is told
