"""The values of a behaviour's node.

Every expression of a mission is evaluated when its node is entered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from operator import is_
from typing import Any, NamedTuple, TypeAlias

from py_trees.behaviour import Behaviour

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.behaviours.runtime import MissionFailure, Scope, read_field
from bt_mission.executive.goals.attempt import WatchedVariables
from bt_mission.language.expressions.expression import Expression, Value, resolve
from bt_mission.language.expressions.syntax import Comparison, Constant, Name
from bt_mission.language.expressions.syntax import EvaluationScope as Evaluation
from bt_mission.language.expressions.values import ExpressionError, show
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.fields import LIMIT, NumberRule

Condition: TypeAlias = Expression | bool
"""A condition on variables; a constant if it is always true or false."""

_LASTING = frozenset((bool, int, float, str))
"""Values that do not change while a variable holds them, unlike lists."""


class ConditionResult(NamedTuple):
    """Whether a condition is true, and as text, with the values that it read."""

    holds: bool
    text: str


_CONSTANT = {
    True: ConditionResult(True, "always holds"),
    False: ConditionResult(False, "never holds"),
}


@dataclass
class _Asked:
    """A condition with its last result, which lasts while the variables hold the same values."""

    condition: Expression
    names: tuple[str, ...]
    values: list[Any] = field(default_factory=list)
    result: ConditionResult | None = None


class Evaluator:
    """Evaluates the values of one node, and holds the behaviours below it.

    Args:
        node: The node in its current version: it may be revised while the mission runs.
        path: The node's path in the tree. Random values derive from it and the seed.
        mission: The whole mission.
        file: The file of the node, for messages.
        scope: The variables that it reads and writes.
    """

    def __init__(self, node: Any, path: str, mission: Mission, file: str, scope: Scope) -> None:
        self.path, self.mission, self.scope = path, mission, scope
        self.inner = scope
        """The variables of the nodes below; a named tree has a separate scope."""
        self.children: list[Behaviour] = []
        self.scope.evaluators[path] = self
        self._asked: dict[str, _Asked] = {}
        self.revise(node, file)

    def revise(self, node: Any, file: str) -> None:
        """Use another version of the node from now on.

        A running node keeps the values that it read.

        Args:
            node: A node with the frame of the first one.
            file: The file of the node.
        """
        self.node, self.file = node, file
        self.place = f"{file}:{node.line}:{node.column}"

    def failure(self, message: str, code: str = MissionFailure.code) -> MissionFailure:
        """The end of the mission at this node."""
        text = f"{self.place}: '{self.node.label}' cannot start: {message}"
        return MissionFailure(text, code=code)

    @contextmanager
    def starting(self) -> Iterator[None]:
        """Turn what goes wrong when the node starts into the end of the mission."""
        try:
            yield
        except BtMissionError as error:
            raise self.failure(str(error), error.code) from error

    def resolve(self, value: Any) -> Any:
        """A value with everything in it computed. Raises MissionFailure."""
        try:
            return resolve(value, self.scope.values, self.scope.random_for(self.path, value))
        except ExpressionError as error:
            raise self.failure(str(error), error.code) from error

    def number(self, value: Value, rule: NumberRule) -> float:
        """A number that keeps to a rule. Raises MissionFailure."""
        number = self.resolve(value)
        if not rule.allows(number):
            raise self.failure(rule.refuses(show(number), number))
        return float(number)

    def limit(self, value: Value | None) -> float | None:
        """Return seconds above 0, or None for no limit."""
        return None if value is None else self.number(value, LIMIT)

    def store(self, outputs: Mapping[str, str], message: Any) -> None:
        """Write fields of a message, by their dotted names, to variables."""
        for name, variable in outputs.items():
            self.scope.values[variable] = read_field(message, name)

    # ---- conditions on variables ---------------------------------------------------------

    def ask(self, condition: Condition) -> ConditionResult:
        """Evaluate a condition on variables. Raises MissionFailure if it cannot be evaluated.

        While the variables that it reads have the same plain values, the result is reused.
        """
        if isinstance(condition, bool):
            return _CONSTANT[condition]
        asked = self._asked.get(condition.text)
        if asked is None or asked.condition is not condition:
            names = tuple(dict.fromkeys(name.name for name in condition.references))
            asked = self._asked[condition.text] = _Asked(condition, names)
        variables = self.scope.values
        values = [variables.get(name) for name in asked.names]
        if asked.result is not None and all(map(is_, values, asked.values)):
            return asked.result
        result = self._judge(condition, asked.names)
        is_lasting = not condition.draws and _LASTING.issuperset(map(type, values))
        asked.result, asked.values = (result, values) if is_lasting else (None, [])
        return result

    def _judge(self, condition: Expression, names: tuple[str, ...]) -> ConditionResult:
        variables = self.scope.values
        try:
            answer = condition.evaluate(variables, self.scope.random_for(self.path, condition))
        except ExpressionError as error:
            raise self.failure(str(error), error.code) from error
        if not isinstance(answer, bool):
            raise self.failure(f"'{condition.text}' gave {show(answer)}, not a boolean")
        values = ", ".join(
            [f"{name} = {brief(variables[name])}" for name in names if name in variables]
        )
        holds = "holds" if answer else "does not hold"
        return ConditionResult(answer, holds + (f" ({values})" if values else ""))

    # ---- conditions on messages ----------------------------------------------------------

    def condition(self, key: str, expression: Expression) -> Callable[[Any], str | None]:
        """Return a function that returns why a message meets a condition, with values, or None."""
        random = self.scope.random_for(f"{self.path}/{key}", expression)

        def met(message: Any) -> str | None:
            fields = MessageFields(message)
            try:
                if not expression.evaluate(self.scope.values, random, fields):
                    return None
            except ExpressionError as error:
                where = f"{self.place}: '{self.node.label}' {key}"
                raise MissionFailure(f"{where}: {error}", code=error.code) from error
            values = values_read(expression, fields)
            return f"{expression.text}" + (f" ({values})" if values else "")

        return met

    def watched(self, key: str, expression: Expression) -> WatchedVariables | None:
        """Return the variables that a condition on messages reads; None if it reads none."""
        variables = self.scope.values
        names = tuple(dict.fromkeys(name.name for name in expression.references))
        if not any(name.variable or name.name in variables for name in expression.references):
            return None
        needs_message = not all(name.variable for name in expression.references)
        condition = self.condition(key, expression)

        def values() -> tuple[Any, ...]:
            return tuple(map(variables.get, names))

        def met(message: Any) -> str | None:
            reason = condition(message)
            if reason is None or needs_message:
                return reason
            read = zip(names, values(), strict=True)
            return f"{reason} ({', '.join(f'{name} = {brief(value)}' for name, value in read)})"

        return WatchedVariables(values, needs_message, met)

    def target(self, condition: Expression | None) -> tuple[str, float] | None:
        """The field and the bound of a condition such as ``current_image >= 5``."""
        match condition and condition.root:
            case Comparison(first=Name(variable=False) as name, rest=((sign, _, bound),)) if (
                sign in (">", ">=") and name.name not in self.scope.values
            ):
                random = self.scope.random_for(f"{self.path}/target", condition)
                nodes = Evaluation(self.scope.values, {}, random)
                limit = bound.evaluate(nodes) if isinstance(bound, Constant | Name) else None
                if isinstance(limit, int | float):
                    return name.name, float(limit)
        return None


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


def values_read(condition: Expression, fields: Mapping[str, Any]) -> str:
    """Return the values of a message that a condition reads, as text."""
    names = dict.fromkeys(name.name for name in condition.references if not name.variable)
    values = {name: fields[name] for name in names if name in fields}
    return ", ".join(
        f"{name} of {len(value)}" if isinstance(value, list) else f"{name} = {show(value)}"
        for name, value in values.items()
    )


def brief(value: Any) -> str:
    """Return a variable's value for a message; for a list, its length."""
    return f"a list of {len(value)}" if isinstance(value, list) else show(value)
