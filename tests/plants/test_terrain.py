"""Uneven floor: the geometry, and that the robot rides it as the geometry says."""

import math
from dataclasses import replace

import numpy as np
import pytest

from slipctl.plants.ground import Ground
from slipctl.plants.model import ModelError, load_spec
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.relief import give_planes
from slipctl.plants.terrain import Terrain, levelled, sine, upright_to
from slipctl.shipped import model_path
from slipctl.theory.slip import measure_slip
from tests.plants.driving import WEIGHT, drive, full, ground, start

CASTER_ARM, CASTER_STIFFNESS, TYRE_STIFFNESS = 0.168, 4000.0, 1e5


def waves(amplitude: float, wavelength: float, heading_deg: float = 0.0) -> Terrain:
    return Terrain.waves(full(1, amplitude), full(1, wavelength), np.radians(full(1, heading_deg)))


def pitch(quaternion) -> float:
    w, x, y, z = quaternion
    return math.asin(2.0 * (w * y - x * z))


def test_sine_is_the_sine() -> None:
    turns = np.linspace(-3.0, 3.0, 4001)
    assert sine(turns) == pytest.approx(np.sin(2.0 * np.pi * turns), abs=1e-13)


@pytest.mark.parametrize("terrain", [waves(0.02, 1.5, 30.0), Terrain.bumps(full(1, 0.02), full(1, 1.5), [4])])
def test_gradient_and_curvature_are_those_of_the_height(terrain: Terrain) -> None:
    points = np.random.default_rng(1).uniform(-3.0, 3.0, (1, 400, 2))
    height, gradient = terrain.relief(points)
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = 1e-5
        ahead, behind = terrain.relief(points + step)[0], terrain.relief(points - step)[0]
        assert gradient[..., axis] == pytest.approx((ahead - behind) / 2e-5, abs=1e-8)
        assert (np.abs(ahead - 2.0 * height + behind) / 1e-10).max() <= 1.02 * terrain.curvature[0]
    assert np.abs(height).max() <= 0.02
    assert np.abs(height).max() > 0.008


def test_waves_rise_from_the_origin_along_their_heading() -> None:
    height, _ = waves(0.02, 2.0, 90.0).relief(np.array([[[0.0, 0.0], [7.0, 0.5], [0.0, 1.5], [1.0, 1.0]]]))
    assert height[0] == pytest.approx([0.0, 0.02, -0.02, 0.0], abs=1e-15)


def test_bumps_have_their_stated_spread_and_their_seed() -> None:
    terrain = Terrain.bumps(full(2, 0.01), full(2, 0.7), [1, 2])
    points = np.random.default_rng(2).uniform(-20.0, 20.0, (1, 20000, 2))
    height, _ = terrain.relief(np.concatenate([points, points]))
    assert np.sqrt((height**2).mean(axis=1)) == pytest.approx([0.01 * 0.267] * 2, rel=0.03)
    assert np.abs(height[0] - height[1]).max() > 0.003
    again = Terrain.bumps(full(1, 0.01), full(1, 0.7), [2])
    assert (again.phase[0] == terrain.phase[1]).all()


def test_nearest_points_are_the_nearest() -> None:
    terrain = waves(0.02, 1.0, 20.0)
    centres = np.random.default_rng(3).uniform(-1.0, 1.0, (1, 50, 3))
    centres[..., 2] = terrain.relief(centres[..., :2])[0] + 0.085
    point, normal = terrain.nearest(centres)
    apart = centres - point
    assert np.abs(np.cross(apart, normal)).max() < 2e-6
    around = point[..., None, :2] + np.random.default_rng(4).uniform(-0.05, 0.05, (1, 50, 300, 2))
    height = terrain.relief(around.reshape(1, -1, 2))[0].reshape(1, 50, 300, 1)
    others = np.concatenate([around, height], axis=-1) - centres[:, :, None, :]
    assert (np.sqrt((others**2).sum(axis=-1)).min(axis=-1) > np.sqrt((apart**2).sum(axis=-1)) - 1e-9).all()


def test_levelling_turns_the_normal_upright_and_keeps_lengths() -> None:
    normal = np.array([[0.1, -0.2, 0.0]])
    normal[0, 2] = math.sqrt(1.0 - (normal[0, :2] ** 2).sum())
    assert levelled(3.0 * normal, normal) == pytest.approx(np.array([[0.0, 0.0, 3.0]]))
    force = np.array([[3.0, -2.0, 50.0]])
    turned = levelled(force, normal)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(force))
    assert turned[0, 2] == pytest.approx(float((force * normal).sum()))
    w, x, y, z = upright_to(normal)[0]
    assert [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)] == pytest.approx(normal[0])


def test_a_terrain_of_no_height_is_the_level_floor_to_the_bit() -> None:
    flat = Terrain(np.zeros((1, 1)), np.ones((1, 1, 2)), np.zeros((1, 1)))
    plants = [
        MujocoPlant.build(ground=floor)
        for floor in (ground(friction=0.4), replace(ground(friction=0.4), terrain=flat))
    ]
    ends = [drive(p, p.start(start(heading=0.5, forward_speed=0.5)), 0.5, 0.8, 0.5)[0] for p in plants]
    motions = [plant.observe(end) for plant, end in zip(plants, ends, strict=True)]
    assert (motions[0].position == motions[1].position).all()
    assert (ends[0].sensors == ends[1].sensors).all()


