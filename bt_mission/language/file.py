"""The form of files: the head of a mission, the definition of a tree, a library."""

from typing import Annotated, Any, Literal

from pydantic import Field, SkipValidation

from bt_mission.base.nature_field import WrittenNature
from bt_mission.language.follow import FollowSettings
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import Trees, Written, WrittenNode

Follows = Annotated[FollowSettings | list[FollowSettings], SkipValidation]
"""Variables that follow topics, not read yet: the reader takes them one by one."""


class GoalLimits(Written):
    """Limits of goals, for a mission or for one server. Times are seconds of ROS time."""

    timeout: fields.FixedLimit | None = None
    feedback_timeout: fields.FixedLimit | None = None
    server_timeout: fields.FixedLimit | None = None
    acceptance_timeout: fields.FixedLimit | None = None
    cancel_timeout: fields.FixedLimit | None = None


class MissionFile(Written):
    """The whole file."""

    mission: fields.Line
    description: str = ""
    world: fields.Line = ""
    robot: fields.Line = "waffle"
    seed: Annotated[int, Field(ge=0, lt=2**63)] = 0
    map: Literal["known", "unknown"] = "known"
    observe: fields.Observe = 0.0
    nature: WrittenNature | None = None
    include: list[fields.Line] = []
    nodes: fields.NodeFactories = []
    inputs: dict[fields.Variable, fields.InputValue] = {}
    places: dict[fields.Line, fields.Place] = {}
    follow: Follows = []
    limits: GoalLimits = GoalLimits()
    servers: dict[fields.ActionNameField, GoalLimits] = {}
    requirements: Any = {}
    """Not read yet: see `loader.MissionLoader`."""
    trees: dict[fields.TreeName, Trees] = {}
    tree: WrittenNode


TypeWord = Literal["number", "integer", "bool", "text", "list"]


class TreeDefinition(Written):
    """A tree with a name: what it takes, what it gives, and what it does."""

    description: str = ""
    needs: dict[fields.Variable, TypeWord] = {}
    inputs: dict[fields.Variable, fields.InputValue] = {}
    follow: Follows = []
    outputs: dict[fields.Variable, TypeWord] = {}
    do: WrittenNode


class Library(Written):
    """A file with trees for other files."""

    include: list[fields.Line] = []
    trees: dict[fields.TreeName, Trees] = {}
