"""The kinds of node with one node below them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field
from typing_extensions import override

from bt_mission.language.expressions.expression import Value, written_text
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.base import (
    FAILURE,
    SUCCESS,
    Child,
    ConditionalNode,
    DecoratorNode,
    Ends,
    Write,
    Written,
)

_SWAP = {"success": "failure", "failure": "success"}


class RepeatSettings(Written):
    """How often."""

    count: fields.Times


class RepeatNode(DecoratorNode):
    """A node, several times."""

    # As long as it succeeds.
    kind: ClassVar[str] = "repeat"

    settings: RepeatSettings = Field(alias="repeat")
    child: Child = Field(alias="do")

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.settings.count)} times"]


class RetrySettings(Written):
    """How often at most, and how long to pause between (s)."""

    attempts: fields.Times
    pause: fields.Seconds = 0.0


class RetryNode(DecoratorNode):
    """A node, until it succeeds."""

    kind: ClassVar[str] = "retry"

    settings: RetrySettings = Field(alias="retry")
    child: Child = Field(alias="do")

    @override
    def details(self) -> list[str]:
        settings = self.settings
        pause = "" if settings.pause == 0 else f", {written_text(settings.pause)} s apart"
        return [f"up to {written_text(settings.attempts)} times{pause}"]


class TimeoutNode(DecoratorNode):
    """A node, for some seconds at most."""

    # Then it is halted, and the timeout fails.
    kind: ClassVar[str] = "timeout"

    seconds: fields.Limit = Field(alias="timeout")
    child: Child = Field(alias="do")

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return below[0] | FAILURE

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.seconds)} s"]


class InvertNode(DecoratorNode):
    """A node, its success for failure and its failure for success."""

    kind: ClassVar[str] = "invert"
    child_keys: ClassVar[tuple[str, ...]] = ("invert",)

    child: Child = Field(alias="invert")

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return frozenset(_SWAP[end] for end in below[0])


class ForceNode(DecoratorNode):
    """A node whose end counts as success, or as failure."""

    kind: ClassVar[str] = "force"

    status: Literal["success", "failure"] = Field(alias="force")
    child: Child = Field(alias="do")

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return frozenset({self.status}) if below[0] else below[0]

    @override
    def details(self) -> list[str]:
        return [self.status]


class GuardNode(ConditionalNode, DecoratorNode):
    """A node, as long as a condition holds."""

    # The condition is looked at before every tick.
    kind: ClassVar[str] = "guard"

    condition: fields.Condition = Field(alias="guard")
    child: Child = Field(alias="do")

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return below[0] if self.condition is True else below[0] | FAILURE


class ForEachNode(DecoratorNode):
    """A node, once for each element of a list."""

    # The variable is known only below it; `checks.scope` sees to that.
    kind: ClassVar[str] = "for_each"

    loop: Annotated[
        dict[fields.Variable, fields.Elements],
        BeforeValidator(fields.one_name),
        fields.OBJECT_SCHEMA,
    ] = Field(alias="for_each")
    child: Child = Field(alias="do")

    @property
    def variable(self) -> str:
        """The variable that is set to each element."""
        return next(iter(self.loop))

    @property
    def elements(self) -> Value:
        """The list, or the expression that gives it."""
        elements: Value = self.loop[self.variable]
        return elements

    @override
    def writes(self) -> Iterator[Write]:
        yield Write(("for_each", self.variable), self.variable, "variable")

    @override
    def ends(self, below: list[Ends]) -> Ends:
        return below[0] | SUCCESS

    @override
    def details(self) -> list[str]:
        return [f"{self.variable} in {written_text(self.elements)}"]
