"""A push changes the momentum by its impulse, wherever its ends fall between the ticks."""

import math

import numpy as np
import pytest

from slipctl.plants.film import LEAST_FRICTION
from slipctl.plants.mujoco import MujocoPlant
from tests.plants.driving import MASS, WEIGHT, drive, ground, start
from tests.plants.floors import push


@pytest.mark.parametrize("direction_deg", [0.0, 40.0, -90.0])
@pytest.mark.parametrize(("begin", "duration"), [(0.1, 0.5), (0.1234, 0.5), (0.0, 0.0007)])
def test_velocity_gained_on_ice_is_impulse_over_mass(
    begin: float, duration: float, direction_deg: float
) -> None:
    """Ice is friction 0, of which MuJoCo keeps 1e-5; what that takes is known, too."""
    plant = MujocoPlant.build(
        ground=ground(friction=0.0), pushes=(push(30.0, direction_deg, begin, duration),)
    )
    _, seen = drive(plant, plant.start(start(heading=0.4)), 0.0, 0.0, 0.8)
    velocity = seen.motion[-1].velocity[0]
    # friction works against the motion from the push on, for the rest of the run
    load = np.mean([contact.normal_force[0].sum() for contact in seen.contact])
    braking = LEAST_FRICTION * load * (0.8 - begin)
    expected = (30.0 * duration - braking) / MASS
    assert math.hypot(*velocity) == pytest.approx(expected, rel=1e-6 if duration > 0.1 else 1e-3)
    assert math.degrees(math.atan2(velocity[1], velocity[0])) == pytest.approx(direction_deg, abs=1e-3)
    assert abs(seen.motion[-1].heading_rate[0]) < 1e-6  # at the centre of mass it does not turn the robot


def test_a_push_below_the_grip_is_held_and_one_above_moves_the_robot() -> None:
    limit = 0.5 * 0.8 * WEIGHT
    for share, moves in ((0.9, False), (1.3, True)):
        plant = MujocoPlant.build(ground=ground(friction=0.5), pushes=(push(share * limit, 90.0, 0.1, 0.5),))
        _, seen = drive(plant, plant.start(start()), 0.0, 0.0, 0.55)
        assert seen.contact[-1].sliding.all() == moves
        speed = seen.motion[-1].velocity[0, 1]
        if moves:
            load = np.mean([contact.normal_force[0].sum() for contact in seen.contact[10:]])
            assert speed == pytest.approx((share * limit - 0.5 * load) * 0.45 / MASS, rel=0.02)
        else:
            assert abs(speed) < 1e-4
            assert seen.contact[-1].lateral_force.sum() == pytest.approx(-share * limit, rel=2e-3)


def test_pushes_add_up_and_differ_from_world_to_world() -> None:
    pushes = (push(10.0, 0.0, 0.0, 0.5, worlds=2), push(6.0, 180.0, 0.2, 0.5, worlds=2))
    pushes[1].force[1] = 10.0
    plant = MujocoPlant.build(ground=ground(2, friction=0.0), pushes=pushes)
    _, seen = drive(plant, plant.start(start(2)), 0.0, 0.0, 0.7)
    expected = np.array([4.0, 0.0]) * 0.5 / MASS
    assert seen.motion[-1].velocity[:, 0] == pytest.approx(expected, abs=1e-4)
    alone = MujocoPlant.build(
        ground=ground(friction=0.0), pushes=(push(10.0, 0.0, 0.0, 0.5), push(10.0, 180.0, 0.2, 0.5))
    )
    _, own = drive(alone, alone.start(start()), 0.0, 0.0, 0.7)
    assert (own.motion[-1].velocity[0] == seen.motion[-1].velocity[1]).all()


def test_a_push_whose_time_has_not_come_changes_nothing() -> None:
    plain = MujocoPlant.build(ground=ground(friction=0.4))
    later = MujocoPlant.build(ground=ground(friction=0.4), pushes=(push(50.0, 0.0, 9.0, 1.0),))
    ends = [drive(p, p.start(start(forward_speed=0.5)), 0.5, 0.8, 0.3)[0] for p in (plain, later)]
    assert (ends[0].rows == ends[1].rows).all()
