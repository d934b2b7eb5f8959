"""What agents read: the language, with examples, and what the robot of a site offers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from action_servers.core.action import action
from action_servers.core.limits import NumberLimit
from bt_mission.base import files
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.agents.site import Site
from bt_mission.commands.edit.vocabulary import kinds
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.requirements.schema import mission_schema
from bt_mission.robots.model import RobotModel

EXAMPLES = ("square", "explore", "patrol")
PAGES = (
    *("mission-language", "nodes", "expressions", "modifiers", "requirements", "variables"),
    *("actions", "glossary"),
)
OVERVIEW = """\
A mission is one YAML text: `mission: NAME`, `inputs:`, `requirements:` and `tree:`, a behaviour
tree. Leaves are goals of actions (`turn: {angle: 90}`, with `timeout:` in seconds); `sequence`,
`fallback`, `parallel`, `retry`, `repeat` and others combine them. Read `nodes` and `examples`, then
call `site` for the actions, zones and requirements of this robot, `check` until a text is valid,
`propose` it, `prove` and `simulate` it. A person approves it outside of this connection; then
`drive` runs it once. `stop` always works."""


def _example(name: str) -> str:
    return files.find("missions", name).read_text(encoding="utf-8")


def _page(name: str) -> str:
    folder = files.docs_folder()
    if folder is None:
        raise BtMissionError("the documentation is not installed", code="BT-101")
    return (folder / "reference" / f"{name}.md").read_text(encoding="utf-8")


TEXTS: Mapping[str, Callable[[], str]] = {
    "overview": lambda: OVERVIEW,
    "schema": lambda: json.dumps(mission_schema()),
    "examples": lambda: "\n---\n".join(map(_example, EXAMPLES)),
    **{name: partial(_page, name) for name in PAGES},
}
"""Texts on the language, by their names."""


def limits_of(name: str, robot: RobotModel) -> dict[str, str]:
    """Return what the server of an action accepts for a robot, by the fields of its goals."""
    limits = action(name).limits_with(robot)
    return {limit.field: limit.words for limit in limits if isinstance(limit, NumberLimit)}


def capabilities_of(site: Site) -> dict[str, Any]:
    """Return what missions of a site may use, and what they must hold."""
    known = kinds()
    limits = {name: limits_of(name, site.robot) for name in site.actions}
    of_name = {short.name: kind for kind, short in ACTION_NAMES.items()}
    return {
        "site": site.name,
        "description": site.written.description,
        "robot": site.written.robot,
        "world": {
            "name": site.world.name,
            "size_m": list(site.world.size),
            "zones": [zone.model_dump(mode="json", exclude_none=True) for zone in site.world.zones],
        },
        "actions": [
            {
                "name": name,
                "node": of_name[name],
                "example": known[of_name[name]].template,
                "goal": [
                    {
                        "field": field.keys[-1],
                        "unit": field.unit,
                        "accepts": limits[name].get(field.keys[-1], field.words),
                        "about": field.text,
                    }
                    for field in known[of_name[name]].fields
                    if field.keys[0] == of_name[name]
                ],
                "feedback": list(known[of_name[name]].feedback),
                "result": list(known[of_name[name]].results),
            }
            for name in site.actions
            if name in of_name and of_name[name] in known
        ],
        "topics": list(site.written.topics),
        "requirements": {each.name: each.text for each in site.requirements},
        "only_simulated": sorted(site.only_simulated),
        "evidence": {
            "seeds": f"0 to {site.written.seeds - 1}, and that of the drive",
            "faults": site.plans,
            "nature": site.written.nature,
            "limit_s": site.written.limit,
        },
        "permit": {"expires_s": site.written.expires, "uses": 1},
    }
