"""Patches, changes with time and films in places: what lies under a wheel, and that the wheel feels it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from slipctl.plants.ground import Ground
from slipctl.plants.model import ModelError
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.patches import contact_points
from tests.plants.driving import MASS, WEIGHT, command, drive, full, ground, pushed, start
from tests.plants.floors import change, patch

EVERYWHERE = (100.0, 100.0)


def lies(shape, x: float, y: float) -> bool:
    return bool(shape.covers(np.array([[[x, y], [x, y]]])).all())


@pytest.mark.parametrize(
    ("shape", "inside", "outside"),
    [
        (
            patch("rectangle", (2.0, 0.5), 0.1, x=1.0, y=2.0, heading_deg=90.0),
            [(1.0, 2.9), (1.2, 1.1), (0.8, 2.0)],
            [(1.0, 3.1), (1.3, 2.0), (1.9, 2.0), (2.0, 1.0)],
        ),
        (patch("disc", (0.5, 0.5), 0.1, x=-1.0), [(-1.0, 0.49), (-0.6, 0.2)], [(-1.0, 0.51), (-0.6, 0.4)]),
        (
            patch("stripes", (0.4, 0.1), 0.1, x=0.1, heading_deg=180.0),
            [(0.1, 9.0), (-0.3, -9.0), (0.5, 0.0), (0.14, 0.0), (0.06, 0.0)],
            [(0.3, 0.0), (0.16, 0.0), (0.04, 0.0)],
        ),
        (
            patch("stripes", (0.4, 0.1), 0.1, heading_deg=90.0, count=2),
            [(5.0, 0.0), (5.0, 0.4)],
            [(5.0, -0.4), (5.0, 0.8), (5.0, 0.2)],
        ),
    ],
)
def test_what_a_patch_covers(shape, inside, outside) -> None:
    assert [lies(shape, *point) for point in inside] == [True] * len(inside)
    assert [lies(shape, *point) for point in outside] == [False] * len(outside)


def test_later_patches_lie_on_top_and_changes_are_beside_them() -> None:
    floor = replace(
        ground(friction=0.8),
        patches=(patch("disc", (1.0, 1.0), 0.5), patch("disc", (0.5, 0.5), 0.1, film=30.0)),
        changes=(change(1.0, friction=0.4), change(2.0, film=50.0), change(3.0, friction=0.3, dry=True)),
    )
    points = np.array([[[0.0, 0.0], [0.8, 0.0]]])
    beside = np.array([[[2.0, 0.0], [0.8, 0.0]]])
    for time in (0.0, 2.5, 3.5):
        friction, film = floor.under(points, time)
        assert friction.tolist() == [[0.1, 0.5]]
        assert film[0, 0] == 30.0
        assert np.isnan(film[0, 1])
    seen = [floor.under(beside, time) for time in (0.0, 1.0, 2.0, 3.0)]
    assert [friction[0, 0] for friction, _ in seen] == [0.8, 0.4, 0.4, 0.3]
    assert [film[0, 0] for _, film in seen[2:3]] == [50.0]
    assert np.isnan([film[0, 0] for _, film in (*seen[:2], seen[3])]).all()


@pytest.mark.parametrize("timestep", [0.001, 0.0005])
def test_friction_under_each_wheel_is_that_of_the_floor_at_its_contact_point(timestep: float) -> None:
    """Sliding with locked wheels across the edges of slanting stripes."""
    stripes = patch("stripes", (0.2, 0.1), 0.05, heading_deg=30.0)
    plant = MujocoPlant.build(ground=replace(ground(friction=0.3), patches=(stripes,)), timestep=timestep)
    state = pushed(plant, plant.start(start(heading=0.4)), np.array([[1.2, 0.3]]))
    met = set()
    for _ in range(600):
        motion = plant.observe(state)
        inside = stripes.covers(contact_points(motion.position, motion.heading_vector, plant.half_track))[0]
        friction = np.where(inside, 0.05, 0.3)
        met.add(tuple(inside.tolist()))
        state = plant.step(state, command(full(1, 0.0), full(1, 0.0)), timestep)
        contact = plant.details(state)[1]
        force = np.hypot(contact.longitudinal_force[0], contact.lateral_force[0])
        assert force == pytest.approx(friction * contact.normal_force[0], rel=1e-6)
        assert contact.sliding.all()
    assert len(met) == 4  # both wheels on, both off, and either way one of them


def test_contact_points_are_where_mujoco_has_the_contacts() -> None:
    mujoco: Any = pytest.importorskip("mujoco")
    plant = MujocoPlant.build(ground=ground())
    state, _ = drive(plant, plant.start(start(heading=1.0)), 0.5, 1.0, 0.3)
    motion = plant.observe(state)
    points = contact_points(motion.position, motion.heading_vector, plant.half_track)[0]
    model, data = plant.batch.get_model(0), plant.batch.get_data(0)
    mujoco.mj_forward(model, data)
    for wheel, side in enumerate(("left", "right")):
        geom = model.geom(f"{side}_tyre").id
        found = [c.pos[:2] for c in data.contact[: data.ncon] if geom in (c.geom1, c.geom2)]
        assert found[0] == pytest.approx(points[wheel], abs=2e-6)


def test_one_icy_wheel_turns_a_braking_robot_to_the_side_that_grips() -> None:
    """Left wheel on ice, right on dry floor; the yaw moment is that of the two friction forces."""
    ice = patch("rectangle", (100.0, 1.0), 0.02, y=0.5)
    plant = MujocoPlant.build(ground=replace(ground(friction=0.5), patches=(ice,)))
    _, seen = drive(plant, plant.start(start(forward_speed=1.0)), 0.0, 0.0, 0.05, 0.001)
    for contact in seen.contact[10:]:
        assert contact.longitudinal_force[0, 0] == pytest.approx(-0.02 * contact.normal_force[0, 0], rel=1e-3)
    motion, before = seen.motion[-1], seen.motion[-11]
    forces = np.mean([c.longitudinal_force[0] for c in seen.contact[-10:]], axis=0)
    gained = (motion.heading_rate[0] - before.heading_rate[0]) / 0.01
    assert gained == pytest.approx(plant.half_track * (forces[1] - forces[0]) / 0.39375, rel=0.02)
    assert motion.heading_rate[0] < -0.1


@pytest.mark.parametrize("film", [25.0, 100.0, 400.0])
@pytest.mark.parametrize("yaw_rate", [0.6, -1.0])
def test_film_in_a_patch_is_constant_while_turning(film: float, yaw_rate: float) -> None:
    wet = patch("rectangle", EVERYWHERE, 0.8, film=film)
    plant = MujocoPlant.build(ground=replace(ground(), patches=(wet,)))
    _, seen = drive(plant, plant.start(start(forward_speed=0.5, yaw_rate=yaw_rate)), 0.5, yaw_rate, 2.0)
    force, slip = seen.contact[-1].lateral_force.sum(), seen.slip[-1].lateral[0]
    assert math.copysign(1.0, slip) == math.copysign(1.0, yaw_rate)
    assert force / (2.0 * slip) == pytest.approx(film, rel=2e-3)


@pytest.mark.parametrize("downhill_deg", [180.0, 90.0])
def test_film_in_a_patch_and_film_everywhere_are_the_same_law(downhill_deg: float) -> None:
    slope = ground(slope_deg=3.0, downhill_deg=downhill_deg)
    floors = [
        replace(slope, film=full(1, 100.0)),
        replace(slope, patches=(patch("disc", EVERYWHERE, 0.8, film=100.0),)),
    ]
    slips = []
    for floor in floors:
        plant = MujocoPlant.build(ground=floor)
        _, seen = drive(plant, plant.start(start(forward_speed=0.3)), 0.3, 0.0, 2.0)
        slips.append([seen.slip[-1].longitudinal[0], seen.slip[-1].lateral[0], seen.slip[-1].yaw[0]])
    size = WEIGHT * math.sin(math.radians(3.0)) / 200.0
    assert math.hypot(*slips[1][:2]) == pytest.approx(size, rel=1e-3)
    assert slips[0] == pytest.approx(slips[1], abs=2e-3 * size)


def test_one_wheel_on_a_film_and_one_on_dry_floor_while_turning() -> None:
    """The dry wheel holds, so the film's slip is that of a robot that turns about the dry wheel."""
    wet = patch("rectangle", (100.0, 10.0), 0.8, y=5.0, film=60.0)
    plant = MujocoPlant.build(ground=replace(ground(slope_deg=2.0, downhill_deg=180.0), patches=(wet,)))
    _, seen = drive(plant, plant.start(start(forward_speed=0.3)), 0.3, 0.0, 0.4, 0.001)
    motion, contact = seen.motion[-1], seen.contact[-1]
    before = seen.motion[-2]
    # slip of the contact points along the robot, at the beginning of the last step
    c, s = before.heading_vector[0]
    forward = c * before.velocity[0, 0] + s * before.velocity[0, 1]
    left = forward - plant.half_track * before.heading_rate[0] - plant.wheel_radius * before.wheel_rate[0, 0]
    right = forward + plant.half_track * before.heading_rate[0] - plant.wheel_radius * before.wheel_rate[0, 1]
    assert contact.longitudinal_force[0, 0] == pytest.approx(-60.0 * left, rel=5e-3)
    assert abs(left) > 0.01
    assert abs(right) < 1e-4
    assert motion.heading_rate[0] > 0.05  # the left side slides back downhill: it turns left


