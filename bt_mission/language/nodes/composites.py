"""The kinds of node with several nodes below them."""

from collections import Counter
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal, Self

from pydantic import Field
from typing_extensions import override

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.language.expressions.expression import written_text
from bt_mission.language.nodes import base, fields


class InTurnNode(base.CompositeNode):
    """Children one after another, as long as each ends in a certain way.

    With `memory`, those that have ended so are not asked again.
    """

    goes_on: ClassVar[Literal["success", "failure"]]

    if TYPE_CHECKING:
        memory: bool

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        combined: base.Ends = frozenset()
        for ends in below:
            combined |= ends - {self.goes_on}
            if self.goes_on not in ends:
                return combined
        return combined | {self.goes_on}

    @override
    def details(self) -> list[str]:
        return [] if self.memory else ["checks all children again in every tick"]


class SequenceNode(InTurnNode):
    """Children one after another, until one fails."""

    kind: ClassVar[str] = "sequence"
    fixed: ClassVar[tuple[str, ...]] = ("memory",)
    sign: ClassVar[base.Sign] = base.Sign("→", "->", "sequence", base.Family.COMPOSITE)
    goes_on: ClassVar[Literal["success", "failure"]] = "success"

    children: base.Children = Field(alias="sequence")
    memory: bool = True


class FallbackNode(InTurnNode):
    """Children one after another, until one succeeds."""

    kind: ClassVar[str] = "fallback"
    fixed: ClassVar[tuple[str, ...]] = ("memory",)
    sign: ClassVar[base.Sign] = base.Sign("?", "?", "fallback", base.Family.COMPOSITE)
    goes_on: ClassVar[Literal["success", "failure"]] = "failure"

    children: base.Children = Field(alias="fallback")
    memory: bool = True


class ParallelNode(base.CompositeNode):
    """Children all at once."""

    # It succeeds when all children have, when any has, or when those of these names have. It fails
    # when any has failed, or once it can no longer succeed. The rest is then halted, or finishes.
    kind: ClassVar[str] = "parallel"
    fixed: ClassVar[tuple[str, ...]] = ("needed", "fail_when", "rest")
    sign: ClassVar[base.Sign] = base.Sign("⇉", "=>", "parallel", base.Family.COMPOSITE)

    children: base.Children = Field(alias="parallel")
    succeed_when: Literal["all", "any"] | Annotated[list[fields.Line], Field(min_length=1)] = "all"
    fail_when: Literal["any", "impossible"] = "any"
    rest: Literal["halt", "finish"] = "halt"

    @property
    def needed(self) -> list[int] | None:
        """The indices of the children that must succeed; None where any one is enough."""
        if self.succeed_when == "any":
            return None
        names = [child.name for child in self.children]
        if self.succeed_when == "all":
            return list(range(len(names)))
        return [names.index(name) for name in self.succeed_when]

    @override
    def completed(self, reading: base.Reading) -> Self:
        names = [child.name for child in self.children if child.name]
        count = Counter(names)
        wanted = [] if isinstance(self.succeed_when, str) else self.succeed_when
        for index, name in enumerate(wanted):
            if count[name] != 1 and not reading.is_full:
                what = "more than one child" if count[name] else "no child"
                message = f"{what} is called {quoted(name)} (children with names: "
                message += f"{listed(names)})"
                path = (*self.path, "succeed_when", index)
                reading.report("BT-214", path, message, did_you_mean(name, names))
        return self

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return (
            base.EITHER if any("failure" in ends for ends in below) else frozenset().union(*below)
        )

    @override
    def details(self) -> list[str]:
        wanted = self.succeed_when
        if isinstance(wanted, str):
            succeeds = f"succeeds when {wanted} {'do' if wanted == 'all' else 'does'}"
        else:
            succeeds = f"succeeds when these do: {', '.join(wanted)}"
        fails = ["fails when it cannot succeed"] if self.fail_when == "impossible" else []
        rest = ["the rest finishes"] if self.rest == "finish" else []
        return [succeeds, *fails, *rest]


class ChooseNode(base.CompositeNode):
    """One of the children, chosen at random each time."""

    kind: ClassVar[str] = "choose"
    sign: ClassVar[base.Sign] = base.Sign("⚄", "%", "choice", base.Family.COMPOSITE)

    children: base.Children = Field(alias="choose")
    weights: list[fields.Weight] = []

    @override
    def completed(self, reading: base.Reading) -> Self:
        count = len(self.children)
        if self.weights and len(self.weights) != count:
            message = f"expected {count} weights, one a child, got {len(self.weights)}"
            reading.report("BT-214", (*self.path, "weights"), message)
        return self

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return frozenset().union(*below)

    @override
    def details(self) -> list[str]:
        weights = ", ".join(f"{weight:g}" for weight in self.weights)
        return [f"weights {weights}"] if weights else []


class FinallySettings(base.Written):
    """How long the clean-up may take (s)."""

    timeout: fields.Limit


class FinallyNode(base.NodeModel):
    """A node, and a clean-up that runs however the node ends."""

    # By itself, by a halt of the tree around it, or with the mission. Its status is the node's,
    # or failure where the clean-up fails or takes longer than its `timeout`.
    kind: ClassVar[str] = "finally"
    sign: ClassVar[base.Sign] = base.Sign("Ω", "&", "finally", base.Family.DECORATOR)
    child_keys: ClassVar[tuple[str, ...]] = ("do", "then")

    settings: FinallySettings = Field(alias="finally")
    child: base.Child = Field(alias="do")
    cleanup: base.Child = Field(alias="then")

    @property
    @override
    def below(self) -> tuple[base.NodeModel, ...]:
        return self.child, self.cleanup

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        body, cleanup = below
        takes_time = any(node.takes_time for node in self.cleanup.walk())
        may_fail = "failure" in cleanup or takes_time
        return (body if "success" in cleanup else frozenset()) | (
            base.FAILURE if may_fail else frozenset()
        )

    @override
    def details(self) -> list[str]:
        return [f"then clean up, within {written_text(self.settings.timeout)} s"]


class WhenNode(base.ConditionalNode):
    """A node if a condition holds, and another one if not."""

    # It succeeds where the condition does not hold and there is no other one.
    kind: ClassVar[str] = "when"
    sign: ClassVar[base.Sign] = base.Sign("◇", "<>", "when", base.Family.CONDITION)
    child_keys: ClassVar[tuple[str, ...]] = ("do", "else")

    condition: fields.Condition = Field(alias="when")
    child: base.Child = Field(alias="do")
    otherwise: base.MaybeChild = Field(None, alias="else")

    @property
    @override
    def below(self) -> tuple[base.NodeModel, ...]:
        return (self.child,) if self.otherwise is None else (self.child, self.otherwise)

    @override
    def ends(self, below: list[base.Ends]) -> base.Ends:
        return frozenset().union(*below, base.SUCCESS if self.otherwise is None else ())

    @override
    def details(self) -> list[str]:
        otherwise = [] if self.otherwise is None else ["then the first, else the second"]
        return [*super().details(), *otherwise]
