"""The JSON Schema of scenario files, for editors: from the models and the table of faults.

It says less than `check` does: a fault as text is a text to it.
"""

from __future__ import annotations

from typing import Any

from bt_mission.language.schema import DIALECT
from bt_mission.scenarios.faults import FAULTS
from bt_mission.scenarios.faults.kind import FaultKind
from bt_mission.scenarios.faults.parameters import Parameter
from bt_mission.scenarios.faults.world import OBSTACLES
from bt_mission.scenarios.file import FAULT_MARK, OBSTACLE_MARK, ScenarioFile

_TEXT = {"type": "string", "pattern": "^(at|after|when) .*: *[a-z_]+"}


def scenario_schema() -> dict[str, Any]:
    """Return the schema of a scenario file."""
    schema: dict[str, Any] = ScenarioFile.model_json_schema()
    definitions = schema.pop("$defs", {})
    definitions |= {f"fault_{name}": _arguments(FAULTS[name]) for name in OBSTACLES}
    definitions["fault"] = {
        "description": "A text such as 'at 5.0: drop scan lasting 2'.",
        "anyOf": [_TEXT, _unquoted()],
    }
    definitions["obstacle"] = {
        "description": "A box, or a cylinder if it has a radius, in the world from the start.",
        "anyOf": [{"$ref": f"#/$defs/fault_{name}"} for name in OBSTACLES],
    }
    marked = _marked(schema)
    return {"$schema": DIALECT, **marked, "title": "bt-mission scenario", "$defs": definitions}


def _unquoted() -> dict[str, Any]:
    """Return a fault without quotes, as other readers of YAML take it: a key and a text."""
    return {
        "type": "object",
        "patternProperties": {"^(at|after|when) ": {"type": "string"}},
        "additionalProperties": False,
        "minProperties": 1,
        "maxProperties": 1,
    }


def _arguments(kind: FaultKind) -> dict[str, Any]:
    schema: dict[str, Any] = {
        "type": "object",
        "description": kind.text,
        "properties": {name: _argument(parameter) for name, parameter in kind.optional.items()},
        "additionalProperties": kind.takes_fields,
    }
    required = [parameter.name for parameter in kind.parameters.values() if parameter.is_required]
    return {**schema, "required": required} if required else schema


def _argument(parameter: Parameter) -> dict[str, Any]:
    number: dict[str, Any] = (
        {"type": ["number", "string"]} if parameter.unit else {"type": "number"}
    )
    forms: dict[str, dict[str, Any]] = {
        "number": number,
        "integer": {"type": "integer"},
        "flag": {"type": "boolean"},
        "text": {"enum": list(parameter.choices)} if parameter.choices else {"type": "string"},
        "numbers": {"type": "array", "items": number, "minItems": 2},
        "anything": {},
    }
    schema = {"type": "array"} if parameter.repeats else forms[parameter.form]
    text = " ".join(
        filter(None, (parameter.text, f"In {parameter.unit}." if parameter.unit else ""))
    )
    return {**schema, "description": text} if text else schema


def _marked(part: Any) -> Any:
    """Return the same with the places of faults and obstacles referring to their definitions."""
    match part:
        case dict():
            for mark, name in ((FAULT_MARK, "fault"), (OBSTACLE_MARK, "obstacle")):
                if part.get(mark):
                    return {"type": "array", "items": {"$ref": f"#/$defs/{name}"}}
            linked = {key: _marked(value) for key, value in part.items()}
            if isinstance(linked.get("title"), str) and "properties" not in linked:
                del linked["title"]
            return linked
        case list():
            return [_marked(value) for value in part]
    return part
