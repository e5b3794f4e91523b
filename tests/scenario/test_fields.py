"""Single keys: every wrong one is named, with what stands there and what may."""

import math
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from slipctl.scenario import ScenarioError, read
from slipctl.scenario.structure import table_at
from tests.scenario.documents import EIGHT, EXPERIMENT, PAPER, TORQUE, changed, leaves, only, refused

DOCUMENTS = st.sampled_from(
    [PAPER, {key: value for key, value in EIGHT.items() if key != "sweep"}, TORQUE, EXPERIMENT]
)


@st.composite
def leaf_of_a_document(draw, kind: Any = object):
    document = draw(DOCUMENTS)
    return document, draw(st.sampled_from([leaf for leaf in leaves(document) if _is(leaf[1], kind)]))[0]


def _is(value, kind):
    return kind is object or (isinstance(value, kind) and not isinstance(value, bool))


def shown(key, document):
    """Return the dotted key as messages spell it."""
    parts = key.split(".")
    if parts[0] == "controller":
        entry = document["controller"][int(parts[1])]
        return f"controller[{parts[1]}:{entry.get('label', entry['kind'])}].{'.'.join(parts[2:])}"
    return key


def test_the_documents_themselves_are_accepted():
    assert refused(PAPER) == []
    assert refused(EIGHT) == []
    assert refused(TORQUE) == []
    assert refused(EXPERIMENT) == []


@given(leaf_of_a_document(), st.data())
def test_a_misspelt_key_is_reported_with_the_meant_one_as_the_nearest(picked, data):
    document, key = picked
    *parents, name = key.split(".")
    assume(len(name) >= 4)
    place = data.draw(st.integers(0, len(name) - 1), label="place")
    letter = data.draw(st.sampled_from("abcdefghijklmnopqrstuvwxyz_"), label="letter")
    wrong = data.draw(
        st.sampled_from(
            [
                name[:place] + name[place + 1 :],
                name[:place] + letter + name[place:],
                name[:place] + letter + name[place + 1 :],
                name[:place] + name[place : place + 2][::-1] + name[place + 2 :],
            ]
        ),
        label="wrong",
    )
    path = tuple(int(part) if part.isdigit() else part for part in parents)
    table = table_at(path, document)
    assert table is not None
    assume(wrong not in table.model_fields)
    moved = changed(document, {key: None, ".".join([*parents, wrong]): "?"})
    unknown = [problem for problem in refused(moved) if problem.found == "an unknown key"]
    if name == "kind":
        # without its kind a table cannot be read any further
        assert any(problem.key.endswith("kind") and "missing" in problem.found for problem in refused(moved))
        return
    assert [(problem.key.rpartition(".")[2], problem.nearest) for problem in unknown] == [(wrong, name)]
    assert name in unknown[0].allowed.split(", ")


@given(leaf_of_a_document((int, float)), st.sampled_from([math.nan, math.inf, -math.inf]))
def test_no_number_may_be_nan_or_infinite(picked, value):
    document, key = picked
    assert shown(key, document) in [problem.key for problem in refused(changed(document, {key: value}))]


@given(leaf_of_a_document((int, float)), st.sampled_from(["1.0", True, [1.0], {"a": 1}, 10**400]))
def test_numbers_are_numbers(picked, value):
    document, key = picked
    problems = refused(changed(document, {key: value}))
    assert shown(key, document) in [problem.key for problem in problems]


@given(leaf_of_a_document(str), st.sampled_from([1, 1.5, False, ["paper"]]))
def test_words_are_words(picked, value):
    document, key = picked
    named = refused(changed(document, {key: value}))
    assert key.rpartition(".")[2] in [problem.key.rpartition(".")[2] for problem in named]


def test_whole_numbers_are_numbers():
    whole = read(changed(PAPER, {"reference.goal.x": 2, "controller.0.pole": -1}))
    assert whole.reference.kind == "point_to_point"
    assert whole.reference.goal.x == 2.0
    assert isinstance(whole.controller[0].pole, float)


def test_the_seed_is_a_whole_number():
    assert only(changed(PAPER, {"seed": 1.5})).allowed == "a whole number ≥ 0 and < 2^63"
    assert only(changed(PAPER, {"seed": 2**63})).key == "seed"


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("tick", 0),
        ("tick", -0.01),
        ("duration", 0.0),
        ("duration", -1.0),
        ("plant.timestep", 0.0),
        ("plant.arena", -1.0),
        ("robot.speed_limit", 0.0),
        ("robot.torque_limit", -4.0),
        ("ground.friction", -0.1),
        ("ground.film", 0.0),
        ("ground.slope_deg", -1.0),
        ("ground.slope_deg", 46.0),
        ("ground.downhill_deg", 361.0),
        ("reference.length", 0.0),
        ("reference.speed", 0.0),
        ("reference.laps", -1),
        ("controller.0.pole", 0.0),
        ("controller.0.pole", 2.0),
        ("controller.0.speed_floor", -0.05),
    ],
)
def test_a_number_out_of_range_is_refused_with_its_range(key, value):
    document = changed(EIGHT, {"sweep": None})
    problem = only(changed(document, {key: value}))
    assert problem.key == shown(key, document)
    assert float(problem.found) == value
    assert problem.allowed.startswith("a number ")
    assert any(sign in problem.allowed for sign in "<>≤≥")


