"""The kinds of node that use ROS interfaces, actions apart: services and topics."""

from collections.abc import Mapping
from dataclasses import dataclass
from operator import is_not
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PlainValidator
from typing_extensions import override

from bt_mission.language.expressions.expression import Expression, Text, Value
from bt_mission.language.expressions.places import Places, with_places
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.units import quantities
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.interface_units import POSE, type_of_field, unit_of_field
from bt_mission.language.nodes import base, fields

PARTS_OF = {
    "action": ("goal", "feedback"),
    "service": ("request", "response"),
    "topic": ("message", "message"),
}
"""The message that a node of an interface sends, and the one that its condition reads."""


@dataclass(frozen=True)
class _FieldReader:
    """Gives quantities and named places the values that the fields of a message want."""

    type_name: str
    part: str
    places: Places

    def read(self, value: Any, path: base.Path) -> Any:
        """Return a value with them; the same object where it has none."""
        match value:
            case Text():
                return self.text(value, path)
            case Mapping():
                inner = {key: self.read(item, (*path, key)) for key, item in value.items()}
                return (
                    inner if any(item is not value[key] for key, item in inner.items()) else value
                )
            case tuple():
                items = tuple(self.read(item, (*path, index)) for index, item in enumerate(value))
                return items if any(map(is_not, items, value)) else value
        return value

    def text(self, text: Text, path: base.Path) -> Text:
        field = type_of_field(self.type_name, self.part, path)
        if field.name.partition("[")[0] == POSE:
            return with_places(text, self.places)
        expression = text.expression
        if isinstance(expression, Expression) and any(quantities(expression.root)):
            unit = unit_of_field(self.type_name, self.part, path)
            return text if unit is None else text.in_unit(unit)
        return text


class InterfaceNode(base.NodeModel):
    """A node that uses a ROS interface: an action, a service or a topic.

    It reads fields of messages, with dots if they are nested.
    """

    interface: ClassVar[Literal["action", "service", "topic"]]
    takes_time: ClassVar[bool] = True
    fixed: ClassVar[tuple[str, ...]] = ("ros_name", "type")
    sent_key: ClassVar[str] = ""
    """The key of the fields that it sends in its settings; "" where it sends none."""
    condition_path: ClassVar[base.Path] = ()
    """Where the condition stands below the node."""

    if TYPE_CHECKING:
        settings: Any

    @property
    def ros_name(self) -> str:
        """The name of the action, service or topic, such as "/turn"."""
        name: str = self.settings.name
        return name

    @property
    def type(self) -> str:
        """The full name of the type."""
        type_name: str = self.settings.type
        return type_name

    @property
    def type_path(self) -> base.Path:
        """Where the type stands below the node."""
        return (self.kind, "type")

    @property
    def sent(self) -> Mapping[str, Value]:
        """The fields that it sends, of a goal, a request or a message."""
        return self.settings.values if self.sent_key else {}

    @property
    def sent_path(self) -> base.Path:
        """Where those stand below the node."""
        return (self.kind, self.sent_key) if self.sent_key else ()

    @property
    def condition(self) -> Expression | None:
        """The condition on messages that it waits for."""
        return None

    def with_sent(self, sent: Mapping[str, Value]) -> Self:
        """Return the node with other values for the fields that it sends."""
        settings = self.settings.model_copy(update={"values": sent})
        return self.model_copy(update={"settings": settings})

    def with_condition(self, condition: Expression) -> Self:
        """Return the node with another condition."""
        raise NotImplementedError

    @override
    def completed(self, reading: base.Reading) -> Self:
        """Return the node with its quantities as numbers in the units of its fields."""
        sends, asks = PARTS_OF[self.interface]
        node = self
        reader = _FieldReader(self.type, sends, reading.places)
        sent = reader.read(self.sent, ())
        if sent is not self.sent:
            node = node.with_sent(sent)
        if self.condition is None:
            return node

        def unit_of(name: Name) -> str:
            path = tuple(name.name.split("."))
            return "" if name.variable else unit_of_field(self.type, asks, path) or ""

        try:
            condition = self.condition.in_unit("", unit_of)
        except ExpressionError as error:
            place = (*self.path, *self.condition_path)
            reading.report(error.code, place, error.message, error.hint, offset=error.column - 1)
            return node
        return node if condition is self.condition else node.with_condition(condition)

    @override
    def default_label(self) -> str:
        return self.ros_name.strip("/")

    def called(self) -> list[str]:
        """Return whom it speaks to as a drawing shows it, unless that is the node's label."""
        name = self.ros_name
        return [name if name.startswith("/") else f"/{name}"] if self.name else []


