"""The kinds of node with one node below them."""

from collections.abc import Iterator
from typing import Annotated, ClassVar, Literal, Self

from pydantic import BeforeValidator, ConfigDict, Field, model_validator
from typing_extensions import override

from bt_mission.language.expressions.expression import Value, written_text
from bt_mission.language.nodes import base, fields

_SWAP = {"success": "failure", "failure": "success"}


class RepeatSettings(base.Written):
    """How often: a number of times, while a condition holds, until one holds."""

    model_config = ConfigDict(json_schema_extra={"minProperties": 1})

    count: fields.Times = None
    before: fields.Condition = Field(None, alias="while")
    after: fields.Condition = Field(None, alias="until")

    @model_validator(mode="after")
    def _say_how_often(self) -> Self:
        if self.count is None and not self.has_condition:
            what = "'count', 'while' or 'until' is missing"
            raise fields.refusal(what, "write 'repeat: {count: 3}'", code="BT-202")
        return self

    @property
    def has_condition(self) -> bool:
        """Whether more than a count ends it."""
        return self.before is not None or self.after is not None


class RepeatNode(base.DecoratorNode):
    """A node, several times: as often as `count` says, or as conditions on variables do."""

    # As long as it succeeds. `while` is asked before each round, `until` after it, when the
    # variables are known that the node below writes; beside them `count` is the most rounds.
    kind: ClassVar[str] = "repeat"
    sign: ClassVar[base.Sign] = base.Sign("↻", "@", "repeat", base.Family.DECORATOR)

    settings: RepeatSettings = Field(alias="repeat")
    child: base.Child = Field(alias="do")

    @property
    @override
    def frame(self) -> tuple[object, ...]:
        given = self.settings
        ends = (given.count, given.before, given.after)
        return (*super().frame, *(end is None for end in ends))

    @override
    def reads(self) -> Iterator[base.Read]:
        for read in super().reads():
            yield read._replace(is_behind=read.path[-1] == "until")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        settings = self.settings
        if not settings.has_condition:
            return below[0]
        ends = below[0] & base.FAILURE
        if settings.before not in (None, True):
            ends |= base.SUCCESS
        if "success" in below[0]:
            ends |= base.SUCCESS if settings.after not in (None, False) else frozenset()
            ends |= base.FAILURE if settings.count is not None else frozenset()
        return ends

    @override
    def details(self) -> list[str]:
        settings = self.settings
        words = {"while": settings.before, "until": settings.after}
        parts = [
            f"{word} {written_text(value)}" for word, value in words.items() if value is not None
        ]
        if settings.count is not None:
            most = "at most " if parts else ""
            parts.append(f"{most}{written_text(settings.count)} times")
        return parts


class RetrySettings(base.Written):
    """How often at most, and how long to pause between (s)."""

    attempts: fields.Times
    pause: fields.Seconds = 0.0


class RetryNode(base.DecoratorNode):
    """A node, until it succeeds."""

    kind: ClassVar[str] = "retry"
    sign: ClassVar[base.Sign] = base.Sign("↺", "@", "retry", base.Family.DECORATOR)

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
    sign: ClassVar[base.Sign] = base.Sign("◷", "t", "timeout", base.Family.DECORATOR)

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
    sign: ClassVar[base.Sign] = base.Sign("≠", "!", "invert", base.Family.DECORATOR)
    child_keys: ClassVar[tuple[str, ...]] = ("invert",)

    child: base.Child = Field(alias="invert")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return frozenset(_SWAP[end] for end in below[0])


class ForceNode(base.DecoratorNode):
    """A node whose end counts as success, or as failure."""

    kind: ClassVar[str] = "force"
    fixed: ClassVar[tuple[str, ...]] = ("status",)
    sign: ClassVar[base.Sign] = base.Sign("=", "=", "force", base.Family.DECORATOR)

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
    sign: ClassVar[base.Sign] = base.Sign("◈", "<>", "guard", base.Family.CONDITION)

    condition: fields.Condition = Field(alias="guard")
    child: base.Child = Field(alias="do")

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return below[0] if self.condition is True else below[0] | base.FAILURE


class ForEachNode(base.DecoratorNode):
    """A node, once for each element of a list."""

    # The variable is known only below it; `checks.scope` sees to that.
    kind: ClassVar[str] = "for_each"
    fixed: ClassVar[tuple[str, ...]] = ("variable",)
    sign: ClassVar[base.Sign] = base.Sign("∀", "@", "for each", base.Family.DECORATOR)

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
