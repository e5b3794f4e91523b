"""JSON Schema of scenario files, for editors (Even Better TOML and others built on taplo)."""

from typing import Any

from slipctl.scenario.model import Scenario


def json_schema() -> dict[str, Any]:
    """Write the JSON Schema (draft 7, which TOML editors know) of scenario files.

    It holds every key with its description, unit, default and limits. Rules between keys are not in it;
    `load` checks those.
    """
    schema = Scenario.model_json_schema(by_alias=True, ref_template="#/definitions/{model}")
    schema["definitions"] = schema.pop("$defs")
    schema = _for_draft_7(schema)
    schema["title"] = "slipctl scenario"
    schema["description"] = "A scenario of slipctl: what is simulated, followed and compared. SI and radians."
    return {"$schema": "http://json-schema.org/draft-07/schema#", **schema}


def _for_draft_7(node: Any) -> Any:
    """Adapt a schema to draft 7, which ignores what stands beside `$ref`.

    Generated titles only distract and go. So do `null` as a type and the defaults that stand for "none" or
    for a whole table, as they have no spelling in TOML, and the discriminator, a word of OpenAPI.
    """
    if isinstance(node, list):
        return [_for_draft_7(entry) for entry in node]
    if not isinstance(node, dict):
        return node
    result: dict[str, Any] = {}
    for key, value in node.items():
        if key in ("properties", "definitions"):
            result[key] = {name: _for_draft_7(entry) for name, entry in value.items()}
        elif key not in ("title", "discriminator"):
            result[key] = _for_draft_7(value)
    members = result.get("anyOf")
    if members is not None and {"type": "null"} in members:
        rest = [member for member in members if member != {"type": "null"}]
        del result["anyOf"]
        result = {**(rest[0] if len(rest) == 1 else {"anyOf": rest}), **result}
    unset = result.get("default") == 0.0 and "exclusiveMinimum" in result
    if unset or isinstance(result.get("default"), dict | list) or result.get("default", 0) in (None, ""):
        result.pop("default", None)
    reference = result.pop("$ref", None)
    if reference is not None:
        result = {"$ref": reference} if not result else {"allOf": [{"$ref": reference}], **result}
    return result