def test_friction_may_be_zero_and_a_law_may_have_no_floor():
    assert refused(changed(EIGHT, {"ground.friction": 0, "start": None, "controller.0.speed_floor": 0})) == []


def test_the_message_tells_file_key_found_allowed_and_unit():
    with pytest.raises(ScenarioError) as caught:
        read(changed(EIGHT, {"ground.film": -5.0}), "my/floor.toml")
    assert str(caught.value) == "my/floor.toml: ground.film: found -5.0; allowed: a number > 0 [N·s/m]"


@pytest.mark.parametrize("table", ["robot", "plant", "reference"])
def test_a_missing_table_is_named(table):
    assert only(changed(PAPER, {table: None})).key == table


@pytest.mark.parametrize(
    "key", ["tick", "robot.model", "plant.kind", "reference.goal.y", "controller.1.uncertainty", "slip.kind"]
)
def test_a_missing_key_is_named(key):
    problem = only(changed(PAPER, {key: None}))
    assert problem.key == shown(key, PAPER)
    assert "missing" in problem.found


@pytest.mark.parametrize(
    ("key", "wrong", "meant"),
    [
        ("plant.kind", "mujocco", "mujoco"),
        ("robot.drive", "wheelspeed", "wheel_speed"),
        ("robot.model", "magelan", "magellan_pro"),
        ("slip.kind", "sinusoid", "sinusoidal"),
        ("reference.kind", "figure-eight", "figure_eight"),
        ("controller.1.kind", "robust_kinematics", "robust_kinematic"),
        ("controller.1.uncertainty", "independant", "independent"),
    ],
)
def test_a_misspelt_choice_is_reported_with_the_choices_and_the_nearest(key, wrong, meant):
    problem = next(
        problem
        for problem in refused(changed(PAPER, {key: wrong}))
        if problem.key.endswith(key.split(".")[-1])
    )
    assert problem.nearest == meant
    assert f'"{meant}"' in problem.allowed
    assert problem.found == f'"{wrong}"'


@pytest.mark.parametrize("table", ["robot", "plant", "slip", "reference", "start", "sensing", "sweep"])
@pytest.mark.parametrize("value", [3, "mujoco", [1, 2]])
def test_a_table_must_be_a_table(table, value):
    problem = next(problem for problem in refused(changed(PAPER, {table: value})) if problem.key == table)
    assert "a table" in problem.allowed


def test_controllers_are_an_array_of_tables():
    assert only(changed(PAPER, {"controller": PAPER["controller"][0]})).allowed == (
        "an array: write [[controller]], not [controller]"
    )
    assert only(changed(PAPER, {"controller": []})).found == "an empty array"
    assert only(changed(PAPER, {"controller": [3]})).key == "controller[0]"


@pytest.mark.parametrize("label", ["Robust", "a b", "", "a.b", "rö", "a/b", "a\n"])
def test_labels_are_plain_words(label):
    assert "a-z" in only(changed(PAPER, {"controller.0.label": label})).allowed


@pytest.mark.parametrize("name", ["../up", "a b", "", ".hidden", "a/b", "a\n"])
def test_names_can_name_a_folder(name):
    assert "folder" in only(changed(PAPER, {"name": name})).allowed


@pytest.mark.parametrize(
    ("document", "key", "owner"),
    [
        (PAPER, "plant.timestep", "mujoco"),
        (PAPER, "slip.period", "sinusoidal"),
        (EIGHT, "reference.radius", "circle"),
        (EIGHT, "controller.0.slip_bound", "robust_kinematic"),
    ],
)
def test_a_key_of_another_kind_is_refused_as_ignored(document, key, owner):
    problem = only(changed(document, {key: 0.001}))
    assert owner in problem.found
    assert "ignore" in problem.found


def test_a_key_in_the_wrong_table_is_sent_to_the_right_one():
    assert only(changed(EIGHT, {"creep_stiffness": 100.0})).nearest == "ground.creep_stiffness"
    assert only(changed(PAPER, {"reference.x": 1.0})).found.startswith("a key of line and circle")


def test_true_is_the_same_word_as_the_boolean():
    assert read(changed(EIGHT, {"sensing.pose": True})) == read(EIGHT)
    assert only(changed(EIGHT, {"sensing.pose": False})).allowed == '"true", "odometry_camera"'
