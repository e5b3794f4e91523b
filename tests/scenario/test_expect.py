"""Claims: what they may say, what is refused and why, and that they change no run."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from slipctl import metrics
from slipctl.experiment.batch import STATUS_NAMES
from slipctl.scenario import dump, json_schema, override, read, scenario_id, template, worlds
from slipctl.scenario.expect import ErrorMetric, StatusIs
from slipctl.scenario.structure import KINDS
from slipctl.scenario.where import Band, Condition, read_where, where_table
from tests.scenario.documents import EIGHT, PAPER, changed, only, refused
from tests.scenario.test_json_schema import accepts

GRID = {**PAPER, "sweep": {"slip.yaw": [0.1, 0.2, 0.4], "seed": {"from": 0, "to": 4, "count": 5}}}
BETTER = {"kind": "better", "controller": "robust", "than": "nominal_kinematic", "factor": 2.0}
CLAIMS: list[dict[str, Any]] = [
    BETTER,
    {**BETTER, "metric": "max_position_error", "command_variation_factor": 5.0},
    {**BETTER, "where": {"slip.yaw": {"from": 0.2}}, "only_where_guaranteed": True},
    {"kind": "below_bound", "controller": "robust", "where": {"slip": {"yaw": 0.1}}},
    {"kind": "guarantee", "controller": "robust", "where": {"seed": [0, 3], "slip.yaw": {"to": 0.2}}},
    {"kind": "guarantee", "controller": "robust", "fraction": 0.9},
    {"kind": "status"},
    {"kind": "status", "controller": "nominal_kinematic", "status": "left_the_arena"},
    {"kind": "below", "controller": "robust", "metric": "rms_heading_error", "limit": 0.5},
]


def claiming(*claims: dict[str, Any], document: dict[str, Any] = GRID) -> dict[str, Any]:
    return {**document, "expect": list(claims)}


def test_every_kind_is_read_as_it_stands():
    assert refused(claiming(*CLAIMS)) == []
    claims = read(claiming(*CLAIMS)).expect
    assert [claim.kind for claim in claims] == [claim["kind"] for claim in CLAIMS]
    for claim, given_table in zip(claims, CLAIMS, strict=True):
        for key, value in given_table.items():
            if key != "where":
                assert getattr(claim, key) == value
    assert getattr(claims[0], "metric", "") == "rms_position_error"
    assert getattr(claims[0], "command_variation_factor", 0.0) is None
    assert getattr(claims[4], "fraction", 0.0) == 1.0
    assert claims[6].controller is None


def test_a_claim_says_what_it_claims():
    texts = [str(claim) for claim in read(claiming(*CLAIMS)).expect]
    assert texts[0] == "robust beats nominal_kinematic in rms_position_error by a factor of 2 or more"
    assert texts[1].endswith("with at most 5 times its command_variation")
    assert texts[2].endswith(", where slip.yaw is 0.2 or more, where its guarantee holds")
    assert texts[3] == "robust stays below its guaranteed error bound, where slip.yaw is 0.1"
    assert texts[4].endswith("holds on every tick, where seed is 0 or 3 and slip.yaw is up to 0.2")
    assert "90 % of the ticks" in texts[5]
    assert texts[6] == "every run of every law ends as completed"
    assert texts[8] == "rms_heading_error of robust is at most 0.5"


def test_claims_are_no_part_of_a_scenario_s_identity_and_of_no_world():
    scenario = read(claiming(*CLAIMS))
    assert scenario_id(scenario) == scenario_id(read(GRID))
    assert worlds(scenario) == worlds(read(GRID))
    assert all(world.scenario.expect == () for world in worlds(scenario))
    assert scenario.expect


@pytest.mark.parametrize("claims", [CLAIMS, []])
def test_they_survive_a_dump_and_a_template(claims, tmp_path):
    scenario = read(claiming(*claims))
    tables = json.loads(json.dumps(dump(scenario), allow_nan=False))
    assert ("expect" in tables) == bool(claims)
    assert read(tables) == scenario
    path = tmp_path / "eight.toml"
    path.write_text(template("friction-sweep", "eight"), encoding="utf-8")
    text = template(str(path), "again")
    assert (
        read(tomllib.loads(text), name="again").expect == read(tomllib.loads(path.read_text("utf-8"))).expect
    )


def test_a_template_of_a_file_with_claims_holds_them(tmp_path):
    text = template("paper-kinematic", "mine")
    assert "[[expect]]" in text
    sweep = '\n[sweep]\n"slip.yaw" = [0.1, 0.2]\n'
    claim = '\n[[expect]]\nkind = "status"\nwhere = { "slip.yaw" = { from = 0.2 }, seed = 3 }\n'
    path = tmp_path / "mine.toml"
    head, mark, _ = text.partition("\n# What is claimed")
    assert mark
    path.write_text(head + sweep.replace(']\n"slip', ']\nseed = [3]\n"slip') + claim, encoding="utf-8")
    again = template(str(path), "again")
    assert 'where = { "slip.yaw" = { from = 0.2 }, seed = 3.0 }' in again
    assert "# controller: Label of the law; default: every one" in again


def test_a_changed_grid_has_no_claims():
    scenario = override(read(claiming(*CLAIMS)), {"slip.yaw": "0.15,0.3"})
    assert scenario.expect == ()


def test_the_schema_knows_them():
    schema = json_schema()
    assert accepts(schema, claiming(*CLAIMS))
    for wrong in (
        {**BETTER, "factor": 0.9},
        {**BETTER, "metric": "rms"},
        {**BETTER, "kind": "best"},
        {**BETTER, "where": {"slip.yaw": "0.1"}},
        {**BETTER, "limit": 1.0},
        {"kind": "guarantee", "controller": "robust", "fraction": 1.1},
        {"kind": "below", "controller": "robust"},
    ):
        assert not accepts(schema, claiming(wrong))
        assert refused(claiming(wrong))


def test_the_words_are_those_of_the_metrics_and_of_the_runs():
    assert set(metrics.UNITS) - set(get_args(ErrorMetric)) == {"guarantee_fraction", "min_forward_speed"}
    assert set(get_args(ErrorMetric)) < set(metrics.UNITS)
    assert set(get_args(StatusIs.model_fields["status"].annotation)) == set(STATUS_NAMES.values())


@pytest.mark.parametrize(
    ("claim", "key", "found", "nearest"),
    [
        ({**BETTER, "controller": "robus"}, "controller", 'no controller labelled "robus"', "robust"),
        (
            {**BETTER, "than": "nominal_kin"},
            "than",
            'no controller labelled "nominal_kin"',
            "nominal_kinematic",
        ),
        ({**BETTER, "than": "robust"}, "than", '"robust", the same as controller', None),
        ({**BETTER, "factor": 0.99}, "factor", "0.99", None),
        ({**BETTER, "factor": "2"}, "factor", '"2"', None),
        ({**BETTER, "metric": "rms_error"}, "metric", '"rms_error"', "rms_heading_error"),
        ({**BETTER, "metric": "guarantee_fraction"}, "metric", '"guarantee_fraction"', "saturation_fraction"),
        ({**BETTER, "facter": 2.0}, "facter", "an unknown key", "factor"),
        ({**BETTER, "command_variation_factor": 0.0}, "command_variation_factor", "0.0", None),
        (
            {"kind": "status", "controller": "rob"},
            "controller",
            'no controller labelled "rob"',
            "robust",
        ),
        ({"kind": "status", "status": "complete"}, "status", '"complete"', "completed"),
        (
            {"kind": "status", "only_where_guaranteed": True},
            "only_where_guaranteed",
            "true, but no",
            None,
        ),
        ({"kind": "below", "controller": "robust"}, "limit", "nothing (the key is missing)", None),
        ({"kind": "below", "controller": "robust", "limit": -1.0}, "limit", "-1.0", None),
        ({"kind": "guarantee", "controller": "robust", "fraction": 1.5}, "fraction", "1.5", None),
    ],
)
def test_what_is_wrong_with_a_claim(claim, key, found, nearest):
    problem = only(claiming({"kind": "status"}, claim))
    assert problem.key == f"expect[1:{claim['kind']}].{key}"
    assert problem.found.startswith(found)
    assert problem.nearest == nearest


def test_a_kind_that_does_not_exist():
    problem = only(claiming({**BETTER, "kind": "beter"}))
    assert (problem.key, problem.nearest) == ("expect[0:beter].kind", "better")
    assert '"below_bound"' in problem.allowed
    assert only(claiming({"controller": "robust"})).key == "expect[0].kind"
    assert "[[expect]]" in only({**GRID, "expect": BETTER}).allowed


@pytest.mark.parametrize("kind", ["below_bound", "guarantee"])
def test_a_guarantee_is_claimed_only_of_a_law_with_a_theorem(kind):
    problem = only(claiming({"kind": kind, "controller": "nominal_kinematic"}))
    assert problem.key == f"expect[0:{kind}].controller"
    assert "without a theorem" in problem.found
    assert problem.allowed == "robust"
    alone = changed(EIGHT, {"expect": [{"kind": kind, "controller": "nominal_kinematic"}]})
    assert "no controller here has a theorem" in only(alone).allowed


def test_only_where_guaranteed_needs_a_guarantee_and_a_claim_that_can_fail():
    swapped = {**BETTER, "controller": "nominal_kinematic", "than": "robust", "only_where_guaranteed": True}
    assert "without a theorem" in only(claiming(swapped)).found
    vacuous = {"kind": "guarantee", "controller": "robust", "only_where_guaranteed": True}
    assert "could not fail" in only(claiming(vacuous)).found


@pytest.mark.parametrize(
    ("where", "key", "found", "nearest"),
    [
        ({"slip.yow": 0.1}, "slip.yow", "a key that is not swept", "slip.yaw"),
        ({"slip.lateral": 0.4}, "slip.lateral", "a key that is not swept", "slip.yaw"),
        ({"slip": {"yaw": 0.15}}, "slip.yaw", "0.15, which no world has", "0.1"),
        ({"slip.yaw": [0.1, 0.35]}, "slip.yaw", "0.35, which no world has", "0.4"),
        ({"slip.yaw": [0.1, 0.1]}, "slip.yaw", "0.1 more than once", None),
        ({"slip.yaw": []}, "slip.yaw", "an empty array", None),
        ({"slip.yaw": {}}, "slip.yaw", "an empty table", None),
        ({"slip.yaw": {"from": 0.41}}, "slip.yaw", "0.41 or more, which no world has", None),
        ({"slip.yaw": {"from": 0.4, "to": 0.1}}, "slip.yaw.to", "0.1", None),
        ({"slip.yaw": {"from": 0.1, "too": 0.4}}, "slip.yaw.too", "an unknown key", "to"),
        ({"slip.yaw": {"from": "0.1"}}, "slip.yaw.from", '"0.1"', None),
        ({"slip.yaw": True}, "slip.yaw", "true", None),
        ({"seed": 7}, "seed", "7, which no world has", "4"),
    ],
)
def test_what_is_wrong_with_where(where, key, found, nearest):
    problem = only(claiming({**BETTER, "where": where}))
    assert problem.key == f"expect[0:better].where.{key}"
    assert problem.found == found
    assert problem.nearest == nearest


def test_where_is_a_table_of_swept_keys():
    assert only(claiming({**BETTER, "where": 3})).key == "expect[0:better].where"
    twice = {"slip.yaw": 0.1, "slip": {"yaw": 0.1}}
    assert only(claiming({**BETTER, "where": twice})).found == "the key twice"
    nothing = claiming({**BETTER, "where": {"slip.yaw": 0.1}}, document=PAPER)
    assert "nothing is swept" in only(nothing).allowed


@pytest.mark.parametrize("key", ["expect.0.factor", "expect", "expect.factor"])
def test_a_claim_cannot_be_swept(key):
    problem = only({**claiming(BETTER), "sweep": {key: [1.0, 2.0]}})
    assert problem.key == f"sweep.{key}"
    assert "claim" in problem.found


NUMBERS = st.floats(-1e6, 1e6)
LISTED = st.lists(NUMBERS, min_size=1, max_size=4, unique=True).map(
    lambda values: tuple(v + 0.0 for v in values)
)
BANDS = st.tuples(NUMBERS, NUMBERS).map(lambda ends: Band(min(ends) + 0.0, max(ends) + 0.0))
OPEN = st.one_of(BANDS, NUMBERS.map(lambda end: Band(end, None)), NUMBERS.map(lambda end: Band(None, end)))


@given(st.dictionaries(st.from_regex(r"[a-z_]+(\.[a-z0-9_]+)?", fullmatch=True), st.one_of(LISTED, OPEN)))
def test_conditions_read_back_as_they_were_written(values):
    conditions = tuple(Condition(key, value) for key, value in values.items())
    again, problems = read_where(where_table(conditions))
    if not problems:
        assert again == conditions
    else:  # a key and a table of the same name, or a key called from or to
        assert any(key.split(".")[-1] in ("from", "to") for key in values)


@given(LISTED, NUMBERS)
def test_a_condition_holds_on_its_values_and_its_ends(values, other):
    listed = Condition("key", values)
    assert all(map(listed.holds, values))
    band = Condition("key", Band(min(values), max(values)))
    assert all(map(band.holds, values))
    far = max(map(abs, values)) * 1.01 + 1.0
    assert not band.holds(far)
    assert not listed.holds(far)
    assert not band.holds(-far)
    assert band.holds(other) == (min(values) <= other <= max(values)) or any(
        abs(other - value) <= 1e-9 * max(abs(other), abs(value)) for value in values
    )


def test_swept_values_are_met_despite_rounding():
    assert Condition("k", (0.3,)).holds(0.1 + 0.2)
    assert Condition("k", Band(0.1, 0.3)).holds(0.1 + 0.2)
    assert not Condition("k", Band(0.1, 0.3)).holds(0.3001)


def test_the_page_about_claims_names_every_kind_with_its_keys_and_defaults():
    page = (Path(__file__).parents[2] / "docs" / "claims.md").read_text(encoding="utf-8")
    rows = {line.split("`")[1]: line for line in page.splitlines() if line.startswith("| `")}
    rows = {kind: row for kind, row in rows.items() if kind != "kind"}
    assert set(rows) == set(KINDS["expect"])
    for kind, table in KINDS["expect"].items():
        for key, field in table.model_fields.items():
            if key in ("where", "only_where_guaranteed"):
                assert f"\n* `{key}`: " in page
            elif key != "kind":
                assert f"`{key}`" in rows[kind]
            if isinstance(field.default, str) and key != "kind":
                assert f"(`{field.default}`)" in rows[kind]
    blocks = re.findall(r"```toml\n(.*?)```", page, flags=re.S)
    claim = tomllib.loads(blocks[0])["expect"][0] | {"controller": "robust"}
    assert refused(claiming(claim)) == []
    restricted = {**BETTER, **tomllib.loads(blocks[1])}
    frictions = {"ground.friction": [0.1, 0.2], "seed": [1, 2, 3]}
    document = {**changed(EIGHT, {"controller": PAPER["controller"]}), "sweep": frictions}
    assert refused(claiming(restricted, document=document)) == []
