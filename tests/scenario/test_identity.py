"""Identity depends on what a scenario means, on all of it, and on nothing else."""

import json
import random
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl import shipped
from slipctl.scenario import canonical, dump, load, override, read, scenario_id, worlds
from tests.scenario.documents import EIGHT, PAPER, changed, leaves

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


@given(st.sampled_from([PAPER, {key: value for key, value in EIGHT.items() if key != "sweep"}]), st.data())
def test_every_other_number_counts(document, data):
    key, value = data.draw(
        st.sampled_from(
            [leaf for leaf in leaves(document) if isinstance(leaf[1], int | float) and leaf[1] is not True]
        )
    )
    factor = 3 if key.endswith(("tick", "timestep")) else 0.97
    if key == "seed":
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


def test_an_identity_recorded_once_stays():
    # A new key with a default must not change it; a change of meaning must.
    assert scenario_id(load("paper-kinematic")) == (
        "sha256:bc0c12b2850cdd29788e383bb3a26b0b3be356bcebececf563e9cbbd7b2acc8e"
    )


@pytest.mark.parametrize("source", [PAPER, EIGHT, *shipped.scenario_names()])
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
