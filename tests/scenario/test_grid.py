"""Sweeps: which keys, in which order, how many, and what is refused before anything is expanded."""

import math
from itertools import pairwise, product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl.scenario import ScenarioError, Span, override, read, sweep_over, worlds
from slipctl.scenario.grid import RUN_LIMIT, sweepable
from tests.scenario.documents import EIGHT, PAPER, TORQUE, changed, only, refused

BASE = changed(EIGHT, {"sweep": None})
VALUES = st.lists(st.floats(0.01, 2.0), min_size=1, max_size=4, unique=True)


def swept(sweep, document=BASE):
    return {**document, "sweep": sweep}


@given(
    st.dictionaries(
        st.sampled_from(
            [
                "ground.friction",
                "ground.film",
                "start.x_offset",
                "reference.speed",
                "controller.nominal_kinematic.speed_floor",
            ]
        ),
        VALUES,
        min_size=1,
        max_size=3,
    )
)
def test_the_grid_has_every_combination_the_first_key_slowest(sweep):
    grid = worlds(read(swept(sweep)))
    assert len(grid) == math.prod(map(len, sweep.values()))
    assert [tuple(world.varied.values()) for world in grid] == list(product(*sweep.values()))
    assert all(list(world.varied) == list(sweep) for world in grid)
    for world in grid:
        plain = changed(
            BASE, {key.replace("nominal_kinematic", "0"): value for key, value in world.varied.items()}
        )
        assert world.scenario == read(plain)
        assert world.scenario.sweep == ()


def test_without_a_sweep_there_is_one_world():
    scenario = read(PAPER)
    (world,) = worlds(scenario)
    assert (world.varied, world.scenario, world.seed) == ({}, scenario, 0)


def test_seeds_may_be_swept_and_stay_whole_numbers():
    grid = worlds(read(EIGHT))
    assert [world.seed for world in grid] == [0, 1, 2] * 2
    assert [world.scenario.seed for world in grid] == [0, 1, 2] * 2
    assert [world.varied["seed"] for world in grid] == [0, 1, 2] * 2
    assert all(isinstance(world.varied["seed"], int) for world in grid)
    assert only(swept({"seed": [0.5]})).key == "sweep.seed"


def test_a_controller_is_swept_by_its_label():
    grid = worlds(read(swept({"controller.robust.slip_bound": [0.1, 0.2]}, PAPER)))
    laws = [world.scenario.controller for world in grid]
    assert [law[1].slip_bound for law in laws if law[1].kind == "robust_kinematic"] == [0.1, 0.2]
    assert all(law[0] == laws[0][0] for law in laws)
    assert [law[1].label for law in laws] == ["robust", "robust"]


def beliefs(sweep):
    laws = [world.scenario.controller for world in worlds(read(swept(sweep, TORQUE)))]
    return [tuple(law.believes.mass for law in pair) for pair in laws]


def test_beliefs_are_swept_by_label_or_for_every_law():
    assert beliefs({"controller.robust_dynamic.believes.mass": [10.0, 30.0]}) == [(None, 10.0), (None, 30.0)]
    assert beliefs({"controller.nominal_dynamic.believes.mass": [10.0]}) == [(10.0, 20.0)]
    assert beliefs({"controller.*.believes.mass": [10.0, 30.0]}) == [(10.0, 10.0), (30.0, 30.0)]
    nested = {"controller": {"robust_dynamic": {"believes": {"mass": [10.0]}}}}
    assert beliefs(nested) == [(None, 10.0)]
    assert only(swept({"controller.robust_dynamic.believes.mass": [-1.0]}, TORQUE)).key == (
        "sweep.controller.robust_dynamic.believes.mass"
    )


def test_only_what_all_laws_have_is_swept_for_every_law():
    keys = sweepable(PAPER)
    assert {"controller.*.pole", "controller.*.believes.wheel_radius"} <= set(keys)
    assert not {"controller.*.slip_bound", "controller.*.believes.mass"} & set(keys)
    assert [
        law.pole for law in worlds(read(swept({"controller.*.pole": [-2.0]}, PAPER)))[0].scenario.controller
    ] == [
        -2.0,
        -2.0,
    ]
    assert only(swept({"controller.*.slip_bound": [0.1]}, PAPER)).key == "sweep.controller.*.slip_bound"
    assert {problem.key for problem in refused(swept({"controller.*.pole": [1.0]}, PAPER))} == {
        "controller[0:nominal_kinematic].pole",
        "controller[1:robust].pole",
    }


def test_a_swept_reference_changes_the_duration_unless_it_is_given():
    line = {"kind": "line", "speed": 1.0, "distance": 2.0}
    free = read(swept({"reference.speed": [0.5, 1.0]}, changed(BASE, {"reference": line, "duration": None})))
    assert [world.scenario.duration for world in worlds(free)] == [4.0, 2.0]
    fixed = read(swept({"reference.speed": [0.5, 1.0]}, changed(BASE, {"reference": line})))
    assert [world.scenario.duration for world in worlds(fixed)] == [4.0, 4.0]