def test_film_in_a_patch_ends_at_the_friction_limit() -> None:
    wet = patch("rectangle", EVERYWHERE, 0.2, film=300.0)
    plant = MujocoPlant.build(ground=replace(ground(), patches=(wet,)))
    state = pushed(plant, plant.start(start()), np.array([[0.0, 2.0]]))
    _, seen = drive(plant, state, 0.0, 0.0, 0.8, 0.001)
    velocity = np.array([motion.velocity[0, 1] for motion in seen.motion])
    loads = [contact.normal_force[0].sum() for contact in seen.contact]
    assert seen.contact[-1].sliding.all()
    assert -seen.contact[-1].lateral_force.sum() == pytest.approx(0.2 * loads[-1], rel=1e-3)
    lost = (velocity[399] - velocity[-1]) / (400 * 0.001)
    assert lost == pytest.approx(0.2 * np.mean(loads[400:]) / MASS, rel=1e-3)


def test_a_film_that_would_swing_is_refused() -> None:
    wet = patch("disc", (1.0, 1.0), 0.8, film=1000.0)
    with pytest.raises(ModelError, match="too viscous for a physics step"):
        MujocoPlant.build(ground=replace(ground(), patches=(wet,)))


def test_friction_and_film_change_with_time() -> None:
    floor = replace(
        ground(friction=0.6, slope_deg=3.0, downhill_deg=180.0),
        changes=(
            change(0.5, film=100.0),
            change(1.5, film=200.0),
            change(2.5, dry=True),
            change(3.0, friction=0.02),
        ),
    )
    plant = MujocoPlant.build(ground=floor)
    _, seen = drive(plant, plant.start(start(forward_speed=0.3)), 0.3, 0.0, 3.6)
    slip = -np.array([slip.longitudinal[0] for slip in seen.slip])
    pull = WEIGHT * math.sin(math.radians(3.0))
    assert abs(slip[48]) < 1e-4
    assert slip[148] == pytest.approx(pull / 200.0, rel=2e-3)
    assert slip[248] == pytest.approx(pull / 400.0, rel=2e-3)
    assert abs(slip[298]) < 1e-4
    # too slippery for the slope from 3.0 s on
    assert not seen.contact[298].sliding.any()
    assert seen.contact[-1].sliding.all()
    held = 0.02 * np.mean([contact.normal_force.sum() for contact in seen.contact[-20:]])
    assert (slip[-1] - slip[-21]) / 0.2 == pytest.approx((pull - held) / MASS, rel=5e-3)


