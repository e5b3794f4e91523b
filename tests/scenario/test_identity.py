"""Identity depends on what a scenario means, on all of it, and on nothing else."""

import json
import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl import shipped
from slipctl.scenario import canonical, dump, load, override, read, scenario_id, worlds
from tests.scenario.documents import EIGHT, EXPERIMENT, PAPER, SCALED, TORQUE, changed, leaves

DEFAULTS = {
    "seed": 0,
    "duration": 20.0,
    "start": {},
    "sensing": {"pose": "true"},
    "start.x_offset": 0.0,
    "controller.1.speed_floor": 0.05,
    "controller.0.label": "nominal_kinematic",
}


def identity(document):
    return scenario_id(read(document))


def shuffled(table: Any, seed: int) -> Any:
    if isinstance(table, dict):
        items = [(key, shuffled(value, seed)) for key, value in table.items()]
        random.Random(seed).shuffle(items)
        return dict(items)
    return [shuffled(value, seed) for value in table] if isinstance(table, list) else table


@given(st.sampled_from([PAPER, EIGHT]), st.integers(0, 1000))
def test_the_order_of_keys_means_nothing(document, seed):
    mixed = shuffled({key: value for key, value in document.items() if key != "sweep"}, seed)
    assert identity({**mixed, "sweep": document.get("sweep", {})}) == identity(document)


def test_the_order_of_a_sweep_orders_the_worlds_and_counts():
    turned = {**EIGHT, "sweep": dict(reversed(EIGHT["sweep"].items()))}
    assert identity(turned) != identity(EIGHT)


@pytest.mark.parametrize("key", DEFAULTS)
def test_a_key_at_its_default_means_nothing(key):
    assert identity(changed(PAPER, {key: DEFAULTS[key]})) == identity(PAPER)


def test_name_and_description_mean_nothing():
    assert identity(changed(PAPER, {"name": "other", "description": "Something"})) == identity(PAPER)


def test_numbers_are_numbers_however_written():
    assert identity(
        changed(EIGHT, {"ground.film": 100, "plant.arena": 10, "reference.laps": 2.0})
    ) == identity(EIGHT)
    assert identity(changed(PAPER, {"reference.start.x": -0.0})) == identity(PAPER)
    sweeps = [{"slip.yaw": [1, 2]}, {"slip.yaw": [1.0, 2.0]}, {"slip": {"yaw": [1, 2.0]}}]
    assert len({identity({**PAPER, "sweep": sweep}) for sweep in sweeps}) == 1


WITHOUT_SWEEP = [PAPER, {key: value for key, value in EIGHT.items() if key != "sweep"}, TORQUE, EXPERIMENT]


@given(st.sampled_from(WITHOUT_SWEEP), st.data())
def test_every_other_number_counts(document, data):
    key, value = data.draw(
        st.sampled_from(
            [leaf for leaf in leaves(document) if isinstance(leaf[1], int | float) and leaf[1] is not True]
        )
    )
    factor = 3 if key.endswith(("tick", "timestep")) else 0.97
    if document is EXPERIMENT and key == "tick":
        other = value / 2  # the delays are multiples of it, too
    elif key in ("sensing.pose_delay", "sensing.velocity_delay"):
        other = 2 * value
    elif key == "seed":
        other = value + 1
    elif key in ("tick", "plant.timestep"):
        other = value / 2 if key == "plant.timestep" else value * factor
    else:
        other = value * factor if value else 0.013
    assert identity(changed(document, {key: other})) != identity(document)


@pytest.mark.parametrize("key", ["slip.kind", "controller.1.uncertainty", "controller.1.label"])
def test_words_count(key):
    other = {
        "slip.kind": "sinusoidal",
        "controller.1.uncertainty": "independent",
        "controller.1.label": "bold",
    }
    document = changed(PAPER, {key: other[key]} | ({"slip.period": 2.0} if key == "slip.kind" else {}))
    assert identity(document) != identity(PAPER)


def test_at_rest_counts():
    assert identity(changed(PAPER, {"start": {"at_rest": True}})) != identity(PAPER)


def test_the_controllers_order_counts_as_it_orders_the_rows():
    assert identity({**PAPER, "controller": PAPER["controller"][::-1]}) != identity(PAPER)


