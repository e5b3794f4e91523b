import math

import numpy as np
import pytest

from slipctl.plants.ground import LEAST_CREEP_SPEED, Ground, floor_motion, gravity, grip, viscosity
from slipctl.plants.model import compile_model, find_model
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.standstill import Tyre, settle
from slipctl.tick import Array, Slip
from tests.plants.driving import full, ground


@pytest.fixture(scope="module")
def tyre() -> Tyre:
    return settle(compile_model(find_model("magellan_pro"))).tyre


def damper(tyre: Tyre, impratio: Array, rate: Array) -> Array:
    """C of MuJoCo's friction in stick, from its definitions of R and of the reference acceleration."""
    return rate * impratio[:, None] / tyre.softness


def test_flat_ground_of_one_friction_or_of_many() -> None:
    assert Ground.flat(0.3, 2).friction.tolist() == [[0.3, 0.3]] * 2
    assert Ground.flat(np.array([0.3, 0.5])).friction.tolist() == [[0.3, 0.3], [0.5, 0.5]]
    assert Ground.flat(np.array([[0.3, 0.5]])).friction.tolist() == [[0.3, 0.5]]
    assert np.isnan(Ground.flat(0.3, 2).film).all()
    assert len(Ground.flat(np.array([0.3, 0.5])).slope) == 2


def test_gravity_keeps_its_size_and_points_downhill() -> None:
    tilted = Ground(
        friction=np.full((3, 2), 0.8),
        film=full(3, np.nan),
        creep_stiffness=full(3, np.nan),
        slope=np.radians([0.0, 10.0, 20.0]),
        downhill=np.radians([40.0, 90.0, 180.0]),
    )
    g = gravity(tilted)
    assert np.sqrt((g * g).sum(axis=1)) == pytest.approx([9.81] * 3)
    assert g[0].tolist() == [0.0, 0.0, -9.81]
    assert g[1] == pytest.approx(
        [0.0, 9.81 * math.sin(math.radians(10.0)), -9.81 * math.cos(math.radians(10.0))]
    )
    assert g[2, 0] == pytest.approx(-9.81 * math.sin(math.radians(20.0)))


def test_plain_grip_is_what_the_model_file_says_to_the_bit(tyre: Tyre) -> None:
    model = compile_model(find_model("magellan_pro"))
    contact = grip(tyre, np.full((2, 2), np.nan))
    assert contact.impratio.tolist() == [model.opt.impratio] * 2
    left = model.pair("left_tyre").id
    assert (contact.solreffriction(tyre) == model.pair_solreffriction[left]).all()


def test_film_and_creep_become_the_damper_that_was_asked_for(tyre: Tyre) -> None:
    wanted = np.array([[100.0, 100.0], [400.0, 25.0], [5000.0, 4000.0]])
    contact = grip(tyre, wanted)
    assert damper(tyre, contact.impratio, contact.rate) == pytest.approx(wanted, rel=1e-12)
    # b_t is never below the model's at the stiffer wheel, and never so high that a sliding wheel hops
    assert (contact.rate.max(axis=1) >= tyre.rate * (1.0 - 1e-12)).all()
    assert (contact.rate <= 3.0 * tyre.rate * (1.0 + 1e-12)).all()
    assert contact.rate[0] == pytest.approx([tyre.rate] * 2, rel=0.02)


def test_worlds_of_film_creep_and_grip_mix(tyre: Tyre) -> None:
    mixed = Ground(
        friction=np.full((3, 2), 0.8),
        film=np.array([100.0, np.nan, np.nan]),
        creep_stiffness=np.array([np.nan, 200.0, np.nan]),
        slope=np.zeros(3),
        downhill=np.zeros(3),
    )
    c = viscosity(mixed, np.array([[0.5, -2.0], [0.5, -2.0], [0.5, -2.0]]))
    assert c[0].tolist() == [100.0, 100.0]
    assert c[1].tolist() == [400.0, 100.0]
    assert np.isnan(c[2]).all()
    assert grip(tyre, c).impratio[2] == tyre.impratio


def test_creep_stays_finite_at_standstill() -> None:
    assert viscosity(ground(creep_stiffness=200.0), np.zeros((1, 2))).tolist() == [
        [200.0 / LEAST_CREEP_SPEED] * 2
    ]


def test_floor_moves_the_robot_as_the_slip_says() -> None:
    heading, where = 0.7, np.array([[3.0, -2.0]])
    c, s = math.cos(heading), math.sin(heading)
    slip = Slip(np.array([0.3]), np.array([0.2]), np.array([0.5]))
    v, w = np.split(floor_motion(slip, where, np.array([[c, s]]))[0], 2)

    def surface(at: Array) -> Array:
        return (v + np.cross(w, [*at, 0.0]))[:2]

    at_robot = surface(where[0])
    assert at_robot[0] * c + at_robot[1] * s == pytest.approx(0.3)
    assert at_robot[0] * s - at_robot[1] * c == pytest.approx(0.2)
    # one metre to the left of the robot a counter-clockwise surface moves backwards relative to it
    left = surface(where[0] + [-s, c]) - at_robot
    assert left == pytest.approx([-0.5 * c, -0.5 * s])
    assert (v[2], w[0], w[1]) == (0.0, 0.0, 0.0)


def test_every_world_gets_its_own_ground() -> None:
    uneven = Ground(
        friction=np.array([[0.1, 0.2], [0.3, 0.4]]),
        film=np.array([100.0, np.nan]),
        creep_stiffness=full(2, np.nan),
        slope=np.array([0.0, 0.1]),
        downhill=np.zeros(2),
    )
    plant = MujocoPlant.build(ground=uneven)
    first, second = plant.batch.get_model(0), plant.batch.get_model(1)
    assert (first.pair_friction[first.pair("left_tyre").id, :2] == 0.1).all()
    assert (first.pair_friction[first.pair("right_tyre").id, :2] == 0.2).all()
    assert (second.pair_friction[second.pair("right_tyre").id, :2] == 0.4).all()
    assert second.opt.impratio == 1e6
    assert first.opt.impratio < 100.0
    assert first.opt.gravity.tolist() == [0.0, 0.0, -9.81]
    assert second.opt.gravity[0] == pytest.approx(9.81 * math.sin(0.1))
    # casters stay without friction dimensions and as stiff as they were
    caster = first.pair("front_caster").id
    assert (first.pair_solreffriction[caster] == 0.0).all()
