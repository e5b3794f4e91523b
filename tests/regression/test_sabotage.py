"""The gate with the real engine: what must not slip through, and that nothing else trips it."""

import json

import numpy as np
import pytest

from slipctl.cli import main
from slipctl.theory.robot import WheelGeometry

HEAD = """
tick = 0.01
[robot]
model = "magellan_pro"
drive = "wheel_speed"
[[controller]]
kind = "nominal_kinematic"
pole = -1.0
[[controller]]
kind = "robust_kinematic"
pole = -1.0
slip_bound = 0.4
boundary_layer = 0.05
uncertainty = "independent"
"""

PRESCRIBED = (
    HEAD
    + """
[plant]
kind = "kinematic_ode"
[slip]
kind = "proportional"
longitudinal = 0.3
lateral = 0.3
yaw = 0.3
[reference]
kind = "point_to_point"
duration = 4.0
start = { x = 0.0, y = 0.0, heading_deg = 90.0, speed = 0.2 }
goal = { x = 0.4, y = 0.6, heading_deg = 90.0, speed = 0.2 }
"""
)

CONTACTS = (
    "duration = 1.5"
    + HEAD
    + """
[plant]
kind = "mujoco"
[reference]
kind = "circle"
speed = 0.3
radius = 0.6
[start]
x_offset = 0.01
"""
)


@pytest.fixture(scope="module")
def scenarios(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenarios")
    files = {}
    for name, text in (("prescribed", PRESCRIBED), ("contacts", CONTACTS)):
        files[name] = str(folder / f"{name}.toml")
        (folder / f"{name}.toml").write_text(text)
        assert main(["check", files[name], "--update", "--reason", "a test", "--quiet"]) == 0
    return files


def failures(capsys, scenario):
    status = main(["check", scenario, "--json", "--artefacts", "none"])
    answer = json.loads(capsys.readouterr().out)
    named = {
        (entry["scenario"], entry["metric"]) for entry in answer["results"] if entry["verdict"] == "worse"
    }
    return status, named


@pytest.mark.parametrize("name", ["prescribed", "contacts"])
def test_nothing_changed_is_the_same(scenarios, capsys, name):
    assert failures(capsys, scenarios[name]) == (0, set())


def test_a_flipped_sign_of_the_lateral_slip_fails(scenarios, capsys, monkeypatch):
    def flipped(forward_speed, slip, cosine, sine):
        along = forward_speed + slip.longitudinal
        return along * cosine - slip.lateral * sine, along * sine + slip.lateral * cosine

    monkeypatch.setattr("slipctl.plants.ode.slipping_velocity", flipped)
    status, named = failures(capsys, scenarios["prescribed"])
    assert status == 1
    assert ("prescribed", "rms_position_error") in named


def test_the_half_track_taken_for_the_track_fails(scenarios, capsys, monkeypatch):
    def with_the_track(self, forward_speed, yaw_rate):
        sweep = self.half_track / 2 * yaw_rate
        return np.stack([forward_speed - sweep, forward_speed + sweep], axis=-1) / self.wheel_radius

    monkeypatch.setattr(WheelGeometry, "wheel_rates", with_the_track)
    status, named = failures(capsys, scenarios["contacts"])
    assert status == 1
    assert ("contacts", "rms_position_error") in named


@pytest.mark.parametrize("name", ["prescribed", "contacts"])
def test_a_halved_gain_fails(scenarios, capsys, monkeypatch, name):
    from slipctl.experiment.assemble import laws

    whole = laws.chain_gains
    monkeypatch.setattr(laws, "chain_gains", lambda pole, order: whole(pole, order) * np.array([0.5, 1.0]))
    status, named = failures(capsys, scenarios[name])
    assert status == 1
    assert (name, "rms_position_error") in named
