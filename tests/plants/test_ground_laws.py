"""The laws of the ground, as the robot feels them."""

import math

import numpy as np
import pytest

from slipctl.plants.mujoco import MujocoPlant
from slipctl.theory.slip import ProportionalSlip
from tests.plants.driving import MASS, WEIGHT, drive, full, ground, start


@pytest.mark.parametrize("film", [25.0, 100.0, 400.0])
@pytest.mark.parametrize("downhill_deg", [180.0, 90.0])
def test_film_is_the_damper_that_was_asked_for(film: float, downhill_deg: float) -> None:
    """On a slope of 3 degrees the weight's part along the ground is the force, against or across the way."""
    plant = MujocoPlant.build(ground=ground(film=film, slope_deg=3.0, downhill_deg=downhill_deg))
    _, seen = drive(plant, plant.start(start(forward_speed=0.3)), 0.3, 0.0, 3.0)
    slip, motion = seen.slip[-1], seen.motion[-1]
    force = WEIGHT * math.sin(math.radians(3.0))
    # downhill velocity relative to the rolling wheels, in world axes; the robot may have turned a little
    c, s = motion.heading_vector[0]
    along = slip.longitudinal[0] * c + slip.lateral[0] * s
    across = slip.longitudinal[0] * s - slip.lateral[0] * c
    downhill = (-along) if downhill_deg == 180.0 else across
    assert force / (2.0 * downhill) == pytest.approx(film, rel=1e-3)
    assert not seen.contact[-1].sliding.any()


@pytest.mark.parametrize("film", [25.0, 100.0, 400.0])
@pytest.mark.parametrize("yaw_rate", [0.6, -1.0])
def test_film_is_constant_while_turning(film: float, yaw_rate: float) -> None:
    plant = MujocoPlant.build(ground=ground(film=film))
    _, seen = drive(plant, plant.start(start(forward_speed=0.5, yaw_rate=yaw_rate)), 0.5, yaw_rate, 3.0)
    lateral_force = seen.contact[-1].lateral_force.sum()
    slip = seen.slip[-1].lateral[0]
    # the floor pushes towards the centre of the curve, and the robot slips outwards
    assert math.copysign(1.0, slip) == math.copysign(1.0, yaw_rate)
    assert lateral_force / (2.0 * slip) == pytest.approx(film, rel=0.02)


@pytest.mark.parametrize("stiffness", [100.0, 200.0, 500.0, 2000.0])
@pytest.mark.parametrize("speed", [0.5, 1.5])
@pytest.mark.parametrize(
    ("downhill_deg", "slope_deg"),
    # across the way the upper wheel carries less, so it is the first to slide
    [(180.0, 1.0), (180.0, 5.0), (180.0, 8.5), (90.0, 1.0), (90.0, 5.0), (90.0, 7.0)],
)
def test_creep_is_linear_in_the_slip_ratio_up_to_the_limit(
    stiffness: float, speed: float, slope_deg: float, downhill_deg: float
) -> None:
    plant = MujocoPlant.build(
        ground=ground(friction=0.2, creep_stiffness=stiffness, slope_deg=slope_deg, downhill_deg=downhill_deg)
    )
    _, seen = drive(plant, plant.start(start(forward_speed=speed)), speed, 0.0, 1.5)
    slip, motion, contact = seen.slip[-1], seen.motion[-1], seen.contact[-1]
    slip_ratio = math.hypot(slip.longitudinal[0], slip.lateral[0]) / abs(motion.forward_speed[0])
    force = WEIGHT * math.sin(math.radians(slope_deg))
    assert force / (2.0 * slip_ratio) == pytest.approx(stiffness, rel=0.02)
    used = np.hypot(contact.longitudinal_force.sum(), contact.lateral_force.sum()) / (
        0.2 * contact.normal_force.sum()
    )
    assert used == pytest.approx(math.tan(math.radians(slope_deg)) / (0.2 * 0.8), rel=0.06)
    assert used < 1.0