def test_parked_where_waves_are_straight_is_parked_on_that_slope() -> None:
    angle, wavelength = 5.0, 20.0
    height = math.tan(math.radians(angle)) * wavelength / (2.0 * math.pi)
    plants = [
        MujocoPlant.build(ground=ground(slope_deg=angle, downhill_deg=180.0)),
        MujocoPlant.build(ground=replace(ground(), terrain=waves(height, wavelength))),
    ]
    seen = []
    for plant in plants:
        state, _ = drive(plant, plant.start(start()), 0.0, 0.0, 1.0)
        pose, contact = plant.details(state)
        seen.append((math.degrees(pitch(pose.quaternion[0])), contact))
    (tilted, on_slope), (pitched, on_waves) = seen
    assert pitched == pytest.approx(tilted - angle, abs=5e-3)
    assert on_waves.normal_force == pytest.approx(on_slope.normal_force, rel=1e-4)
    assert on_waves.longitudinal_force == pytest.approx(on_slope.longitudinal_force, rel=1e-3)
    assert not on_waves.sliding.any()


def test_wheel_load_pitch_and_slip_over_waves_are_those_of_the_geometry() -> None:
    """Slowly over 5 mm in 2 m: the casters take up what the chord differs from the floor under the axle."""
    amplitude, wavelength, speed = 0.005, 2.0, 0.1
    plant = MujocoPlant.build(ground=replace(ground(), terrain=waves(amplitude, wavelength)))
    state = plant.start(start(forward_speed=speed))
    load, lean, turning, slip, at = [], [], [], [], []
    for _ in range(8):  # 1.5 s each; the first is left out
        before, _ = drive(plant, state, speed, 0.0, 1.49)
        state, _ = drive(plant, before, speed, 0.0, 0.01)
        pose, contact = plant.details(state)
        assert not contact.sliding.any()
        load.append(contact.normal_force[0].sum())
        lean.append(pitch(pose.quaternion[0]))
        turning.append((lean[-1] - pitch(plant.details(before)[0].quaternion[0])) / 0.01)
        slip.append(measure_slip(plant.observe(state)).longitudinal[0])
        at.append(plant.observe(state).position[0, 0])
    x = np.array(at[1:])

    def height(x):
        return amplitude * np.sin(2.0 * np.pi * x / wavelength)

    slope = (height(x + 1e-4) - height(x - 1e-4)) / 2e-4
    chord = (height(x + CASTER_ARM) - height(x - CASTER_ARM)) / (2.0 * CASTER_ARM)
    lifted = (height(x + CASTER_ARM) + height(x - CASTER_ARM)) / 2.0 - height(x)
    expected = 0.8 * WEIGHT - 2.0 * CASTER_STIFFNESS * lifted
    assert np.ptp(expected) > 5.0
    assert np.array(load[1:]) == pytest.approx(expected, abs=0.3)
    # the weight, 0.10 m above the floor, leans the body further on its soft casters
    stiffness = 2.0 * CASTER_STIFFNESS * CASTER_ARM**2 - WEIGHT * (0.10 - plant.wheel_radius)
    assert -np.array(lean[1:]) == pytest.approx(chord + WEIGHT * 0.10 * slope / stiffness, abs=1e-4)
    # nothing slides, and yet wheels that turn relative to a pitching body read as slip, radius times pitch
    # rate; besides, a loaded wheel rolls on a smaller radius, and a slope is longer than its projection
    softer = (0.8 * WEIGHT - np.array(load[1:])) / 2.0 / TYRE_STIFFNESS / 2.0
    apparent = plant.wheel_radius * np.array(turning[1:]) - speed * slope**2 / 2.0
    apparent += speed / plant.wheel_radius * softer
    assert np.ptp(apparent) > 5e-4
    assert np.array(slip[1:]) == pytest.approx(apparent, abs=2e-6)


def test_worlds_on_bumps_do_not_depend_on_their_company() -> None:
    bumps = Terrain.bumps(np.array([0.004, 0.006, 0.008]), np.array([0.5, 0.6, 0.7]), [1, 2, 3])
    floor = replace(Ground.flat(np.array([0.8, 0.5, 0.3])), terrain=bumps)
    plant = MujocoPlant.build(ground=floor, threads=2)
    begin = start(3, heading=0.3, forward_speed=0.4, yaw_rate=0.5)
    state, _ = drive(plant, plant.start(begin), 0.4, 0.5, 0.3)
    again, _ = drive(plant, plant.start(begin), 0.4, 0.5, 0.3)
    assert (state.rows == again.rows).all()
    for row in range(3):
        own = Terrain(bumps.amplitude[[row]], bumps.wave_vector[[row]], bumps.phase[[row]])
        single = MujocoPlant.build(ground=replace(Ground.flat(floor.friction[[row]]), terrain=own))
        alone, _ = drive(
            single, single.start(start(heading=0.3, forward_speed=0.4, yaw_rate=0.5)), 0.4, 0.5, 0.3
        )
        assert (alone.rows[0] == state.rows[row]).all()
        assert (alone.sensors[0] == state.sensors[row]).all()


def test_floors_that_a_wheel_cannot_follow_are_refused() -> None:
    with pytest.raises(ModelError, match="too sharply for a wheel"):
        MujocoPlant.build(ground=replace(ground(), terrain=waves(0.05, 0.5)))


def test_models_without_spheres_on_the_floor_are_refused() -> None:
    spec = load_spec(model_path("magellan_pro"))
    spec.geom("front_caster").type = spec.geom("nose").type
    spec.geom("front_caster").size = [0.02, 0.02, 0.02]
    with pytest.raises(ModelError, match="'front_caster' is none"):
        give_planes(spec)