def test_the_canonical_text_holds_no_defaults():
    tables = json.loads(canonical(load("friction-sweep")))
    assert tables == {
        "seed": 1,
        "tick": 0.01,
        "robot": {"model": "magellan_pro", "drive": "wheel_speed"},
        "plant": {"kind": "mujoco"},
        "reference": {"kind": "figure_eight", "length": 2.0, "speed": 1.0},
        "controller": [
            {"kind": "nominal_kinematic", "pole": -2.0},
            {
                "kind": "robust_kinematic",
                "pole": -2.0,
                "slip_bound": 0.4,
                "boundary_layer": 0.05,
                "uncertainty": "independent",
            },
        ],
        "sweep": [
            [
                "ground.friction",
                [0.05, 0.08, 0.1, 0.12, 0.13, 0.14, 0.15, 0.16, 0.18, 0.2, 0.25, 0.3, 0.5, 0.8],
            ]
        ],
    }


RECORDED = {
    "belt": "381f1e26be5166d5ed8143439d3e7c9c11910a7b25e968e4d109f6dd87eb4319",
    "cross-slope": "03023d09efae224df8d5966e5606cc4186523e72551550d8276ce26906d04e11",
    "friction-sweep": "2820bab41543e81ca8616b4b9f9715764914ad3d136f3a65a656e3a73fde9b87",
    "paper-kinematic": "bc0c12b2850cdd29788e383bb3a26b0b3be356bcebececf563e9cbbd7b2acc8e",
    "tyre-creep": "cc520a71fc41172a389cd3f1d42b515b371ca88ed970374731b4c99882b0be44",
    "wet-slope": "a3193a68b125cf4e2465d651b116b9bdbb3d2e38782edde04e99c7927a5da3c1",
}


@pytest.mark.parametrize("name", RECORDED)
def test_an_identity_recorded_once_stays(name):
    # A new key with a default must not change it; a change of meaning must.
    assert scenario_id(load(name)) == f"sha256:{RECORDED[name]}"


def test_empty_beliefs_and_the_default_time_mean_nothing():
    assert identity(changed(PAPER, {"controller.0.believes": {}})) == identity(PAPER)
    assert identity(changed(SCALED, {"controller.0.time_scaled": True})) == identity(SCALED)
    assert identity(changed(SCALED, {"controller.0.time_scaled": False})) != identity(SCALED)
    assert identity(changed(SCALED, {"controller.1.time_scaled": None})) != identity(SCALED)
    assert identity(changed(PAPER, {"reference.time_scaling": False})) == identity(PAPER)
    assert identity(changed(PAPER, {"reference.time_scaling": True})) != identity(PAPER)


@pytest.mark.parametrize("key", ["sensing.pose", "sensing.velocity", "robot.compensate_wheels"])
def test_new_words_count(key):
    document = EXPERIMENT if key.startswith("sensing") else TORQUE
    other = {
        "sensing.pose": None,
        "sensing.velocity": "odometry",
        "robot.compensate_wheels": False,
    }
    changes = {key: other[key]}
    if key == "sensing.pose":
        changes |= {f"sensing.{name}": None for name in document["sensing"] if name.startswith("camera_")}
    assert identity(changed(document, changes)) != identity(document)


@pytest.mark.parametrize("source", [PAPER, EIGHT, TORQUE, EXPERIMENT, SCALED, *shipped.scenario_names()])
def test_a_dump_reads_back_as_the_same_scenario(source):
    scenario = read(source) if isinstance(source, dict) else load(source)
    again = read(json.loads(json.dumps(dump(scenario), allow_nan=False)))
    assert again == scenario
    assert canonical(again) == canonical(scenario)
    for world in worlds(scenario)[:2]:
        assert read(dump(world.scenario)) == world.scenario


def test_a_dump_states_defaults_that_play_a_part_and_no_others():
    paper = dump(read(PAPER))
    assert paper["start"]["x_offset"] == 0.0
    assert paper["controller"][1]["speed_floor"] == 0.05
    assert "ground" not in paper
    assert "torque_limit" not in paper["robot"]
    split = changed(
        EIGHT,
        {"sweep": None, "ground.friction": None, "ground.friction_left": 0.1, "ground.friction_right": 0.2},
    )
    assert "friction" not in dump(read(split))["ground"]
    assert read(dump(read(split))) == read(split)
    assert read(split).ground.wheel_friction == (0.1, 0.2)
    assert read(EIGHT).ground.wheel_friction == (0.5, 0.5)


def test_spans_keep_their_form():
    scenario = override(load("belt"), {"slip.yaw": "0.1:0.4:1000:log"})
    assert dump(scenario)["sweep"] == {"slip.yaw": {"from": 0.1, "to": 0.4, "count": 1000, "scale": "log"}}
    assert json.loads(canonical(scenario))["sweep"] == [["slip.yaw", dump(scenario)["sweep"]["slip.yaw"]]]
