"""The dynamic laws on MuJoCo with torque motors: slipping belts, a gripping floor, limits."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from slipctl.control.torque import TorqueDrive
from slipctl.plants.ground import Ground
from slipctl.plants.mujoco import MujocoPlant
from slipctl.plants.standstill import inertia
from slipctl.simulate import Controller
from slipctl.theory.dynamic import Inertia
from slipctl.tick import Array
from tests.builders import PAPER_POLE, Track, full, paper_slip, rows_of, track
from tests.dynamic import (
    BOUNDS,
    DYNAMIC_LAYER,
    DYNAMIC_SLIP,
    PAPER_BODY,
    dynamic_plant,
    nominal_dynamic,
    quintic_table_one,
    robust_dynamic,
)

TICK = 0.005
LAWS = ("nominal", "proportional")


def law(name: str, body: Inertia, torque_limit: float = 4.0) -> Controller:
    drive = TorqueDrive(body, full(1, torque_limit), full(1, 0.05))
    pole = full(1, PAPER_POLE)
    if name == "nominal":
        return nominal_dynamic(pole, drive)
    return robust_dynamic(pole, full(1, DYNAMIC_LAYER), BOUNDS[name](full(1, DYNAMIC_SLIP)), drive)


@functools.cache
def run(name: str, belts: bool, compensated: bool = True, torque_limit: float = 4.0) -> Track:
    """Run Table I at 200 Hz, as the scenario of the belts has it."""
    slip = paper_slip(1, DYNAMIC_SLIP) if belts else None
    plant = MujocoPlant.build(
        ground=Ground.flat(0.8), slip_law=slip, speed_drive=False, torque_limit=torque_limit
    )
    body = inertia(plant.batch.model, plant._wheels) if compensated else PAPER_BODY
    references = rows_of(quintic_table_one(), TICK, 20.0)
    return track(plant, law(name, body, torque_limit), references, TICK)


def rms(error: Array) -> float:
    return float(np.sqrt(np.mean(error**2)))


def test_robust_law_on_belts_beats_the_nominal_one():
    """Ten times after the start, sixty at the end; 2.4 times over the whole, most of which is the start.

    Slip acts from the first instant, so both begin 70 mm/s off, and the poles at −0.5 take their time.
    """
    nominal, robust = (1e3 * run(name, belts=True).position_error[:, 0] for name in LAWS)
    assert rms(nominal) > 2.3 * rms(robust)
    assert rms(nominal[1000:]) > 8.0 * rms(robust[1000:])
    assert nominal[-1] > 40.0 * robust[-1]
    assert rms(robust) == pytest.approx(22.7, rel=0.01)
    assert rms(robust[2000:]) < 0.3


@pytest.mark.parametrize("name", LAWS)
def test_belts_do_to_the_robot_what_the_model_says(name):
    """MuJoCo, wheels on a moving floor, against (31): errors within 2 %, 2 mm along the path."""
    model = track(
        dynamic_plant(paper_slip(1, DYNAMIC_SLIP), 1),
        law(name, PAPER_BODY),
        rows_of(quintic_table_one(), TICK, 20.0),
        TICK,
    )
    got = run(name, belts=True)
    assert rms(got.position_error) == pytest.approx(rms(model.position_error), rel=0.02)
    assert got.position_error.max() == pytest.approx(model.position_error.max(), rel=0.02)
    gap = got.stack("motion", "position") - model.stack("motion", "position")
    assert np.hypot(gap[..., 0], gap[..., 1]).max() < 2e-3
    speed = got.stack("motion", "forward_speed")[5:]
    for name in ("longitudinal", "lateral"):
        np.testing.assert_allclose(got.stack("slip", name)[5:] / speed, DYNAMIC_SLIP, rtol=0, atol=3e-3)


@pytest.mark.parametrize("name", LAWS)
def test_gripping_floor_is_tracked_to_a_fraction_of_a_millimetre_with_compensation(name):
    error = 1e3 * run(name, belts=False).position_error
    assert error.max() < (0.25 if name == "nominal" else 0.06)


def test_without_compensation_the_nominal_law_pays_for_the_wheels():
    """12 % of the mass is then a disturbance: 6 mm, 30 times as much; robust stays below 1 mm."""
    nominal, robust = (1e3 * run(name, belts=False, compensated=False).position_error.max() for name in LAWS)
    assert nominal == pytest.approx(6.1, rel=0.03)
    assert nominal > 25.0 * 1e3 * run("nominal", belts=False).position_error.max()
    assert 1e3 * run("proportional", belts=False).position_error.max() < robust < 1.0


def test_torque_in_the_recording_is_the_one_commanded():
    got = run("proportional", belts=True)
    command = got.stack("decision", "command")
    told = np.array([(one.wheel_torque_start + one.wheel_torque_end) / 2.0 for one in command])[:-1, 0]
    contacts = [row.details[1].torque[0] for row in got.rows[1:] if row.details is not None]
    np.testing.assert_allclose(contacts, told, rtol=0, atol=1e-12)
    assert np.abs(told).max() < 0.1


@pytest.mark.parametrize("name", LAWS)
def test_robot_with_weak_motors_stays_within_their_torque_and_comes_back(name):
    """0.03 N·m where 0.04 (robust 0.08) is wanted: farther off on the way, no wind-up, as near in the end."""
    weak, strong = run(name, belts=True, torque_limit=0.03), run(name, belts=True)
    saturated = weak.stack("decision", "trace", "saturated")[:, 0]
    assert 0.1 < saturated.mean() < 0.5
    assert not saturated[-500:].any()
    torque = np.array([one.wheel_torque_end for one in weak.stack("decision", "command")])
    assert np.abs(torque).max() <= 0.03 * (1.0 + 1e-12)
    assert weak.position_error.max() > 1.1 * strong.position_error.max()
    assert weak.position_error[-1, 0] < 1.2 * strong.position_error[-1, 0]


def test_observed_acceleration_follows_the_plan_on_a_gripping_floor():
    """It is that of the last physics step, and not noisy."""
    got = run("proportional", belts=False)
    gap = got.stack("motion", "acceleration") - got.stack("reference", "acceleration")
    assert np.abs(gap[5:]).max() < 5e-4
    assert np.abs(got.stack("reference", "acceleration")).max() > 0.02
