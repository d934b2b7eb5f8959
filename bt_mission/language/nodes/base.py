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

from bt_mission.language.nodes import fields

NUMBER_SCHEMA = WithJsonSchema({"type": ["number", "string"]})
TEXT_SCHEMA = WithJsonSchema({"type": "string"})
OBJECT_SCHEMA = WithJsonSchema({"type": "object", "minProperties": 1, "maxProperties": 1})
NODE_MARK, TREE_MARK = "x-node", "x-tree"
"""Stand in a schema where a node or the definition of a tree does (`schema.py`)."""

NODE_SCHEMA = WithJsonSchema({NODE_MARK: True})

Child = Annotated[Any, NODE_SCHEMA]
Children = Annotated[list[Child], Field(min_length=1)]
Times = Annotated[Any, PlainValidator(fields.TIMES.parse), NUMBER_SCHEMA]
Seconds = Annotated[Any, PlainValidator(fields.SECONDS.parse), NUMBER_SCHEMA]
Limit = Annotated[Any, PlainValidator(fields.LIMIT.parse), NUMBER_SCHEMA]
FixedLimit = Annotated[
    float, PlainValidator(fields.LIMIT.parse_constant), WithJsonSchema({"type": "number"})
]
Weight = Annotated[
    float, PlainValidator(fields.WEIGHT.parse_constant), WithJsonSchema({"type": "number"})
]
FeedbackCondition = Annotated[Any, PlainValidator(fields.condition), TEXT_SCHEMA]
Condition = Annotated[
    Any, PlainValidator(fields.question), WithJsonSchema({"type": ["string", "boolean"]})
]
Computed = Annotated[Any, PlainValidator(fields.computed), WithJsonSchema({})]
Elements = Annotated[
    Any, PlainValidator(fields.elements), WithJsonSchema({"type": ["array", "string"]})
]
Message = Annotated[Any, PlainValidator(fields.message), TEXT_SCHEMA]
ActionNameField = Annotated[str, PlainValidator(fields.action_name), TEXT_SCHEMA]
Variable = Annotated[str, PlainValidator(fields.variable), TEXT_SCHEMA]
TreeName = Annotated[str, PlainValidator(fields.tree_name), TEXT_SCHEMA]
ResultField = Annotated[str, PlainValidator(fields.result_field), TEXT_SCHEMA]
InputValue = Annotated[Any, PlainValidator(fields.plain), WithJsonSchema({})]
GoalPart = Annotated[Any, PlainValidator(fields.goal_part), WithJsonSchema({})]
Goal = dict[str, GoalPart]
Trees = Annotated[Any, WithJsonSchema({TREE_MARK: True})]
Line = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(fields.printable)]


class Written(BaseModel):
    """What all models of the mission file share: strict, frozen, no unknown keys."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class NodeModel(Written):
    """A node's modifiers that every kind takes."""

    name: Line = ""
