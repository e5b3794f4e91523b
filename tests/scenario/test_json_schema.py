"""The JSON Schema says what the reader does."""

import json
import re
import tomllib
from collections.abc import Callable
from typing import Any

import pytest

from slipctl import shipped
from slipctl.scenario import json_schema, load
from tests.scenario.documents import EIGHT, EXPERIMENT, PAPER, SCALED, TORQUE, changed, leaves, refused

SCHEMA = json_schema()
UNITLESS = {"name", "description", "seed", "model", "drive", "kind", "label", "uncertainty", "at_rest"}
UNITLESS |= {"left_wheel", "right_wheel", "keep_contacts"}
UNITLESS |= {"than", "metric", "limit", "status", "where", "only_where_guaranteed"}
UNITLESS |= {
    "believes",
    "time_scaled",
    "time_scaling",
    "compensate_wheels",
    "file",
    "patch",
    "change",
    "dry",
    "terrain",
}
UNITLESS |= {"pose", "velocity", "acceleration", "start", "goal", *SCHEMA["properties"]} - {
    "tick",
    "duration",
}


def is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def accepts(schema: dict[str, Any], value: Any) -> bool:
    """Judge a value by the words of JSON Schema that the schema uses."""
    if "$ref" in schema:
        return accepts(SCHEMA["definitions"][schema["$ref"].rpartition("/")[2]], value)
    types: dict[str, Any] = {
        "object": dict,
        "array": list,
        "string": str,
        "number": (int, float),
        "integer": int,
        "boolean": bool,
    }
    number = is_number(value)
    checks: dict[str, Callable[[Any], bool]] = {
        "allOf": lambda part: all(accepts(entry, value) for entry in part),
        "anyOf": lambda part: any(accepts(entry, value) for entry in part),
        "oneOf": lambda part: sum(accepts(entry, value) for entry in part) == 1,
        "type": lambda part: isinstance(value, types[part]) and (part not in ("number", "integer") or number),
        "const": lambda part: value == part,
        "enum": lambda part: value in part,
        "pattern": lambda part: re.search(part, value) is not None,
        "minLength": lambda part: len(value) >= part,
        "minItems": lambda part: len(value) >= part,
        "uniqueItems": lambda part: len(set(value)) == len(value),
        "items": lambda part: all(accepts(part, entry) for entry in value),
        "required": lambda part: all(key in value for key in part),
        "minimum": lambda part: value >= part,
        "maximum": lambda part: value <= part,
        "exclusiveMinimum": lambda part: value > part,
        "exclusiveMaximum": lambda part: value < part,
        "properties": lambda part: all(accepts(part[key], value[key]) for key in value if key in part),
        "additionalProperties": lambda part: all(
            part and accepts(part, entry)
            for key, entry in value.items()
            if key not in schema.get("properties", {})
        ),
    }
    notes = {"description", "default", "unit", "title", "$schema", "definitions"}
    assert set(schema) <= set(checks) | notes, set(schema) - set(checks)
    if "type" in schema and not checks["type"](schema["type"]):
        return False
    return all(check(schema[word]) for word, check in checks.items() if word in schema)


@pytest.mark.parametrize("name", shipped.scenario_names())
def test_shipped_scenarios_are_valid_by_the_schema(name):
    assert accepts(SCHEMA, tomllib.loads(shipped.scenario_path(name).read_text()))


@pytest.mark.parametrize("document", [EIGHT, PAPER, TORQUE, EXPERIMENT, SCALED])
def test_documents_are_valid_by_the_schema(document):
    assert accepts(SCHEMA, document)


@pytest.mark.parametrize(
    "changes",
    [
        {"tik": 1},
        {"tick": "0.01"},
        {"tick": 0},
        {"seed": 1.5},
        {"plant.kind": "mujocco"},
        {"robot.drive": "wheel_power"},
        {"ground.friction": -1.0},
        {"ground.film": 0},
        {"reference.radius": 1.0},
        {"reference.speed": None},
        {"controller": []},
        {"controller.0.label": "A B"},
        {"controller.0.pole": 1.0},
        {"start.at_rest": 1},
        {"sensing.pose": "odometry"},
        {"sensing.position_noise": -0.1},
        {"controller.0.believes": {"radius": 0.1}},
        {"sweep": {"ground.friction": []}},
        {"sweep": {"ground.friction": {"from": 1, "to": 2, "count": 1}}},
    ],
)
def test_what_the_reader_refuses_in_one_key_the_schema_refuses_too(changes):
    assert accepts(SCHEMA, EIGHT)
    assert accepts(SCHEMA, PAPER)
    wrong = changed(EIGHT, changes)
    assert refused(wrong)
    assert not accepts(SCHEMA, wrong)


def test_every_key_has_a_description_and_every_quantity_its_unit():
    tables = [SCHEMA, *SCHEMA["definitions"].values()]
    keys = [(name, key) for table in tables for name, key in table["properties"].items()]
    assert all(key.get("description") for _, key in keys)
    assert {name for name, key in keys if "unit" not in key} <= UNITLESS
    assert all(f"[{key['unit']}]" in key["description"] for _, key in keys if "unit" in key)
    assert all(key["unit"] == "deg" for name, key in keys if name.endswith("_deg"))


def test_defaults_are_those_of_the_reader():
    assert (
        SCHEMA["definitions"]["Ground"]["properties"]["friction"]["default"]
        == load("belt").ground.friction
        == 0.8
    )
    defaults = [value for key, value in leaves(SCHEMA) if key.endswith("default")]
    assert defaults
    assert None not in defaults


def test_it_is_json_of_a_draft_that_toml_editors_know():
    assert json.loads(json.dumps(SCHEMA, allow_nan=False)) == SCHEMA
    assert SCHEMA["$schema"] == "http://json-schema.org/draft-07/schema#"
    references = re.findall(r'"\$ref": "([^"]*)"', json.dumps(SCHEMA))
    assert references
    assert {reference.rpartition("/")[2] for reference in references} <= set(SCHEMA["definitions"])
