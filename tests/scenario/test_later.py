"""What the format names but this release lacks is refused by name."""

from pathlib import Path

import pytest

from slipctl.scenario import ScenarioError, load
from slipctl.scenario.later import LATER_VALUES
from tests.scenario.documents import EIGHT, PAPER, changed, refused

SHARED = Path(__file__).resolve().parents[3] / "shared" / "scenarios"


def later(document):
    return {problem.key: problem for problem in refused(document) if problem.later}


@pytest.mark.parametrize(
    ("key", "value"), [(key, value) for key, values in LATER_VALUES.items() for value in values]
)
def test_kinds_and_sources_that_come_later(key, value):
    key = key.replace("controller.", "controller.1.")
    problems = later(changed(PAPER, {key: value}))
    assert len(problems) == 1
    text = str(*problems.values())
    assert f'found "{value}", which comes with a later release of slipctl; available now: ' in text


@pytest.mark.parametrize(
    ("document", "key", "value"),
    [
        (PAPER, "disturbance", [{"force": 3.0}]),
        (EIGHT, "ground.patch", [{"friction": 0.1}]),
        (PAPER, "controller.0.believes", {"mass": 20.0}),
        (PAPER, "controller.1.yaw_slip_bound", 0.1),
        (PAPER, "controller.1.lateral_slip_acceleration_bound", 0.1),
        (PAPER, "controller.1.coupling_bound", 0.1),
        (PAPER, "reference.start.yaw_rate", 0.0),
        (PAPER, "reference.goal.acceleration", 0.0),
        (PAPER, "sensing.camera_rate", 3.0),
        (PAPER, "sensing.camera_heading_noise_deg", 0.5),
        (PAPER, "sensing.camera_delay", 0.1),
        (PAPER, "sensing.velocity_noise", 0.01),
        (PAPER, "sensing.delay", 0.01),
    ],
)
def test_keys_that_come_later(document, key, value):
    problems = refused(changed(document, {key: value}))
    assert [problem.later for problem in problems] == [True]
    assert problems[0].key.rpartition(".")[2] == key.rpartition(".")[2]


def test_a_sweep_over_a_key_that_comes_later():
    assert later(changed(PAPER, {"sweep": {"sensing.camera_rate": [1.0, 3.0]}}))


@pytest.mark.parametrize(
    ("name", "missing"),
    [
        (
            "paper-dynamic",
            {"plant.kind", "robot.drive", "reference.start.yaw_rate", "controller[1:robust_dynamic].kind"},
        ),
        ("belt-torque", {"robot.drive", "reference.goal.acceleration", "controller[0:nominal_dynamic].kind"}),
        ("paper-experiment", {"sensing.pose", "sensing.velocity", "sensing.camera_rate"}),
    ],
)
def test_the_scenarios_of_later_releases_are_refused_for_just_that(name, missing):
    path = SHARED / f"{name}.toml"
    if not path.exists():
        pytest.skip("these scenarios are not part of the project yet")
    with pytest.raises(ScenarioError) as caught:
        load(path)
    assert all(problem.later for problem in caught.value.problems)
    assert missing <= {problem.key for problem in caught.value.problems}
