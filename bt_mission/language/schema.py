"""The JSON Schema of mission files, for editors: from the same models that read them.

It says less than `check` does: an expression is a text to it, and a goal any mapping.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import TypeAdapter

from bt_mission.language.file import MissionFile, TreeDefinition
from bt_mission.language.nodes.base import NODE_MARK, TREE_MARK
from bt_mission.language.nodes.registry import KINDS

DIALECT = "https://json-schema.org/draft/2020-12/schema"
_NODE = {"$ref": "#/$defs/node"}
_TREE = {"$ref": "#/$defs/tree_definition"}


def mission_schema(sections: Mapping[str, Any]) -> dict[str, Any]:
    """Return the schema of a mission file; nodes are described under `$defs`, a kind each.

    Args:
        sections: The types of the keys at its head that other packages read.
    """
    definitions: dict[str, Any] = {}
    for kind, model in KINDS.items():
        definitions[f"kind_{kind}"] = _schema(model.model_json_schema(), definitions)
    definitions["node"] = {
        "title": "node",
        "description": "A node has exactly one kind; every other key is a modifier of it.",
        "oneOf": [{"$ref": f"#/$defs/kind_{kind}"} for kind in KINDS],
    }
    definitions["tree_definition"] = _schema(TreeDefinition.model_json_schema(), definitions)
    whole = _schema(MissionFile.model_json_schema(), definitions)
    for key, section in sections.items():
        whole["properties"][key] |= _schema(TypeAdapter(section).json_schema(), definitions)
    return {"$schema": DIALECT, **whole, "title": "bt-mission", "$defs": definitions}


def _schema(whole: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """The schema of one model; what it is made of goes to the definitions."""
    schema: dict[str, Any] = _linked(whole)
    definitions |= schema.pop("$defs", {})
    return schema


def _linked(part: Any) -> Any:
    """The same with the places of nodes and trees referring to their definitions."""
    match part:
        case dict():
            if part.get(NODE_MARK):
                return _NODE
            if part.get(TREE_MARK):
                return _TREE
            linked = {key: _linked(value) for key, value in part.items()}
            # Titles made of field names only repeat what stands beside them.
            if isinstance(linked.get("title"), str) and "properties" not in linked:
                del linked["title"]
            return linked
        case list():
            return [_linked(value) for value in part]
    return part
