"""Steps of the mission language to py_trees behaviours."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from bt_mission.goals.attempt import Limits
from bt_mission.mission import steps
from bt_mission.mission.expressions import Expression, ExpressionError, Value, resolve
from bt_mission.mission.nodes import Comparison, Constant, Name
from bt_mission.mission.nodes import Scope as Evaluation
from bt_mission.mission.rules import LIMIT, SECONDS, TIMES, NumberRule
from bt_mission.mission.values import show
from bt_mission.tree import decorators, leaves
from bt_mission.tree.action_leaf import ActionLeaf, Plan
from bt_mission.tree.runtime import MissionFailure, Scope, read_field
from bt_mission.tree.service_leaf import Call, ServiceLeaf
from bt_mission.tree.wait_for import WaitFor, Watch


def build_tree(mission: steps.Mission, scope: Scope) -> Behaviour:
    """The tree of a mission; its leaves read and write ``scope``.

    A root with children takes the mission's name where it has none. Nothing of ROS is needed to
    build it. Give each node its ``setup(runtime=...)`` before the first tick.
    """
    root = mission.tree
    if root.name is None and root.steps:
        root = replace(root, name=mission.name)
    return _Builder(mission.file, scope).build(root, "0")


class _Builder:
    def __init__(self, file: str, scope: Scope) -> None:
        self._file = file
        self._scope = scope

    def build(self, step: steps.Step, path: str) -> Behaviour:
        match step:
            case steps.Composite():
                children = [
                    self.build(child, f"{path}.{i}") for i, child in enumerate(step.children)
                ]
                return _composite(step, children)
            case steps.Repeat():
                child = self.build(step.child, f"{path}.0")
                return decorators.Repeat(_name(step), child, self._times(step, path, step.count))
            case steps.Retry():
                return decorators.Retry(
                    _name(step),
                    self.build(step.child, f"{path}.0"),
                    self._times(step, path, step.attempts),
                    self._seconds(step, path, step.pause),
                )
            case steps.Wait():
                return leaves.Wait(_name(step), self._seconds(step, path, step.seconds))
            case steps.Log():
                return leaves.Log(_name(step), lambda: str(self._resolve(step, path, step.message)))
            case steps.Action():
                return self._action(step, path)
            case steps.Service():
                return self._service(step, path)
            case steps.WaitFor():
                return self._wait_for(step, path)
        raise TypeError(f"no behaviour is known for a step of kind '{step.kind}'")

    def _action(self, step: steps.Action, path: str) -> ActionLeaf:
        def plan() -> Plan:
            return Plan(
                goal=self._resolve(step, path, step.goal),
                limits=Limits(
                    server=step.server_timeout,
                    answer=step.answer_timeout,
                    goal=self._limit(step, path, step.timeout),
                    silence=self._limit(step, path, step.silence_timeout),
                    cancel=step.cancel_timeout,
                ),
                condition=None
                if step.cancel_when is None
                else self._condition(step, path, "cancel_when", step.cancel_when),
                target=self._target(step, path),
            )

        return ActionLeaf(
            _name(step),
            step.action,
            step.type,
            plan,
            Status.SUCCESS if step.on_cancel == "success" else Status.FAILURE,
            step.outputs,
            self._place(step),
        )

    def _service(self, step: steps.Service, path: str) -> ServiceLeaf:
        def plan() -> Call:
            return Call(
                request=self._resolve(step, path, step.request),
                server_s=step.server_timeout,
                answer_s=self._number(step, path, step.timeout, LIMIT),
            )

        return ServiceLeaf(
            _name(step), step.service, step.type, plan, step.outputs, self._place(step)
        )

    def _wait_for(self, step: steps.WaitFor, path: str) -> WaitFor:
        def plan() -> Watch:
            return Watch(
                timeout_s=self._limit(step, path, step.timeout),
                condition=self._condition(step, path, "until", step.until),
                show=lambda message: _values(step.until, MessageFields(message)),
            )

        return WaitFor(
            _name(step),
            step.topic,
            step.type,
            plan,
            step.outputs,
            step.until.text,
            self._place(step),
        )

    # ---- values, when a step is entered ---------------------------------------------------

    def _resolve(self, step: steps.Step, path: str, value: Any) -> Any:
        try:
            return resolve(value, self._scope.values, self._scope.random(path))
        except ExpressionError as error:
            raise self._failure(step, str(error)) from error

    def _failure(self, step: steps.Step, message: str) -> MissionFailure:
        return MissionFailure(f"{self._place(step)}: '{_name(step)}' cannot start: {message}")

    def _place(self, step: steps.Step) -> str:
        return f"{self._file}:{step.line}:{step.column}"

    def _number(self, step: steps.Step, path: str, value: Value, rule: NumberRule) -> float:
        number = self._resolve(step, path, value)
        if not rule.allows(number):
            raise self._failure(step, f"expected {rule.words}, got {show(number)}")
        return float(number)

    def _seconds(self, step: steps.Step, path: str, value: Value) -> Callable[[], float]:
        return lambda: self._number(step, path, value, SECONDS)

    def _times(self, step: steps.Step, path: str, value: Value) -> Callable[[], int]:
        return lambda: int(self._number(step, path, value, TIMES))

    def _limit(self, step: steps.Step, path: str, value: Value | None) -> float | None:
        return None if value is None else self._number(step, path, value, LIMIT)

    def _target(self, step: steps.Action, path: str) -> tuple[str, float] | None:
        """The field and the bound of a condition such as ``current_image >= 5``."""
        match step.cancel_when and step.cancel_when.root:
            case Comparison(first=Name(variable=False) as name, rest=((sign, _, bound),)) if (
                sign in (">", ">=") and name.name not in self._scope.values
            ):
                nodes = Evaluation(self._scope.values, {}, self._scope.random(f"{path}/target"))
                limit = bound.evaluate(nodes) if isinstance(bound, Constant | Name) else None
                if isinstance(limit, int | float):
                    return name.name, float(limit)
        return None

    def _condition(
        self, step: steps.Step, path: str, key: str, expression: Expression
    ) -> Callable[[Any], str | None]:
        """Says what was met, with the values of the message it names."""
        random = self._scope.random(f"{path}/{key}")

        def met(message: Any) -> str | None:
            fields = MessageFields(message)
            try:
                if not expression.evaluate(self._scope.values, random, fields):
                    return None
            except ExpressionError as error:
                place, name = self._place(step), _name(step)
                raise MissionFailure(f"{place}: '{name}' {key}: {error}") from error
            values = _values(expression, fields)
            return f"{expression.text}" + (f" ({values})" if values else "")

        return met


class MessageFields(Mapping[str, Any]):
    """The fields of a message by dotted name."""

    def __init__(self, message: Any) -> None:
        self._message = message

    def __getitem__(self, dotted: str) -> Any:
        try:
            return read_field(self._message, dotted)
        except AttributeError:
            raise KeyError(dotted) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._message.get_fields_and_field_types())

    def __len__(self) -> int:
        return len(self._message.get_fields_and_field_types())


def _name(step: steps.Step) -> str:
    if step.name:
        return step.name
    match step:
        case steps.Action(action=name) | steps.Service(service=name):
            return name.strip("/")
        case steps.WaitFor(topic=topic):
            return f"wait for {topic.strip('/')}"
    return step.kind


def _values(condition: Expression, fields: Mapping[str, Any]) -> str:
    """What a condition reads of a message, for people."""
    names = dict.fromkeys(name.name for name in condition.references if not name.variable)
    found = {name: fields[name] for name in names if name in fields}
    return ", ".join(
        f"{name} of {len(value)}" if isinstance(value, list) else f"{name} = {show(value)}"
        for name, value in found.items()
    )


def _composite(step: steps.Composite, children: list[Behaviour]) -> Behaviour:
    match step:
        case steps.Sequence():
            return py_trees.composites.Sequence(_name(step), step.memory, children)
        case steps.Fallback():
            return py_trees.composites.Selector(_name(step), step.memory, children)
        case steps.Parallel():
            # Children that have succeeded are not ticked again while others still run.
            policy = (
                ParallelPolicy.SuccessOnAll(synchronise=True)
                if step.succeed_when == "all"
                else ParallelPolicy.SuccessOnOne()
            )
            return py_trees.composites.Parallel(_name(step), policy, children)
    raise TypeError(f"no behaviour is known for a step of kind '{step.kind}'")