class ServiceSettings(base.Written):
    """A service by its ROS name and type, and a request for it."""

    name: Annotated[str, PlainValidator(fields.service_name), fields.TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(fields.service_type), fields.TEXT_SCHEMA]
    values: fields.Goal = Field({}, alias="request")


class ServiceNode(InterfaceNode, base.OutputsNode):
    """A call of any service. Times are seconds of ROS time."""

    # `timeout` bounds the time from the call to the answer, `server_timeout` the wait for a
    # server. `outputs` takes fields of the response.
    kind: ClassVar[str] = "service"
    sign: ClassVar[base.Sign] = base.Sign("⇄", "<>", "service", base.Family.ACTION)
    interface: ClassVar[Literal["action", "service", "topic"]] = "service"
    sent_key: ClassVar[str] = "request"

    settings: ServiceSettings = Field(alias="service")
    timeout: fields.Limit = 5.0
    outputs: dict[fields.ResultField, fields.Variable] = {}
    server_timeout: fields.FixedLimit = 5.0

    @override
    def details(self) -> list[str]:
        return [*self.called(), *base.shown_fields(self.sent), *self.shown_outputs()]


class WaitForSettings(base.Written):
    """A topic by its ROS name and type, and what a message of it must meet."""

    name: Annotated[str, PlainValidator(fields.topic_name), fields.TEXT_SCHEMA] = Field(
        alias="topic"
    )
    type: Annotated[str, PlainValidator(fields.message_type), fields.TEXT_SCHEMA]
    until: Annotated[Any, PlainValidator(fields.until), fields.TEXT_SCHEMA]


class WaitForNode(InterfaceNode, base.OutputsNode):
    """A pause until a message meets a condition."""

    # `until` is asked on every message; `outputs` takes fields of the one that met it.
    kind: ClassVar[str] = "wait_for"
    sign: ClassVar[base.Sign] = base.Sign("▷", "|>", "wait for a message", base.Family.MESSAGE)
    interface: ClassVar[Literal["action", "service", "topic"]] = "topic"
    condition_path: ClassVar[base.Path] = ("wait_for", "until")

    settings: WaitForSettings = Field(alias="wait_for")
    timeout: fields.Limit = None
    outputs: dict[fields.ResultField, fields.Variable] = {}

    @property
    @override
    def condition(self) -> Expression:
        until: Expression = self.settings.until
        return until

    @override
    def with_condition(self, condition: Expression) -> Self:
        settings = self.settings.model_copy(update={"until": condition})
        return self.model_copy(update={"settings": settings})

    @override
    def endless(self) -> str | None:
        return f"the wait for {self.ros_name}" if self.timeout is None else None

    @override
    def default_label(self) -> str:
        return f"wait for {self.ros_name.strip('/')}"

    @override
    def details(self) -> list[str]:
        until = f"until {self.condition.text}"
        return [*self.called(), until, *base.shown_limit(self.timeout), *self.shown_outputs()]


class PublishSettings(base.Written):
    """A topic by its ROS name and type, and a message for it."""

    name: Annotated[str, PlainValidator(fields.topic_name), fields.TEXT_SCHEMA] = Field(
        alias="topic"
    )
    type: Annotated[str, PlainValidator(fields.message_type), fields.TEXT_SCHEMA]
    values: fields.Goal = Field({}, alias="message")


class PublishNode(InterfaceNode):
    """A message on any topic. Times are seconds of ROS time."""

    # Once at least `readers` subscriptions are matched; `server_timeout` bounds the wait for them.
    kind: ClassVar[str] = "publish"
    sign: ClassVar[base.Sign] = base.Sign("◁", "<|", "publish", base.Family.MESSAGE)
    interface: ClassVar[Literal["action", "service", "topic"]] = "topic"
    sent_key: ClassVar[str] = "message"

    settings: PublishSettings = Field(alias="publish")
    readers: Annotated[int, Field(ge=0, le=1000)] = 1
    server_timeout: fields.FixedLimit = 5.0

    @override
    def default_label(self) -> str:
        return f"publish {self.ros_name.strip('/')}"

    @override
    def details(self) -> list[str]:
        return [*self.called(), *base.shown_fields(self.sent)]
