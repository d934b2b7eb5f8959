"""Messages on ROS 2 topics: a wait for one, and one that is published."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, PlainValidator
from typing_extensions import override

from bt_mission.language.expressions.expression import Expression, Value
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import (
    Path,
    Read,
    Written,
)
from bt_mission.language.nodes.fields import (
    LIMIT,
    TEXT_SCHEMA,
    FixedLimit,
    Goal,
    Limit,
    ResultField,
    Variable,
)
from bt_mission.language.nodes.interface import (
    InterfaceNode,
    OutputsNode,
    shown_fields,
    shown_limit,
)


class TopicNode(InterfaceNode):
    """A node that uses a topic."""

    interface: ClassVar[Literal["action", "service", "topic"]] = "topic"

    if TYPE_CHECKING:
        settings: Any

    @property
    @override
    def ros_name(self) -> str:
        topic: str = self.settings.topic
        return topic

    @property
    @override
    def type(self) -> str:
        type_name: str = self.settings.type
        return type_name


class WaitForSettings(Written):
    """A topic by its ROS name and type, and what a message of it must meet."""

    topic: Annotated[str, PlainValidator(fields.topic_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(fields.message_type), TEXT_SCHEMA]
    until: Annotated[Any, PlainValidator(fields.until), TEXT_SCHEMA]


class WaitForNode(TopicNode, OutputsNode):
    """A pause until a message meets a condition."""

    # `until` is asked on every message; `outputs` takes fields of the one that met it.
    kind: ClassVar[str] = "wait_for"

    settings: WaitForSettings = Field(alias="wait_for")
    timeout: Limit = None
    outputs: dict[ResultField, Variable] = {}

    @property
    @override
    def condition(self) -> Expression:
        until: Expression = self.settings.until
        return until

    @property
    @override
    def condition_path(self) -> Path:
        return ("wait_for", "until")

    @override
    def reads(self) -> Iterator[Read]:
        if self.timeout is not None:
            yield Read(("timeout",), self.timeout, LIMIT)

    @property
    @override
    def endless(self) -> str | None:
        return f"the wait for {self.ros_name}" if self.timeout is None else None

    @property
    @override
    def default_label(self) -> str:
        return f"wait for {self.ros_name.strip('/')}"

    @override
    def details(self) -> list[str]:
        until = f"until {self.condition.text}"
        return [*self.called(), until, *shown_limit(self.timeout), *self.shown_outputs()]


class PublishSettings(Written):
    """A topic by its ROS name and type, and a message for it."""

    topic: Annotated[str, PlainValidator(fields.topic_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(fields.message_type), TEXT_SCHEMA]
    message: Goal = {}


class PublishNode(TopicNode):
    """A message on any topic. Times are seconds of ROS time."""

    # Once at least `readers` subscriptions are matched; `server_timeout` bounds the wait for them.
    kind: ClassVar[str] = "publish"

    settings: PublishSettings = Field(alias="publish")
    readers: Annotated[int, Field(ge=0, le=1000)] = 1
    server_timeout: FixedLimit = 5.0

    @property
    @override
    def sent(self) -> Mapping[str, Value]:
        return self.settings.message

    @property
    @override
    def sent_path(self) -> Path:
        return ("publish", "message")

    @property
    @override
    def default_label(self) -> str:
        return f"publish {self.ros_name.strip('/')}"

    @override
    def details(self) -> list[str]:
        return [*self.called(), *shown_fields(self.sent)]
