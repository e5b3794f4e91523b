"""Locked wheels sliding on Coulomb friction: the trap in which a badly modelled contact hops."""

import math

import numpy as np
import pytest

from slipctl.plants.mujoco import MujocoPlant
from tests.plants.driving import MASS, WEIGHT, drive, ground, pushed, start

TICK = 0.001


@pytest.mark.parametrize("direction_deg", [0.0, 90.0, 45.0])
@pytest.mark.parametrize(("friction", "film"), [(0.2, math.nan), (0.7, math.nan), (0.2, 300.0)])
def test_deceleration_is_friction_times_wheel_load(
    friction: float, film: float, direction_deg: float
) -> None:
    heading, direction = 0.3, 0.3 + math.radians(direction_deg)
    plant = MujocoPlant.build(ground=ground(friction=friction, film=film))
    # with the rear caster in the air, above 3.3 m/s², pitching takes longer to die down
    speed = 3.0 if (friction, direction_deg) == (0.7, 0.0) else 2.0
    towards = np.array([math.cos(direction), math.sin(direction)])
    state = pushed(plant, plant.start(start(heading=heading)), speed * towards)
    # what is left on a film at the end must still be faster than the film yields
    duration = 0.75 * speed / (friction * 0.8 * 9.81)
    _, seen = drive(plant, state, 0.0, 0.0, duration, TICK)

    load = np.array([c.normal_force[0] for c in seen.contact])
    force = np.array([[c.longitudinal_force[0], c.lateral_force[0]] for c in seen.contact])
    assert load.min() > 0.2 * 0.4 * WEIGHT  # no step in the air
    assert all(c.sliding.all() for c in seen.contact)
    assert np.sqrt((force**2).sum(axis=1)) == pytest.approx(friction * load, rel=1e-6)

    # pitching and rolling have died down in the last third
    settled = 2 * len(load) // 3
    total = load.sum(axis=1)
    velocity = np.array([m.velocity[0] for m in seen.motion])
    lost = (velocity[settled] - velocity[-1]) / ((len(load) - 1 - settled) * TICK)
    if direction_deg == 45.0:
        # the wheels carry different loads, so the robot turns: their friction is not along one line
        heading_vector = np.array([m.heading_vector[0] for m in seen.motion])
        along, left = force.sum(axis=2)[settled + 1 :].T
        c, s = heading_vector[settled + 1 :].T
        pull = -np.array([(c * along - s * left).mean(), (s * along + c * left).mean()])
        assert lost == pytest.approx(pull / MASS, rel=2e-3)
    else:
        assert total[settled:].std() / total[settled:].mean() < 1e-3
        assert lost @ towards == pytest.approx(friction * total[settled + 1 :].mean() / MASS, rel=1e-3)


@pytest.mark.parametrize("direction_deg", [0.0, 20.0, 45.0, 70.0, 90.0, 135.0])
def test_friction_opposes_the_slide_in_every_direction(direction_deg: float) -> None:
    """The elliptic cone; a pyramid would be a third too strong at 45 degrees."""
    direction = math.radians(direction_deg)
    plant = MujocoPlant.build(ground=ground(friction=0.1))
    state = pushed(plant, plant.start(start()), 2.0 * np.array([[math.cos(direction), math.sin(direction)]]))
    _, seen = drive(plant, state, 0.0, 0.0, 0.2, TICK)
    contact, motion = seen.contact[-1], seen.motion[-1]
    c, s = motion.heading_vector[0]
    vx, vy = motion.velocity[0]
    along, left = c * vx + s * vy, c * vy - s * vx
    for wheel, offset in enumerate((plant.half_track, -plant.half_track)):
        # the wheel's own way over the floor: it is locked but for the servo's give, on a turning body
        at_wheel = np.array(
            [along - motion.heading_rate[0] * offset - motion.wheel_rate[0, wheel] * plant.wheel_radius, left]
        )
        force = np.array([contact.longitudinal_force[0, wheel], contact.lateral_force[0, wheel]])
        limit = 0.1 * contact.normal_force[0, wheel]
        assert force == pytest.approx(-limit * at_wheel / np.hypot(*at_wheel), abs=2e-3 * limit)


def test_lateral_creep_in_grip_is_microscopic() -> None:
    """At 0.9 of the break-away threshold; a stock contact creeps at 2.8 mm/s."""
    share = math.degrees(math.atan(0.9 * 0.5 * 0.8))
    plant = MujocoPlant.build(ground=ground(friction=0.5, slope_deg=share * 0.8, downhill_deg=90.0))
    _, seen = drive(plant, plant.start(start()), 0.0, 0.0, 1.0)
    assert not seen.contact[-1].sliding.any()
    assert abs(seen.slip[-1].lateral[0]) < 5e-6
