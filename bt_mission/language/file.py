"""What stands in whole files: the head of a mission, the definition of a tree, a library."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from bt_mission.language.nodes.base import Trees, Written, WrittenNode
from bt_mission.language.nodes.fields import (
    ActionNameField,
    FixedLimit,
    InputValue,
    Line,
    TreeName,
    Variable,
)


class GoalLimits(Written):
    """Limits of goals, for a mission or for one server. Times are seconds of ROS time."""

    timeout: FixedLimit | None = None
    feedback_timeout: FixedLimit | None = None
    server_timeout: FixedLimit | None = None
    acceptance_timeout: FixedLimit | None = None
    cancel_timeout: FixedLimit | None = None


class MissionFile(Written):
    """The whole file."""

    mission: Line
    description: str = ""
    world: Line = ""
    robot: Line = "waffle"
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    map: Literal["known", "unknown"] = "known"
    include: list[Line] = []
    inputs: dict[Variable, InputValue] = {}
    limits: GoalLimits = GoalLimits()
    servers: dict[ActionNameField, GoalLimits] = {}
    trees: dict[TreeName, Trees] = {}
    tree: WrittenNode


TypeWord = Literal["number", "integer", "bool", "text", "list"]


class TreeDefinition(Written):
    """A tree with a name: what it takes, what it gives, and what it does."""

    description: str = ""
    needs: dict[Variable, TypeWord] = {}
    inputs: dict[Variable, InputValue] = {}
    outputs: dict[Variable, TypeWord] = {}
    do: WrittenNode


class Library(Written):
    """A file with trees for other files."""

    include: list[Line] = []
    trees: dict[TreeName, Trees] = {}
