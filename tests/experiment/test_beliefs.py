"""Scenarios whose controllers are wrong about the robot."""

import numpy as np
import pytest

from slipctl import scenario as files
from slipctl.experiment import run

TRUE = {"wheel_radius": 0.0825, "half_track": 0.1624, "mass": 18.2, "yaw_inertia": 0.39375000000000004}
LENGTHS = {name: TRUE[name] for name in ("wheel_radius", "half_track")}
ENDS = {"heading_deg": 90.0, "speed": 0.15}
QUINTIC = ENDS | {"yaw_rate": 0.0, "acceleration": 0.0}
ROBUST = {"slip_bound": 0.3, "boundary_layer": 0.02, "pole": -0.5}
KINEMATIC = {"kind": "robust_kinematic", "uncertainty": "independent"} | ROBUST
DYNAMIC = {"kind": "robust_dynamic", "uncertainty": "proportional"} | ROBUST


def small(law=KINEMATIC, believes=None, plant="kinematic_ode", **tables) -> files.Scenario:
    """Return two seconds of Table I under one law that believes something."""
    torque = law["kind"].endswith("dynamic")
    ends = QUINTIC if torque else ENDS
    raw = {
        "name": "small",
        "tick": 0.01,
        "duration": 2.0,
        "robot": {"model": "magellan_pro", "drive": "wheel_torque" if torque else "wheel_speed"},
        "plant": {"kind": plant},
        "slip": {"kind": "proportional", "longitudinal": 0.2, "lateral": 0.1, "yaw": 0.1},
        "reference": {
            "kind": "point_to_point",
            "duration": 20.0,
            "start": ends,
            "goal": ends | {"x": 1.2, "y": 1.5},
        },
        "controller": [law | ({"believes": believes} if believes else {})],
    }
    return files.read(raw | tables)


def signals(scenario: files.Scenario) -> dict:
    return run(scenario).signals.to_pydict()


@pytest.mark.parametrize(
    ("law", "believes", "plant"),
    [
        (KINEMATIC, LENGTHS, "kinematic_ode"),
        (KINEMATIC, LENGTHS, "mujoco"),
        (DYNAMIC, TRUE, "dynamic_ode"),
        (DYNAMIC, TRUE, "mujoco"),
    ],
)
def test_believing_the_truth_changes_no_bit(law, believes, plant):
    assert run(small(law, plant=plant)).signals.equals(run(small(law, believes, plant)).signals)


@pytest.mark.parametrize("plant", ["dynamic_ode", "mujoco"])
@pytest.mark.parametrize("name", ["mass", "yaw_inertia", "half_track", "wheel_radius"])
def test_every_wrong_belief_changes_the_torques(name, plant):
    honest, wrong = (
        np.array(signals(small(DYNAMIC, told, plant))["wheel.torque_command.left"])
        for told in (None, {name: 1.2 * TRUE[name]})
    )
    assert np.abs(wrong - honest).max() > 1e-4


def test_a_mass_believed_a_tenth_too_large_asks_for_a_tenth_more_push():
    """In the first tick, where nothing else differs: the sum of the torques is r m μ₁."""
    honest, wrong = (
        signals(small(DYNAMIC, told, "dynamic_ode")) for told in (None, {"mass": 1.1 * TRUE["mass"]})
    )
    pushes = [
        row["wheel.torque_command.left"][1] + row["wheel.torque_command.right"][1] for row in (honest, wrong)
    ]
    push = [row["decision.acceleration"][0] for row in (honest, wrong)]
    assert push[0] == push[1] != 0.0
    assert pushes[1] / pushes[0] == pytest.approx(1.1, rel=1e-9)


@pytest.mark.parametrize("plant", ["kinematic_ode", "mujoco"])
def test_wheels_believed_five_per_cent_too_large_make_the_robot_five_per_cent_slow(plant):
    """From the memory of the same commanded speed; the plant's wheels do what they are told."""
    rows = signals(small({"kind": "nominal_kinematic", "pole": -0.5}, {"wheel_radius": 1.05 * 0.0825}, plant))
    first = rows["decision.forward_speed"][0]
    assert first * 1.05 == pytest.approx(0.15, rel=5e-3)
    rates = np.array(rows["wheel.rate_command.left"]) + np.array(rows["wheel.rate_command.right"])
    np.testing.assert_allclose(0.0825 * rates / 2.0, rows["decision.forward_speed"], rtol=1e-12)


def test_worlds_with_other_beliefs_share_a_batch_and_do_not_mix():
    values = [0.9 * 0.0825, 0.0825, 1.2 * 0.0825]
    swept = run(
        small(sweep={"controller.robust_kinematic.believes.wheel_radius": values})
    ).signals.to_pydict()
    for index, value in enumerate(values):
        alone = signals(small(believes={"wheel_radius": value}))
        mine = np.array(swept["run"]) == index
        np.testing.assert_array_equal(np.array(swept["motion.position.x"])[mine], alone["motion.position.x"])
        assert mine.sum() == len(alone["time"])
    ends = [np.array(swept["motion.position.y"])[np.array(swept["run"]) == index][-1] for index in range(3)]
    assert len(set(ends)) == 3


def test_odometry_reckons_with_what_the_law_believes():
    """Both the speed along the heading and the reckoned way grow with the believed radius."""
    sensing = {"pose": "odometry_camera", "velocity": "odometry", "camera_rate": 1e-3}
    for believes, factor in ((None, 1.0), ({"wheel_radius": 1.1 * 0.0825}, 1.1)):
        rows = signals(small(believes=believes, sensing=sensing))
        speed = np.hypot(rows["sensed.velocity.x"], rows["sensed.velocity.y"])
        np.testing.assert_allclose(speed, factor * np.array(rows["motion.forward_speed"]), rtol=1e-9)
        reckoned = np.hypot(np.diff(rows["sensed.position.x"]), np.diff(rows["sensed.position.y"])).sum()
        turned = (np.array(rows["wheel.angle.left"]) + np.array(rows["wheel.angle.right"]))[-1] / 2.0
        assert reckoned == pytest.approx(factor * 0.0825 * turned, rel=1e-4)
