"""The kinds of leaf that speak to nobody."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar

from pydantic import Field
from typing_extensions import override

from bt_mission.language.expressions.expression import written_text
from bt_mission.language.nodes.base import (
    EITHER,
    FAILURE,
    SUCCESS,
    ConditionalNode,
    Ends,
    NodeModel,
    Read,
    Write,
)
from bt_mission.language.nodes.fields import (
    SECONDS,
    Computed,
    Condition,
    Message,
    Seconds,
    Variable,
)


class CheckNode(ConditionalNode):
    """Success where a condition holds, else failure."""

    kind: ClassVar[str] = "check"

    condition: Condition = Field(alias="check")

    @override
    def ends(self, _below: list[Ends]) -> Ends:
        if isinstance(self.condition, bool):
            return SUCCESS if self.condition else FAILURE
        return EITHER


class SetNode(NodeModel):
    """New values for variables."""

    # One after another: each value may read those before it.
    kind: ClassVar[str] = "set"

    values: Annotated[dict[Variable, Computed], Field(min_length=1)] = Field(alias="set")

    @override
    def reads(self) -> Iterator[Read]:
        for name, value in self.values.items():
            yield Read(("set", name), value, assigns=name)

    @override
    def writes(self) -> Iterator[Write]:
        for name, value in self.values.items():
            yield Write(("set", name), name, "variable", value=value)

    @override
    def ends(self, _below: list[Ends]) -> Ends:
        return SUCCESS

    @property
    @override
    def default_label(self) -> str:
        return f"set {', '.join(self.values)}"

    @override
    def details(self) -> list[str]:
        return [f"{name} = {written_text(value)}" for name, value in self.values.items()]


class WaitNode(NodeModel):
    """Nothing, for some seconds."""

    kind: ClassVar[str] = "wait"
    takes_time: ClassVar[bool] = True

    seconds: Seconds = Field(alias="wait")

    @override
    def reads(self) -> Iterator[Read]:
        yield Read(("wait",), self.seconds, SECONDS)

    @override
    def ends(self, _below: list[Ends]) -> Ends:
        return SUCCESS

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.seconds)} s"]


class LogNode(NodeModel):
    """A line in the log."""

    kind: ClassVar[str] = "log"

    message: Message = Field(alias="log")

    @override
    def reads(self) -> Iterator[Read]:
        yield Read(("log",), self.message)

    @override
    def ends(self, _below: list[Ends]) -> Ends:
        return SUCCESS

    @override
    def details(self) -> list[str]:
        return [self.message.text]
