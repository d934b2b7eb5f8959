"""Calls of ROS 2 services."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, ClassVar, Literal

from pydantic import Field, PlainValidator
from typing_extensions import override

from bt_mission.language.expressions.expression import Value
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
)


class ServiceSettings(Written):
    """A service by its ROS name and type, and a request for it."""

    name: Annotated[str, PlainValidator(fields.service_name), TEXT_SCHEMA]
    type: Annotated[str, PlainValidator(fields.service_type), TEXT_SCHEMA]
    request: Goal = {}


class ServiceNode(InterfaceNode, OutputsNode):
    """A call of any service. Times are seconds of ROS time."""

    # `timeout` bounds the time from the call to the answer, `server_timeout` the wait for a
    # server. `outputs` takes fields of the response.
    kind: ClassVar[str] = "service"
    interface: ClassVar[Literal["action", "service", "topic"]] = "service"

    settings: ServiceSettings = Field(alias="service")
    timeout: Limit = 5.0
    outputs: dict[ResultField, Variable] = {}
    server_timeout: FixedLimit = 5.0

    @property
    @override
    def ros_name(self) -> str:
        return self.settings.name

    @property
    @override
    def type(self) -> str:
        return self.settings.type

    @property
    @override
    def sent(self) -> Mapping[str, Value]:
        return self.settings.request

    @property
    @override
    def sent_path(self) -> Path:
        return ("service", "request")

    @override
    def reads(self) -> Iterator[Read]:
        yield Read(("timeout",), self.timeout, LIMIT)

    @override
    def details(self) -> list[str]:
        return [*self.called(), *shown_fields(self.sent), *self.shown_outputs()]
