"""What the models of a mission file are made of: values, each with its rule, and the base."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PlainValidator,
    WithJsonSchema,
)

from bt_mission.mission import rules

NUMBER_SCHEMA = WithJsonSchema({"type": ["number", "string"]})
TEXT_SCHEMA = WithJsonSchema({"type": "string"})
OBJECT_SCHEMA = WithJsonSchema({"type": "object", "minProperties": 1, "maxProperties": 1})
NODE_MARK, TREE_MARK = "x-node", "x-tree"
"""Stand in a schema where a node or the definition of a tree does (`schema.py`)."""

NODE_SCHEMA = WithJsonSchema({NODE_MARK: True})

Child = Annotated[Any, NODE_SCHEMA]
Children = Annotated[list[Child], Field(min_length=1)]
Times = Annotated[Any, PlainValidator(rules.TIMES.parse), NUMBER_SCHEMA]
Seconds = Annotated[Any, PlainValidator(rules.SECONDS.parse), NUMBER_SCHEMA]
Limit = Annotated[Any, PlainValidator(rules.LIMIT.parse), NUMBER_SCHEMA]
FixedLimit = Annotated[
    float, PlainValidator(rules.LIMIT.parse_constant), WithJsonSchema({"type": "number"})
]
Weight = Annotated[
    float, PlainValidator(rules.WEIGHT.parse_constant), WithJsonSchema({"type": "number"})
]
FeedbackCondition = Annotated[Any, PlainValidator(rules.condition), TEXT_SCHEMA]
Condition = Annotated[
    Any, PlainValidator(rules.question), WithJsonSchema({"type": ["string", "boolean"]})
]
Computed = Annotated[Any, PlainValidator(rules.computed), WithJsonSchema({})]
Elements = Annotated[
    Any, PlainValidator(rules.elements), WithJsonSchema({"type": ["array", "string"]})
]
Message = Annotated[Any, PlainValidator(rules.message), TEXT_SCHEMA]
ActionName = Annotated[str, PlainValidator(rules.action_name), TEXT_SCHEMA]
Variable = Annotated[str, PlainValidator(rules.variable), TEXT_SCHEMA]
TreeName = Annotated[str, PlainValidator(rules.tree_name), TEXT_SCHEMA]
ResultField = Annotated[str, PlainValidator(rules.result_field), TEXT_SCHEMA]
InputValue = Annotated[Any, PlainValidator(rules.plain), WithJsonSchema({})]
GoalPart = Annotated[Any, PlainValidator(rules.goal_part), WithJsonSchema({})]
Goal = dict[str, GoalPart]
Trees = Annotated[Any, WithJsonSchema({TREE_MARK: True})]
Line = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(rules.printable)]


class Written(BaseModel):
    """What all models of the mission file share: strict, frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Node(Written):
    """A node's modifiers that every kind takes."""

    name: Line = ""
