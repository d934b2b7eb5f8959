#!/usr/bin/env python3
"""Write docs/reference/files.md: every key of each kind of file but missions.

The tables are taken from the models that read the files. A test compares the page with what this
gives; `make generated` writes it.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from bt_mission.fleets.file import fleet_schema
from bt_mission.scenarios.file import ScenarioFile
from bt_mission.sessions.file_checks import requirements_schema, robot_schema, world_schema
from bt_mission.sweeps.ranges import ranges_schema

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "files.md"

HEAD = """# Keys of files

Every key of worlds, robots, scenarios, fleets, files of requirements and of ranges. The keys of
missions are on the page of [the mission language](mission-language.md). This page is generated from
the models that read the files (`make generated`).

`bt-mission check FILE...` recognizes each kind by its content and checks it. `bt-mission schema
KIND` prints the JSON Schema of a kind, by which an editor with a YAML language server completes and
checks such files.
"""

KINDS: Mapping[str, tuple[str, Any]] = {
    "world": ("Worlds", world_schema),
    "robot": ("Robots", robot_schema),
    "scenario": ("Scenarios", ScenarioFile.model_json_schema),
    "fleet": ("Fleets", fleet_schema),
    "requirements": ("Requirements", requirements_schema),
    "ranges": ("Ranges", ranges_schema),
}
"""The kinds of file: how each is called, and what gives its schema."""


def page() -> str:
    """Return the whole page."""
    parts = [HEAD]
    seen: set[str] = set()
    for kind, (title, schema) in KINDS.items():
        parts.append(f"## {title}\n\n`bt-mission schema {kind}`\n")
        parts += _tables(schema(), seen)
    return "\n".join(parts)


def _tables(schema: Mapping[str, Any], seen: set[str]) -> Iterator[str]:
    """Yield a table for a file, and one for each part of it that has none yet."""
    definitions = schema.get("$defs", {})
    yield _table(schema, definitions)
    for name, part in definitions.items():
        if "properties" in part and name not in seen:
            seen.add(name)
            yield f"### {_words(name)}\n"
            yield _table(part, definitions)


def _table(part: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    text = " ".join(part.get("description", "").split())
    lines = [text, ""] if text else []
    lines += ["| key | value | default |", "|---|---|---|"]
    required = part.get("required", ())
    for key, value in part["properties"].items():
        default = "required" if key in required else _default(value)
        lines.append(f"| `{key}` | {_value(value, definitions)} | {default} |")
    return "\n".join(lines) + "\n"


def _value(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    """Return in words what may stand behind a key."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        part = definitions.get(name, {})
        return _link(name) if "properties" in part else _value(part, definitions)
    if "enum" in value or "const" in value:
        choices = value.get("enum", [value.get("const")])
        return ", ".join(f"`{one}`" for one in choices)
    several = value.get("anyOf") or value.get("oneOf")
    if several:
        words = (_value(one, definitions) for one in several if one.get("type") != "null")
        return " or ".join(dict.fromkeys(words))
    if "x-fault" in value or "x-obstacle" in value:
        return "a list: [scenarios](scenarios.md)"
    kind = value.get("type", "anything")
    if isinstance(kind, list):
        return " or ".join(_KINDS.get(one, one) for one in kind)
    if kind == "array":
        return _array(value, definitions)
    inner = value.get("additionalProperties")
    if kind == "object" and isinstance(inner, Mapping):
        return f"names, each with {_value(inner, definitions)}"
    return _KINDS.get(kind, kind) + _limits(value)


def _array(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    if "prefixItems" in value:
        return "[" + ", ".join(_value(one, definitions) for one in value["prefixItems"]) + "]"
    inner = value.get("items")
    return f"a list of {_value(inner, definitions)}" if inner else "a list"


def _limits(value: Mapping[str, Any]) -> str:
    words = {
        "minimum": "from {}",
        "exclusiveMinimum": "above {}",
        "maximum": "to {}",
        "exclusiveMaximum": "below {}",
        "maxLength": "at most {} characters",
    }
    found = [said.format(f"{value[key]:,.10g}") for key, said in words.items() if key in value]
    return f" {' '.join(found)}" if found else ""


def _default(value: Mapping[str, Any]) -> str:
    default = value.get("default")
    if default is None or default in ([], {}, ""):
        return "none"
    if isinstance(default, dict):
        return "see there"
    return f"`{json.dumps(default)}`"


def _link(name: str) -> str:
    words = _words(name)
    return f"[{words}](#{words.lower().replace(' ', '-')})"


def _words(name: str) -> str:
    """Return the name of a model in words: `FleetRobotForm` is a fleet robot."""
    short = name.removesuffix("Form").removesuffix("Model")
    words = "".join(f" {one.lower()}" if one.isupper() else one for one in short).strip()
    return words[:1].upper() + words[1:]


_KINDS = {
    "number": "number",
    "integer": "integer",
    "string": "string",
    "boolean": "`true` or `false`",
    "object": "mapping",
    "array": "list",
}


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
