"""The steps of a mission: frozen, typed, checked; what the tree is built from.

Times are seconds of ROS time. A `Value` is a constant or is computed when the step is entered
(`expressions.resolve`). Every step knows where it stands in its file.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, Literal, TypeAlias

from typing_extensions import override

from bt_mission.language.expressions.expression import Expression, Template, Value
from bt_mission.language.expressions.values import Type

Key = str | int

Condition: TypeAlias = Expression | bool
"""A condition on variables; a constant where it holds always or never."""


@dataclass(frozen=True, kw_only=True)
class Step:
    """One node of a mission. `line` and `column` count from 1; `path` leads there."""

    kind: ClassVar[str]

    name: str | None = None
    line: int = 0
    column: int = 0
    path: tuple[Key, ...] = field(default=(), repr=False, compare=False)

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps directly below this one."""
        return ()

    def walk(self) -> Iterator[Step]:
        """Yield this step and all below it, in the order of the file."""
        waiting: list[Step] = [self]
        while waiting:
            step = waiting.pop()
            yield step
            waiting.extend(reversed(step.steps))


@dataclass(frozen=True, kw_only=True)
class Composite(Step):
    """A step with several below it."""

    children: tuple[Step, ...]

    @property
    @override
    def steps(self) -> tuple[Step, ...]:
        return self.children


@dataclass(frozen=True, kw_only=True)
class SequenceStep(Composite):
    """One child after another until one fails. With memory, done children are not asked again."""

    kind: ClassVar[str] = "sequence"
    memory: bool = True


@dataclass(frozen=True, kw_only=True)
class FallbackStep(Composite):
    """One child after another until one succeeds. With memory, failed ones are not asked again."""

    kind: ClassVar[str] = "fallback"
    memory: bool = True


@dataclass(frozen=True, kw_only=True)
class ParallelStep(Composite):
    """All children at once.

    It succeeds when all children have, when any has, or when those of these indices have. It fails
    when any has failed, or once it can no longer succeed. The `rest` is then halted, or finishes.
    """

    kind: ClassVar[str] = "parallel"
    succeed_when: Literal["all", "any"] | tuple[int, ...] = "all"
    fail_when: Literal["any", "impossible"] = "any"
    rest: Literal["halt", "finish"] = "halt"


@dataclass(frozen=True, kw_only=True)
class ChooseStep(Composite):
    """One child, drawn at each entry; `weights` are in proportion, none means all alike."""

    kind: ClassVar[str] = "choose"
    weights: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Decorator(Step):
    """A step with one below it."""

    child: Step

    @property
    @override
    def steps(self) -> tuple[Step, ...]:
        return (self.child,)


@dataclass(frozen=True, kw_only=True)
class RepeatStep(Decorator):
    """Runs its child `count` times (a whole number), as long as it succeeds."""

    kind: ClassVar[str] = "repeat"
    count: Value


@dataclass(frozen=True, kw_only=True)
class RetryStep(Decorator):
    """Runs its child up to `attempts` times until it succeeds, with `pause` seconds between."""

    kind: ClassVar[str] = "retry"
    attempts: Value
    pause: Value = 0.0


@dataclass(frozen=True, kw_only=True)
class TimeoutStep(Decorator):
    """Runs its child, and halts it and fails after some seconds."""

    kind: ClassVar[str] = "timeout"
    seconds: Value


@dataclass(frozen=True, kw_only=True)
class InvertStep(Decorator):
    """Takes its child's success for failure, and its failure for success."""

    kind: ClassVar[str] = "invert"


@dataclass(frozen=True, kw_only=True)
class ForceStep(Decorator):
    """Takes its child's end for success, or for failure."""

    kind: ClassVar[str] = "force"
    status: Literal["success", "failure"]


@dataclass(frozen=True, kw_only=True)
class GuardStep(Decorator):
    """Runs its child while a condition holds, which is looked at before every tick."""

    kind: ClassVar[str] = "guard"
    condition: Condition


@dataclass(frozen=True, kw_only=True)
class WhenStep(Composite):
    """Runs its first child if a condition holds at entry, else its second; succeeds without one."""

    kind: ClassVar[str] = "when"
    condition: Condition


