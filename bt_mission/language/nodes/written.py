"""What a person writes in a mission file, as pydantic models: one for the file, one a kind of node.

A node is a mapping; the key that names its kind is a field of the model, and its modifiers are
the others. Children stay unread here (`Any`): the loader takes them one by one, so that every
fault of every node is found.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import (
    BeforeValidator,
    Field,
    PlainValidator,
    WithJsonSchema,
    create_model,
)

from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes import fields as rules
from bt_mission.language.nodes.base import (
    NUMBER_SCHEMA,
    OBJECT_SCHEMA,
    TEXT_SCHEMA,
    ActionNameField,
    Child,
    Children,
    Computed,
    Condition,
    Elements,
    FeedbackCondition,
    FixedLimit,
    Goal,
    Limit,
    Line,
    Message,
    NodeModel,
    ResultField,
    Seconds,
    Times,
    TreeName,
    Variable,
    Weight,
    Written,
)


class SequenceNode(NodeModel):
    """Children one after another, until one fails."""

    sequence: Children
    memory: bool = True


class FallbackNode(NodeModel):
    """Children one after another, until one succeeds."""

    fallback: Children
    memory: bool = True


class ParallelNode(NodeModel):
    """Children all at once."""

    parallel: Children
    succeed_when: Literal["all", "any"] | Annotated[list[Line], Field(min_length=1)] = "all"
    fail_when: Literal["any", "impossible"] = "any"
    rest: Literal["halt", "finish"] = "halt"


class ChooseNode(NodeModel):
    """One of the children, drawn by lot each time."""

    choose: Children
    weights: list[Weight] = []


class RepeatSettings(Written):
    """How often."""

    count: Times


class RepeatNode(NodeModel):
    """A node, several times."""

    repeat: RepeatSettings
    do: Child


class RetrySettings(Written):
    """How often at most, and how long to pause between (s)."""

    attempts: Times
    pause: Seconds = 0.0


class RetryNode(NodeModel):
    """A node, until it succeeds."""

    retry: RetrySettings
    do: Child


class TimeoutNode(NodeModel):
    """A node, for some seconds at most."""

    timeout: Annotated[Any, PlainValidator(rules.LIMIT.parse), NUMBER_SCHEMA]
    do: Child


class InvertNode(NodeModel):
    """A node, its success for failure and its failure for success."""

    invert: Child


class ForceNode(NodeModel):
    """A node whose end counts as success, or as failure."""

    force: Literal["success", "failure"]
    do: Child


class GuardNode(NodeModel):
    """A node, as long as a condition holds."""

    guard: Condition
    do: Child


class _WhenNode(NodeModel):
    """A node if a condition holds, and another one if not."""

    when: Condition
    do: Child


# `else` cannot be written as the name of a field.
WhenNode = create_model(
    "WhenNode", __base__=_WhenNode, __doc__=_WhenNode.__doc__, **{"else": (Child, None)}
)  # type: ignore[call-overload]


class ForEachNode(NodeModel):
    """A node, once for each element of a list."""

    for_each: Annotated[dict[Variable, Elements], BeforeValidator(rules.one_name), OBJECT_SCHEMA]
    do: Child


class CheckNode(NodeModel):
    """Success where a condition holds, else failure."""

    check: Condition


class SetNode(NodeModel):
    """New values for variables."""

    set: Annotated[dict[Variable, Computed], Field(min_length=1)]


class WaitNode(NodeModel):
    """Nothing, for some seconds."""

    wait: Seconds


class LogNode(NodeModel):
    """A line in the log."""

    log: Message


class GoalNode(NodeModel):
    """The modifiers of every action. Times are seconds of ROS time."""

    timeout: Limit = None
    cancel_when: FeedbackCondition = None
    on_cancel: Literal["success", "failure"] = "failure"
    outputs: dict[ResultField, Variable] = {}
    server_timeout: FixedLimit | None = None
    answer_timeout: FixedLimit | None = None
    silence_timeout: Limit = None
    cancel_timeout: FixedLimit | None = None


class ActionSettings(Written):
    """An action by its ROS name and type, and a goal for it."""

    name: ActionNameField
    type: Annotated[str, PlainValidator(rules.action_type), TEXT_SCHEMA]
    goal: Goal = {}


class ActionNode(GoalNode):
    """A goal for any action."""

    action: ActionSettings


class ServiceSettings(Written):
    """A service by its ROS name and type, and a request for it."""

    name: Annotated[str, PlainValidator(rules.service_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(rules.service_type), TEXT_SCHEMA]
    request: Goal = {}


class ServiceNode(NodeModel):
    """A call of any service. Times are seconds of ROS time."""

    service: ServiceSettings
    timeout: Limit = 5.0
    outputs: dict[ResultField, Variable] = {}
    server_timeout: FixedLimit = 5.0


class WaitForSettings(Written):
    """A topic by its ROS name and type, and what a message of it must meet."""

    topic: Annotated[str, PlainValidator(rules.topic_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(rules.message_type), TEXT_SCHEMA]
    until: Annotated[Any, PlainValidator(rules.until), TEXT_SCHEMA]


class WaitForNode(NodeModel):
    """A pause until a message meets a condition."""

    wait_for: WaitForSettings
    timeout: Limit = None
    outputs: dict[ResultField, Variable] = {}


class PublishSettings(Written):
    """A topic by its ROS name and type, and a message for it."""

    topic: Annotated[str, PlainValidator(rules.topic_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(rules.message_type), TEXT_SCHEMA]
    message: Goal = {}


class PublishNode(NodeModel):
    """A message on any topic. Times are seconds of ROS time."""

    publish: PublishSettings
    readers: Annotated[int, Field(ge=0, le=1000)] = 1
    server_timeout: FixedLimit = 5.0


class TreeSettings(Written):
    """A named tree, and values for its inputs."""

    name: TreeName
    inputs: dict[Variable, Computed] = {}


class TreeNode(NodeModel):
    """A tree that has a name."""

    tree: Annotated[
        TreeSettings,
        BeforeValidator(rules.tree_use),
        WithJsonSchema({"type": ["string", "object"]}),
    ]
    outputs: dict[Variable, Variable] = {}


class PythonNode(NodeModel):
    """A behaviour written in Python."""

    python: Annotated[str, PlainValidator(rules.python_target), TEXT_SCHEMA]
    inputs: dict[Variable, Computed] = {}
    outputs: dict[Variable, Variable] = {}


def _short_node(name: str) -> type[GoalNode]:
    title = "".join(word.capitalize() for word in name.split("_")) + "Node"
    fields: dict[str, Any] = {name: (Goal, ...)}
    return create_model(title, __base__=GoalNode, __doc__=f"A goal of {name}.", **fields)


KINDS: dict[str, type[NodeModel]] = {
    "sequence": SequenceNode,
    "fallback": FallbackNode,
    "parallel": ParallelNode,
    "repeat": RepeatNode,
    "retry": RetryNode,
    "choose": ChooseNode,
    "timeout": TimeoutNode,
    "invert": InvertNode,
    "force": ForceNode,
    "guard": GuardNode,
    "when": WhenNode,
    "for_each": ForEachNode,
    "check": CheckNode,
    "set": SetNode,
    "wait": WaitNode,
    "log": LogNode,
    "action": ActionNode,
    "service": ServiceNode,
    "wait_for": WaitForNode,
    "publish": PublishNode,
    "tree": TreeNode,
    "python": PythonNode,
}
KINDS |= {name: _short_node(name) for name in ACTION_NAMES if name not in KINDS}
"""Every kind of node, and the model of what stands in it."""