def test_creep_ends_at_the_friction_limit() -> None:
    plant = MujocoPlant.build(
        ground=ground(friction=0.2, creep_stiffness=500.0, slope_deg=12.0, downhill_deg=180.0)
    )
    _, seen = drive(plant, plant.start(start(forward_speed=1.0)), 1.0, 0.0, 1.0)
    contact, slip = seen.contact[-1], seen.slip[-1]
    assert contact.sliding.all()
    assert contact.longitudinal_force == pytest.approx(0.2 * contact.normal_force, rel=1e-3)
    # it slides further than the creep law says, ever faster
    assert -slip.longitudinal[0] > 2.0 * WEIGHT * math.sin(math.radians(12.0)) / (2.0 * 500.0)
    gained = -slip.longitudinal[0] + seen.slip[-21].longitudinal[0]
    pull = WEIGHT * math.sin(math.radians(12.0)) - contact.longitudinal_force.sum()
    assert gained / 0.2 == pytest.approx(pull / MASS, rel=5e-3)


def test_a_robot_stays_put_on_a_slope_below_the_friction_angle_and_slides_above() -> None:
    held = MujocoPlant.build(ground=ground(friction=0.5, slope_deg=15.0, downhill_deg=30.0))
    _, seen = drive(held, held.start(start()), 0.0, 0.0, 1.0)
    # the servos give a little, the tyres do not
    assert abs(seen.slip[-1].longitudinal[0]) < 1e-5
    assert abs(seen.slip[-1].lateral[0]) < 1e-5
    assert not seen.contact[-1].sliding.any()

    sliding = MujocoPlant.build(ground=ground(friction=0.1, slope_deg=15.0, downhill_deg=0.0))
    _, seen = drive(sliding, sliding.start(start()), 0.0, 0.0, 1.0)
    contact = seen.contact[-1]
    pull = WEIGHT * math.sin(math.radians(15.0)) - 0.1 * contact.normal_force.sum()
    gained = seen.motion[-1].velocity - seen.motion[-51].velocity
    assert gained[0, 0] / 0.5 == pytest.approx(pull / MASS, rel=2e-3)
    assert abs(gained[0, 1]) < 1e-6


@pytest.mark.parametrize("yaw_rate", [0.0, 0.5])
@pytest.mark.parametrize("forward_speed", [0.3, -0.3])
def test_moving_floor_gives_the_prescribed_slip(forward_speed: float, yaw_rate: float) -> None:
    law = ProportionalSlip(full(1, 0.4), full(1, 0.3), full(1, 0.2))
    plant = MujocoPlant.build(ground=ground(), slip_law=law)
    state = plant.start(start(heading=2.0, forward_speed=forward_speed, yaw_rate=yaw_rate))
    _, seen = drive(plant, state, forward_speed, yaw_rate, 2.0)
    slip = seen.slip[-1]
    # in a curve the floor lags by half a tick, and MuJoCo adds v·w/b_t
    fuzz = 1e-4 if yaw_rate == 0.0 else 1e-3
    assert slip.longitudinal == pytest.approx(0.4 * forward_speed, abs=fuzz)
    assert slip.lateral == pytest.approx(0.3 * forward_speed, abs=fuzz)
    assert slip.yaw == pytest.approx(0.2 * forward_speed, abs=3e-4)


def test_moving_floor_turns_about_the_robot_wherever_it_is() -> None:
    law = ProportionalSlip(full(2, 0.0), full(2, 0.0), full(2, 1.0))
    plant = MujocoPlant.build(ground=ground(2), slip_law=law)
    begin = start(2, forward_speed=0.3)
    begin.position[1] = [20.0, -10.0]
    _, seen = drive(plant, plant.start(begin), 0.3, 0.0, 1.0)
    assert seen.slip[-1].yaw == pytest.approx([0.3, 0.3], abs=5e-4)
    assert np.abs(seen.slip[-1].longitudinal).max() < 1e-3
    assert np.abs(seen.slip[-1].lateral).max() < 1e-3


def test_left_and_right_friction_are_not_swapped() -> None:
    """Braked hard with a slippery left wheel, the robot turns to the side that grips: right."""
    uneven = ground(2)
    uneven.friction[:] = [[0.05, 0.8], [0.8, 0.05]]
    plant = MujocoPlant.build(ground=uneven)
    _, seen = drive(plant, plant.start(start(2, forward_speed=1.0)), 0.0, 0.0, 0.1)
    contact, motion = seen.contact[-1], seen.motion[-1]
    assert contact.sliding.tolist() == [[True, False], [False, True]]
    assert contact.longitudinal_force[0, 0] == pytest.approx(-0.05 * contact.normal_force[0, 0], rel=1e-6)
    assert contact.longitudinal_force[1, 1] == pytest.approx(-0.05 * contact.normal_force[1, 1], rel=1e-6)
    assert motion.heading_rate[0] < -0.1 < 0.1 < motion.heading_rate[1]