@dataclass(frozen=True, kw_only=True)
class ForEachStep(Decorator):
    """Runs its child once for each element of a list, with `variable` set to it."""

    kind: ClassVar[str] = "for_each"
    variable: str
    elements: Value


@dataclass(frozen=True, kw_only=True)
class CheckStep(Step):
    """Succeeds where a condition holds, else fails."""

    kind: ClassVar[str] = "check"
    condition: Condition


@dataclass(frozen=True, kw_only=True)
class SetStep(Step):
    """Gives variables new values, one after another."""

    kind: ClassVar[str] = "set"
    values: Mapping[str, Value]


@dataclass(frozen=True, kw_only=True)
class WaitStep(Step):
    """Waits for some seconds."""

    kind: ClassVar[str] = "wait"
    seconds: Value


@dataclass(frozen=True, kw_only=True)
class LogStep(Step):
    """Says something, once."""

    kind: ClassVar[str] = "log"
    message: Template


@dataclass(frozen=True, kw_only=True)
class Writer(Step):
    """A step with results; `outputs` names the variable that each of them goes to."""

    outputs: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class SubtreeStep(Writer):
    """A named tree with values for its inputs; `outputs` takes variables of the tree.

    `takes` and `gives` are the types of its inputs and outputs.
    Its body is not among the steps below this one: a tree stands by itself.
    """

    kind: ClassVar[str] = "tree"
    tree: str
    inputs: Mapping[str, Value] = field(default_factory=dict)
    takes: Mapping[str, Type | None] = field(default_factory=dict, repr=False)
    gives: Mapping[str, Type] = field(default_factory=dict, repr=False)


@dataclass(frozen=True, kw_only=True)
class PythonStep(Writer):
    """A behaviour written in Python: "module:Class", "file.py:Class", or the name of a plug-in.

    `inputs` become attributes of it whenever it is entered; `outputs` takes attributes.
    """

    kind: ClassVar[str] = "python"
    target: str
    inputs: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Speaker(Writer):
    """A step that speaks ROS; its outputs are fields of messages, dotted where they are nested.

    `type` is the full name of the type.
    """

    type: str


@dataclass(frozen=True, kw_only=True)
class PublishStep(Speaker):
    """One message on a topic ("/lamp"), once at least `readers` subscriptions are matched.

    `server_timeout` bounds the wait for them.
    """

    kind: ClassVar[str] = "publish"
    topic: str
    message: Mapping[str, Value] = field(default_factory=dict)
    readers: int = 1
    server_timeout: float = 5.0


@dataclass(frozen=True, kw_only=True)
class ServiceStep(Speaker):
    """One call of a ROS 2 service.

    `service` is the name ("/stop"), `request` holds fields by name. `timeout` bounds the time from
    the call to the answer, `server_timeout` the wait for a server. `outputs` takes fields of
    the response.
    """

    kind: ClassVar[str] = "service"
    service: str
    request: Mapping[str, Value] = field(default_factory=dict)
    timeout: Value = 5.0
    server_timeout: float = 5.0


@dataclass(frozen=True, kw_only=True)
class WaitForStep(Speaker):
    """Waits until a message of a topic meets a condition.

    `topic` is the name ("/battery_state").
    `until` is asked on every message; `outputs` takes fields of the one that met it. `timeout`
    bounds the wait; None means no limit.
    """

    kind: ClassVar[str] = "wait_for"
    topic: str
    until: Expression
    timeout: Value | None = None


@dataclass(frozen=True, kw_only=True)
class ActionStep(Speaker):
    """One goal of a ROS 2 action, from sending it to its end.

    `action` is the name ("/turn").
    `goal` holds fields by name. `timeout` bounds the whole goal, `silence_timeout` the time
    without feedback; None means no limit. `cancel_when` is asked on every feedback; the step
    then ends as `on_cancel` says. `outputs` takes fields of the result, also when the goal was
    cancelled or aborted, provided a result came.
    """

    kind: ClassVar[str] = "action"
    action: str
    goal: Mapping[str, Value] = field(default_factory=dict)
    timeout: Value | None = None
    cancel_when: Expression | None = None
    on_cancel: Literal["success", "failure"] = "failure"
    server_timeout: float = 5.0
    answer_timeout: float = 2.0
    silence_timeout: Value | None = None
    cancel_timeout: float = 3.0
