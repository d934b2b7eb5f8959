"""The kinds of node with one node below them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal

from pydantic import BeforeValidator, Field
from typing_extensions import override

from bt_mission.language.expressions.expression import Value, written_text
from bt_mission.language.nodes import base, fields

_SWAP = {"success": "failure", "failure": "success"}


class RepeatSettings(base.Written):
    """How often."""

    count: fields.Times


class RepeatNode(base.DecoratorNode):
    """A node, several times."""

    # As long as it succeeds.
    kind: ClassVar[str] = "repeat"

    settings: RepeatSettings = Field(alias="repeat")
    child: base.Child = Field(alias="do")

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.settings.count)} times"]


class RetrySettings(base.Written):
    """How often at most, and how long to pause between (s)."""

    attempts: fields.Times
    pause: fields.Seconds = 0.0


class RetryNode(base.DecoratorNode):
    """A node, until it succeeds."""

    kind: ClassVar[str] = "retry"

    settings: RetrySettings = Field(alias="retry")
    child: base.Child = Field(alias="do")

    @override
    def details(self) -> list[str]:
        settings = self.settings
        pause = "" if settings.pause == 0 else f", {written_text(settings.pause)} s apart"
        return [f"up to {written_text(settings.attempts)} times{pause}"]


class TimeoutNode(base.DecoratorNode):
    """A node, for some seconds at most."""

    # Then it is halted, and the timeout fails.
    kind: ClassVar[str] = "timeout"

    seconds: fields.Limit = Field(alias="timeout")
    child: base.Child = Field(alias="do")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return below[0] | base.FAILURE

    @override
    def details(self) -> list[str]:
        return [f"{written_text(self.seconds)} s"]


class InvertNode(base.DecoratorNode):
    """A node, its success for failure and its failure for success."""

    kind: ClassVar[str] = "invert"
    child_keys: ClassVar[tuple[str, ...]] = ("invert",)

    child: base.Child = Field(alias="invert")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return frozenset(_SWAP[end] for end in below[0])


class ForceNode(base.DecoratorNode):
    """A node whose end counts as success, or as failure."""

    kind: ClassVar[str] = "force"

    status: Literal["success", "failure"] = Field(alias="force")
    child: base.Child = Field(alias="do")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return frozenset({self.status}) if below[0] else below[0]

    @override
    def details(self) -> list[str]:
        return [self.status]


class GuardNode(base.ConditionalNode, base.DecoratorNode):
    """A node, as long as a condition holds."""

    # The condition is looked at before every tick.
    kind: ClassVar[str] = "guard"

    condition: fields.Condition = Field(alias="guard")
    child: base.Child = Field(alias="do")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return below[0] if self.condition is True else below[0] | base.FAILURE


class ForEachNode(base.DecoratorNode):
    """A node, once for each element of a list."""

    # The variable is known only below it; `checks.scope` sees to that.
    kind: ClassVar[str] = "for_each"

    loop: Annotated[
        dict[fields.Variable, fields.Elements],
        BeforeValidator(fields.one_name),
        fields.OBJECT_SCHEMA,
    ] = Field(alias="for_each")
    child: base.Child = Field(alias="do")

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
    def writes(self) -> Iterator[base.Write]:
        yield base.Write(("for_each", self.variable), self.variable, "variable")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return below[0] | base.SUCCESS

    @override
    def details(self) -> list[str]:
        return [f"{self.variable} in {written_text(self.elements)}"]