def test_worlds_do_not_depend_on_their_company() -> None:
    """Patches, films in places, changes: a batch is its rows, bit for bit, and a step is pure."""
    shared = {
        "patches": (
            patch("stripes", (0.3, 0.1), 0.1, worlds=3),
            patch("disc", (0.3, 0.3), 0.5, x=0.3, film=50.0, worlds=3),
        ),
        "changes": (change(0.2, friction=0.3, worlds=3),),
    }
    floor = Ground.flat(np.array([0.8, 0.5, 0.2]))
    everything = replace(floor, **shared)
    everything.patches[0].friction[:] = [0.1, 0.2, 0.3]
    begin = start(3, heading=0.3, forward_speed=0.4, yaw_rate=0.5)
    plant = MujocoPlant.build(ground=everything, threads=2)
    state, _ = drive(plant, plant.start(begin), 0.4, 0.5, 0.4)
    again, _ = drive(plant, plant.start(begin), 0.4, 0.5, 0.4)
    assert (state.rows == again.rows).all()
    assert (state.sensors == again.sensors).all()
    for row in range(3):
        alone = Ground(
            friction=floor.friction[[row]],
            film=floor.film[[row]],
            creep_stiffness=floor.creep_stiffness[[row]],
            slope=floor.slope[[row]],
            downhill=floor.downhill[[row]],
            patches=tuple(
                replace(
                    part,
                    **{
                        name: getattr(part, name)[[row]]
                        for name in ("place", "direction", "size", "count", "friction", "film")
                    },
                )
                for part in everything.patches
            ),
            changes=(change(0.2, friction=0.3),),
        )
        single = MujocoPlant.build(ground=alone)
        own, _ = drive(
            single, single.start(start(heading=0.3, forward_speed=0.4, yaw_rate=0.5)), 0.4, 0.5, 0.4
        )
        assert (own.rows[0] == state.rows[row]).all()
        assert (own.sensors[0] == state.sensors[row]).all()
        assert (own.friction[0] == state.friction[row]).all()


def test_a_patch_of_the_floor_s_own_friction_changes_nothing() -> None:
    plain = MujocoPlant.build(ground=ground(friction=0.3))
    same = MujocoPlant.build(ground=replace(ground(friction=0.3), patches=(patch("disc", (0.2, 0.2), 0.3),)))
    ends = [drive(p, p.start(start(forward_speed=0.5)), 0.5, 0.8, 0.5)[0] for p in (plain, same)]
    assert (ends[0].rows == ends[1].rows).all()
    assert (ends[0].sensors == ends[1].sensors).all()