def test_keys_may_be_nested_tables_as_well():
    quoted = {"ground.friction": [0.1, 0.2], "start.x_offset": {"from": 0, "to": 1, "count": 3}}
    nested = {"ground": {"friction": [0.1, 0.2]}, "start": {"x_offset": {"from": 0, "to": 1, "count": 3}}}
    assert read(swept(quoted)) == read(swept(nested))
    assert only(swept({**quoted, "ground": {"friction": [0.3]}})).found == "the key twice"


@given(st.floats(-5, 5), st.floats(-5, 5), st.integers(2, 30))
def test_linear_spans(first, last, count):
    values = list(Span(first, last, count))
    assert len(values) == count
    assert (values[0], values[-1]) == (first, last)
    steps = [b - a for a, b in pairwise(values)]
    assert all(math.isclose(step, (last - first) / (count - 1), rel_tol=1e-6, abs_tol=1e-9) for step in steps)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.integers(2, 30))
def test_log_spans(first, last, count):
    values = list(Span(first, last, count, "log"))
    assert (len(values), values[0], values[-1]) == (count, first, last)
    for before, after in pairwise(values):
        assert math.isclose(after / before, (last / first) ** (1 / (count - 1)), rel_tol=1e-9)


def test_span_values_are_short():
    assert list(Span(0.05, 0.2, 4)) == [0.05, 0.1, 0.15, 0.2]


def test_every_number_of_a_file_can_be_swept_and_nothing_else():
    keys = sweepable(PAPER)
    assert {"tick", "seed", "slip.yaw", "reference.goal.heading_deg", "controller.robust.pole"} <= set(keys)
    assert not {"ground.friction", "robot.torque_limit", "plant.timestep", "robot.model"} & set(keys)
    assert not [key for key in keys if key.endswith(("kind", "label", "uncertainty"))]
    assert {"ground.friction", "robot.torque_limit", "plant.timestep"} <= set(sweepable(BASE))
    assert "slip.yaw" not in sweepable(BASE)


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("ground.frction", "ground.friction"),
        ("grond.friction", "ground.friction"),
        ("reference.sped", "reference.speed"),
        ("controller.nominal_kinematic.poles", "controller.nominal_kinematic.pole"),
        ("controller.nominal_kinematc.pole", "nominal_kinematic"),
        ("sed", "seed"),
    ],
)
def test_a_swept_key_that_does_not_exist(key, meant):
    problem = only(swept({key: [0.1]}))
    assert (problem.key, problem.nearest) == (f"sweep.{key}", meant)


@pytest.mark.parametrize(
    "key", ["robot.model", "plant.kind", "start.at_rest", "controller.nominal_kinematic.label", "a..b"]
)
def test_a_swept_key_that_is_no_number(key):
    assert "not a number" in only(swept({key: [1]})).found


@pytest.mark.parametrize(
    ("values", "place", "allowed"),
    [
        ([], "", "at least one value"),
        ([0.1, math.nan], "[1]", "a finite number"),
        ([0.1, math.inf], "[1]", "a finite number"),
        ([True], "[0]", "a finite number"),
        (["0.1"], "[0]", "a finite number"),
        ([0.1, 0.1], "", "each value once"),
        (0.1, "", "an array of numbers"),
        ("0.1:0.2:3", "", "an array of numbers"),
        ({}, "", "an array of numbers"),
        ({"from": 0.1, "to": 0.2}, ".count", "at least 2"),
        ({"from": 0.1, "to": 0.2, "count": 1}, ".count", "at least 2"),
        ({"from": 0.1, "to": 0.2, "count": 2.0}, ".count", "at least 2"),
        ({"from": 0.1, "to": 0.1, "count": 2}, ".to", "another number"),
        ({"from": "0", "to": 0.1, "count": 2}, ".from", "a finite number"),
        ({"from": 0.1, "to": math.nan, "count": 2}, ".to", "a finite number"),
        ({"from": 0.0, "to": 0.1, "count": 2, "scale": "log"}, ".from", "> 0"),
        ({"from": 0.1, "to": 0.2, "count": 2, "scale": "lin"}, ".scale", '"linear"'),
        ({"from": 0.1, "to": 0.2, "cnt": 2, "count": 2}, ".cnt", "count"),
    ],
)
def test_values_that_are_none(values, place, allowed):
    problem = only(swept({"ground.friction": values}))
    assert problem.key == f"sweep.ground.friction{place}"
    assert allowed in problem.allowed


def test_every_world_is_validated():
    assert only(swept({"ground.friction": [0.1, -0.2]})).found == "-0.2"
    assert only(swept({"tick": [0.01, 0.0105]})).key == "sweep.tick"
    bound = only(swept({"controller.robust.slip_bound": [0.4, 0.5]}, PAPER))
    assert (bound.key, bound.found) == ("sweep.controller.robust.slip_bound", "0.5")


