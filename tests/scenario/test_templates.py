"""A new scenario is a valid, commented copy."""

import re
import tomllib

import pytest

from slipctl import shipped
from slipctl.scenario import ScenarioError, canonical, load, override, read, template
from tests.scenario.documents import refused


@pytest.mark.parametrize("like", shipped.scenario_names())
def test_a_template_means_what_it_was_made_from(like):
    scenario = read(tomllib.loads(template(like, "mine")))
    assert scenario.name == "mine"
    assert canonical(scenario) == canonical(load(like))


@pytest.mark.parametrize("like", shipped.scenario_names())
def test_its_commented_defaults_are_valid_and_change_nothing(like):
    text = re.sub(r"(?m)^# (?=\w+ = |\[)", "", template(like, "mine"))
    assert refused(tomllib.loads(text)) == []
    assert canonical(read(tomllib.loads(text))) == canonical(load(like))


def test_every_key_is_explained():
    text = template("wet-slope", "mine")
    assert "# speed_limit = 2.5  # Largest commanded forward speed [m/s]" in text
    assert re.search(r"(?m)^# creep_stiffness: Tyre creep", text)
    assert re.search(r'(?m)^uncertainty = "paper"  # .*: paper, independent, slip_ratio$', text)
    keys = [line for line in text.splitlines() if re.match(r"\w+ = ", line)]
    assert [line for line in keys if "  # " not in line] == [
        'name = "mine"',
        'description = "Table I path up a 3 degree slope, film of 100 N.s/m per wheel"',
    ]


def test_a_template_of_a_file(tmp_path):
    path = tmp_path / "first.toml"
    path.write_text(template("belt", "first"))
    scenario = read(tomllib.loads(template(str(path), "second")))
    assert override(scenario, {}) == override(load(path), {}).model_copy(update={"name": "second"})


def test_spans_stand_as_spans(tmp_path):
    path = tmp_path / "span.toml"
    span = '"slip.yaw" = { from = 0.1, to = 0.4, count = 3, scale = "log" }'
    path.write_text(f"{template('belt', 'span')}\n[sweep]\n{span}\n")
    assert span in template(str(path), "copy")


@pytest.mark.parametrize("name", ["a b", "", "../x", "a\n", "-x"])
def test_a_name_that_cannot_be_one(name):
    with pytest.raises(ScenarioError, match="letters, digits"):
        template("belt", name)


def test_a_scenario_that_does_not_exist():
    with pytest.raises(ScenarioError, match='did you mean "wet-slope"'):
        template("wet-slop", "mine")
