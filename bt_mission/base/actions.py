"""What missions know of an action: its names, its type, what it needs, and a goal as an example.

The actions of the package `action_servers` are declared beside their maneuvers
(`action_servers.core.action`). Names and types are needed at every start, and the maneuvers import
NumPy, so this part of a declaration is read from the source and must be written as literals.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, TypeAlias

Need: TypeAlias = Literal["base", "scan", "odometry", "map", "camera", "arm", "gripper"]
PARTS: tuple[Need, ...] = ("arm", "gripper")
"""Needs that one goal at a time moves, and that not every robot has."""
MOVED: tuple[Need, ...] = ("base", *PARTS)
"""The parts of a robot, each moved by one goal at a time."""
REPLACED = "replaced by a new goal"
"""Begins the reason with which our servers abort a goal, before the goal that replaces it."""
GOALS_AT: Mapping[str, Need] = {f"goals_at_{part}": part for part in MOVED}
"""The signals that count the open goals of a part, one goal at a time of which moves it."""


@dataclass(frozen=True, kw_only=True)
class ActionName:
    """An action for missions.

    Args:
        name: Its ROS name, relative, so that it is in the namespace of the robot.
        type: The full name of its type.
        needs: The parts of the robot that it uses; "base" if it drives.
        short: The kind of node that sends its goals; "" for none, by default its name.
        example: A goal as it is written in a mission, the most important field first.
    """

    name: str
    type: str
    needs: tuple[Need, ...] = ("base",)
    short: str | None = None
    example: Mapping[str, Any] = field(default_factory=dict)

    @property
    def kind(self) -> str:
        """The kind of node that sends its goals; empty without one."""
        return self.name if self.short is None else self.short

    @property
    def moves_base(self) -> bool:
        """Whether it drives."""
        return "base" in self.needs

    @property
    def part(self) -> str:
        """The part that it moves besides the base; empty for none."""
        return next((need for need in self.needs if need in PARTS), "")

    @property
    def moves(self) -> str:
        """The base, or another part, which one goal at a time moves; empty for none."""
        return "base" if self.moves_base else self.part

    @property
    def needs_camera(self) -> bool:
        """Whether it needs a camera."""
        return "camera" in self.needs


@dataclass(frozen=True)
class DeclaredAction:
    """A declaration in a source file: its part for missions, and its place."""

    known: ActionName
    module: str
    attribute: str


PACKAGE = "action_servers"
"""The package whose folders have modules with declarations."""

_MARK = b"= Action(\n"
_DECLARATION = re.compile(r"^([A-Z][A-Z0-9_]*) = (Action\(\n.*?^\))", re.DOTALL | re.MULTILINE)
_FIELDS = frozenset(field.name for field in fields(ActionName))


@cache
def declared() -> Mapping[str, DeclaredAction]:
    """Return the actions of `PACKAGE`, by their ROS names, without importing a module."""
    spec = find_spec(PACKAGE)
    actions = {}
    for folder in (spec and spec.submodule_search_locations) or ():
        root = Path(folder)
        for path in sorted(root.glob("*/*.py")):
            source = path.read_bytes()
            text = source.decode() if _MARK in source else ""
            for attribute, call in _DECLARATION.findall(text):
                known = ActionName(**_literals(call))
                module = f"{PACKAGE}.{path.parent.name}.{path.stem}"
                actions[known.name] = DeclaredAction(known, module, attribute)
    return actions


def moved_part(action: str) -> str:
    """Return the part that an action moves, by its ROS name in any namespace; empty for none."""
    known = declared_as(action)
    return "" if known is None else known.known.moves


def goals_at(part: str, actions: Iterable[str]) -> int:
    """Return how many goals of these actions move a part of the robot."""
    return sum(moved_part(action) == part for action in actions)


def declared_as(action: str) -> DeclaredAction | None:
    """Return the declaration of an action by its ROS name in any namespace, or None."""
    parts = action.split("/")
    names = ("/".join(parts[-count:]) for count in (1, 2))
    return next((declared()[name] for name in names if name in declared()), None)


def _literals(call: str) -> dict[str, Any]:
    """Return the arguments of a declaration that are for missions."""
    expression: Any = ast.parse(call, mode="eval").body
    return {
        keyword.arg: ast.literal_eval(keyword.value)
        for keyword in expression.keywords
        if keyword.arg in _FIELDS
    }
