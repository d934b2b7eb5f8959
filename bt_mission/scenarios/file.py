"""The form of a scenario file."""

import re
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    Field,
    PlainValidator,
    ValidationInfo,
    WithJsonSchema,
    field_validator,
)

from bt_mission.base.diagnostics import describe
from bt_mission.base.nature_field import WrittenNature
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import Written
from bt_mission.requirements.language.written import Requirements
from bt_mission.scenarios.scenario import LIMIT_S
from bt_mission.scenarios.servers import WrittenServers


def _pattern(text: str) -> str:
    try:
        re.compile(text)
    except re.error as error:
        message = f"expected a regular expression: {error.msg}"
        raise fields.refusal(message, offset=error.pos or 0) from None
    return text


def _name_or_mapping(value: Any) -> Any:
    if not isinstance(value, dict | str) or not value:
        raise fields.refusal(f"expected a name, a path or a mapping, got {describe(value)}")
    return value


NAMED = WithJsonSchema({"type": ["string", "object"]})
NameOrMapping = Annotated[Any, PlainValidator(_name_or_mapping), NAMED]
Time = Annotated[float, fields.in_unit("s"), Field(ge=0)]
Coordinate = Annotated[float, fields.in_unit("m"), Field(ge=-1000, le=1000)]
Angle = Annotated[float, fields.in_unit("deg"), Field(ge=-1000, le=1000)]
Count = Annotated[int, Field(ge=0)]

FAULT_MARK, OBSTACLE_MARK = "x-fault", "x-obstacle"
"""Placeholders in a schema for a fault and an obstacle (`schema.py`)."""
WrittenFaults = Annotated[list[Any], WithJsonSchema({FAULT_MARK: True})]
WrittenObstacles = Annotated[list[Any], WithJsonSchema({OBSTACLE_MARK: True})]


class StartForm(Written):
    """The start of the robot, m and degrees in the map."""

    x: Coordinate = 0.0
    y: Coordinate = 0.0
    yaw: Angle = 0.0


class ExpectForm(Written):
    """The expected result. Default: success, and no violated requirement."""

    outcome: Literal["success", "failure", "interrupted", "any"] = "success"
    reason: Annotated[fields.Line | None, AfterValidator(lambda text: text and _pattern(text))] = (
        None
    )
    failed: fields.Line | None = None
    after: Time | None = None
    before: Time | None = None
    violated: list[fields.Line] = []
    orphaned_goals: Count | Literal["any"] = 0
    collisions: Count | None = None

    @field_validator("failed")
    @classmethod
    def _fails(cls, failed: str | None, info: ValidationInfo) -> str | None:
        if failed and info.data.get("outcome") == "success":
            message = "no node fails where the mission succeeds, which is what is expected"
            raise fields.refusal(message, "add 'outcome: failure' or 'outcome: any'")
        return failed

    @field_validator("before")
    @classmethod
    def _in_order(cls, before: float | None, info: ValidationInfo) -> float | None:
        after = info.data.get("after")
        if before is not None and after is not None and before < after:
            message = f"no end is both before {before:g} s and after {after:g} s"
            raise fields.refusal(message, "exchange 'after' and 'before'")
        return before


class ScenarioFile(Written):
    """The whole file."""

    scenario: fields.Line
    description: str = ""
    mission: NameOrMapping
    world: NameOrMapping | None = None
    robot: fields.Line | None = None
    simulator: fields.Factory | None = None
    nodes: fields.NodeFactories = []
    seed: Annotated[int, Field(ge=0, lt=2**63)] | None = None
    inputs: dict[fields.Variable, fields.InputValue] = {}
    start: StartForm | None = None
    nature: WrittenNature | None = None
    obstacles: WrittenObstacles = []
    faults: WrittenFaults = []
    servers: WrittenServers = {}
    requirements: Requirements = {}
    observe: fields.Observe | None = None
    limit: Annotated[float, fields.in_unit("s"), Field(gt=0, le=100_000)] = LIMIT_S
    expect: ExpectForm = ExpectForm()
