"""Goals of ROS 2 actions: of any action, and of those with a short name."""

from collections.abc import Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PlainValidator, create_model
from typing_extensions import override

from bt_mission.base.actions import ActionName
from bt_mission.language.action_names import ACTION_NAMES, BY_TYPE
from bt_mission.language.expressions.expression import Expression, Value
from bt_mission.language.nodes import base, fields
from bt_mission.language.nodes.interfaces import InterfaceNode


class GoalNode(InterfaceNode, base.OutputsNode):
    """The modifiers of every action. Times are seconds of ROS time."""

    # `timeout` bounds the whole goal, `feedback_timeout` the time without feedback. `cancel_when`
    # is asked on every feedback; the node then ends as `on_cancel` says. `outputs` takes fields
    # of the result, also of a goal that was cancelled or aborted, provided a result came. `uses`
    # says which parts of the robot the goal moves.
    kind: ClassVar[str] = "action"
    sign: ClassVar[base.Sign] = base.Sign("▶", ">", "action", base.Family.ACTION)
    interface: ClassVar[Literal["action", "service", "topic"]] = "action"
    condition_path: ClassVar[base.Path] = ("cancel_when",)

    timeout: fields.Limit = None
    cancel_when: fields.FeedbackCondition = None
    on_cancel: Literal["success", "failure"] = "failure"
    outputs: dict[fields.ResultField, fields.Variable] = {}
    server_timeout: fields.FixedLimit | None = None
    acceptance_timeout: fields.FixedLimit | None = None
    feedback_timeout: fields.Limit = None
    cancel_timeout: fields.FixedLimit | None = None
    uses: fields.MovedParts = None

    @property
    def known_parts(self) -> frozenset[str] | None:
        """The parts of the robot that the goal moves; None of an unknown action."""
        if self.uses is not None:
            return frozenset(self.uses)
        known = BY_TYPE.get(self.type)
        return None if known is None else frozenset(filter(None, (known.moves,)))

    @property
    def moved_parts(self) -> frozenset[str]:
        """The parts of the robot that the goal moves; an unknown action may move the base."""
        known = self.known_parts
        return frozenset(("base",)) if known is None else known

    @override
    def completed(self, reading: base.Reading) -> Self:
        limits = reading.limits.of(self.ros_name).items()
        return super(
            GoalNode,
            self.model_copy(
                update={name: value for name, value in limits if getattr(self, name) is None}
            ),
        ).completed(reading)

    @property
    @override
    def condition(self) -> Expression | None:
        condition: Expression | None = self.cancel_when
        return condition

    @override
    def with_condition(self, condition: Expression) -> Self:
        return self.model_copy(update={"cancel_when": condition})

    @override
    def endless(self) -> str | None:
        return self.ros_name if self.timeout is None else None

    @override
    def details(self) -> list[str]:
        cancel = self.cancel_when
        return [
            *self.called(),
            *base.shown_fields(self.sent),
            *([] if cancel is None else [f"{self.on_cancel} when {cancel.text}"]),
            *base.shown_limit(self.timeout),
            *self.shown_outputs(),
        ]


class ActionSettings(base.Written):
    """An action by its ROS name and type, and a goal for it."""

    name: fields.ActionNameField
    type: Annotated[str, PlainValidator(fields.action_type), fields.TEXT_SCHEMA]
    values: fields.Goal = Field({}, alias="goal")


class ActionNode(GoalNode):
    """A goal for any action."""

    sent_key: ClassVar[str] = "goal"

    settings: ActionSettings = Field(alias="action")


class ShortActionNode(GoalNode):
    """A goal for an action with a short name, which is the key of the node."""

    short: ClassVar[str]
    action: ClassVar[ActionName]
    goal: fields.Goal = {}

    @property
    @override
    def ros_name(self) -> str:
        return self.action.name

    @property
    @override
    def type(self) -> str:
        return self.action.type

    @property
    @override
    def type_path(self) -> base.Path:
        return (self.short,)

    @property
    @override
    def sent(self) -> Mapping[str, Value]:
        return self.goal

    @property
    @override
    def sent_path(self) -> base.Path:
        return (self.short,)

    @override
    def with_sent(self, sent: Mapping[str, Value]) -> Self:
        return self.model_copy(update={"goal": sent})


@cache
def short_node(name: str) -> type[ShortActionNode]:
    """Return the kind of node of a short name. Raises KeyError."""
    action = ACTION_NAMES[name]
    title = "".join(word.capitalize() for word in name.split("_")) + "Node"
    goal: Any = (fields.Goal, Field(alias=name))
    node = create_model(title, __base__=ShortActionNode, __doc__=f"A goal of {name}.", goal=goal)
    node.short, node.action = name, action
    return node