def test_a_world_that_only_the_combination_makes_invalid_is_told_with_its_values():
    problems = refused(swept({"plant.timestep": [0.001, 0.0015], "tick": [0.01, 0.012]}))
    assert [problem.key for problem in problems] == ["sweep.tick"]
    clash = refused(swept({"ground.creep_stiffness": [100.0]}))
    assert "in the world ground.creep_stiffness = 100" in clash[0].found


def test_a_sweep_does_not_hide_a_wrong_base():
    assert {problem.key for problem in refused(changed(EIGHT, {"ground.friction": -1.0}))} == {
        "ground.friction"
    }


def test_a_wrong_kind_does_not_make_its_swept_keys_wrong():
    assert [
        problem.key
        for problem in refused(swept({"reference.speed": [1.0]}, changed(BASE, {"reference.kind": "eight"})))
    ] == ["reference.kind"]


def test_a_sweep_of_a_million_millions_is_refused_before_it_is_expanded():
    huge = {"from": 0.1, "to": 0.9, "count": 10**6}
    problem = only(swept({"ground.friction": huge, "ground.film": huge}))
    assert problem.key == "sweep"
    assert "1,000,000 × 1,000,000 worlds × 1 controllers = 1,000,000,000,000 runs" in problem.found
    assert f"{RUN_LIMIT:,}" in problem.allowed
    assert "runs" in only(swept({"seed": {"from": 0, "to": 10**12, "count": 10**12}})).found


def test_many_wrong_worlds_make_a_short_message():
    grid = {"ground.friction": {"from": -2.0, "to": -1.0, "count": 1000}, "ground.film": [1.0, 2.0]}
    assert len(refused(swept(grid))) < 100


def test_override_lists_spans_and_keeps_the_order_of_the_grid():
    scenario = override(
        read(EIGHT), {"start.x_offset": "0:0.2:3", "seed": "4", "ground.friction": "0.01:1:3:log"}
    )
    assert [axis.key for axis in scenario.sweep] == ["ground.friction", "seed", "start.x_offset"]
    assert [list(axis) for axis in scenario.sweep] == [[0.01, 0.1, 1.0], [4], [0.0, 0.1, 0.2]]
    assert [axis.key for axis in read(EIGHT).sweep] == ["ground.friction", "seed"]
    assert (
        override(read(PAPER), {"slip.yaw": [0.1, 0.2]}).sweep
        == override(read(PAPER), {"slip.yaw": "0.1,0.2"}).sweep
    )


def test_override_keeps_everything_else():
    scenario = read(EIGHT)
    assert override(scenario, {}) == scenario
    assert sweep_over(scenario, ["seed=1,2"]) == override(scenario, {"seed": "1,2"})


def test_it_is_told_how_far_a_large_grid_is_judged():
    told = []
    grid = {"ground.friction": {"from": 0.1, "to": 1.0, "count": 600}, "seed": [1, 2, 3]}
    read(swept(grid), progress=lambda *how_far: told.append(how_far))
    # seeds are judged alone
    assert told == [(done, 603, "judging the grid") for done in (0, 256, 512)]
    told.clear()
    read(swept({"seed": [1, 2, 3]}), progress=lambda *how_far: told.append(how_far))
    assert told == [(0, 3, "judging the grid")]
    told.clear()
    scenario = read(PAPER, progress=lambda *how_far: told.append(how_far))
    assert told == []
    sweep_over(scenario, ["seed=1,2"], lambda *how_far: told.append(how_far))
    assert told == [(0, 2, "judging the grid")]


def test_what_was_judged_is_not_judged_again():
    told = []
    scenario = read(EIGHT)
    assert sweep_over(scenario, [], lambda *how_far: told.append(how_far)) == scenario
    assert told == []


@pytest.mark.parametrize("text", ["", "a", "0.1,", "0.1:0.2", "0.1:0.2:x", "0.1:0.2:3:log:4", "0.1;0.2"])
def test_override_refuses_other_texts(text):
    with pytest.raises(ScenarioError, match=r"--over: ground.friction: found .* FROM:TO:COUNT"):
        override(read(EIGHT), {"ground.friction": text})


@pytest.mark.parametrize("over", [["ground.friction"], ["=0.1"], ["seed=1", "seed=2"]])
def test_over_is_key_and_values(over):
    with pytest.raises(ScenarioError, match="--over: "):
        sweep_over(read(EIGHT), over)


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({"ground.friction": "nan"}, "a finite number"),
        ({"ground.friction": "0.1:0.2:1"}, "at least 2"),
        ({"ground.friction": "0.1:0.2:3:logg"}, 'did you mean "log"'),
        ({"ground.frction": "0.1"}, 'did you mean "ground.friction"'),
        ({"ground.friction": "-1"}, "≥ 0"),
        ({"ground.friction": "0.1:0.2:1000000"}, "runs"),
    ],
)
def test_override_is_validated_like_a_file(over, message):
    with pytest.raises(ScenarioError, match=message):
        override(read(EIGHT), over)
