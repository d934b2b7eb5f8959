"""What a mission writes as expressions, computed when a step is entered."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from operator import is_
from typing import Any, TypeAlias

from bt_mission.behaviours.control import ConditionResult, Question, Rounds
from bt_mission.behaviours.runtime import MissionFailure, Scope, read_field
from bt_mission.core.diagnostics import describe
from bt_mission.core.errors import BtMissionError
from bt_mission.language.expressions.expression import Expression, Value, resolve
from bt_mission.language.expressions.syntax import Comparison, Constant, Name
from bt_mission.language.expressions.syntax import EvaluationScope as Evaluation
from bt_mission.language.expressions.values import WORDS, ExpressionError, Type, fits, show, type_of
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.decorators import RepeatSettings
from bt_mission.language.nodes.fields import LIMIT, SECONDS, TIMES, NumberRule

Condition: TypeAlias = Expression | bool
"""A condition on variables; a constant where it holds always or never."""

_LASTING = (bool, int, float, str)
"""Values that do not change while a variable holds them, unlike lists."""


@dataclass(frozen=True)
class BuildContext:
    """What the nodes of one tree of a mission have in common when they are built.

    Args:
        mission: the whole mission.
        file: in which the tree stands, for messages.
        scope: the variables that its nodes read and write.
    """

    mission: Mission
    file: str
    scope: Scope


class Evaluator:
    """Computes the values of one node.

    Args:
        path: of the node in the tree; what is random in it follows from that and the seed.
    """

    def __init__(self, node: NodeModel, path: str, context: BuildContext) -> None:
        self.node: Any = node
        self.path = path
        self.context = context
        self.place = f"{context.file}:{node.line}:{node.column}"
        self._scope = context.scope
        self._scope.evaluators[path] = self

    def revise(self, node: NodeModel, file: str) -> None:
        """Go by another version of the node from now on; what has begun keeps what it has read.

        Args:
            node: It has the frame of the first one.
            file: In which it stands.
        """
        self.node = node
        self.place = f"{file}:{node.line}:{node.column}"

    def failure(self, message: str) -> MissionFailure:
        """The end of the mission at this node."""
        return MissionFailure(f"{self.place}: '{self.node.label}' cannot start: {message}")

    @contextmanager
    def starting(self) -> Iterator[None]:
        """Turn what goes wrong when the node starts into the end of the mission."""
        try:
            yield
        except BtMissionError as error:
            raise self.failure(str(error)) from error

    def resolve(self, value: Any) -> Any:
        """A value with everything in it computed. Raises MissionFailure."""
        try:
            return resolve(value, self._scope.values, self._scope.random_for(self.path, value))
        except ExpressionError as error:
            raise self.failure(str(error)) from error

    def store(self, outputs: Mapping[str, str], message: Any) -> None:
        """Write fields of a message, by their dotted names, to variables."""
        for field, variable in outputs.items():
            self._scope.values[variable] = read_field(message, field)

    # ---- numbers -------------------------------------------------------------------------

    def number(self, value: Value, rule: NumberRule) -> float:
        """A number that keeps to a rule. Raises MissionFailure."""
        number = self.resolve(value)
        if not rule.allows(number):
            raise self.failure(rule.refuses(show(number), number))
        return float(number)

    def limit(self, value: Value | None) -> float | None:
        """Seconds above 0, or None for no limit."""
        return None if value is None else self.number(value, LIMIT)

    def seconds(self, read: Callable[[], Value]) -> Callable[[], float]:
        """What reads seconds at entry."""
        return lambda: self.number(read(), SECONDS)

    def times(self, read: Callable[[], Value]) -> Callable[[], int]:
        """What reads a whole number of times at entry."""
        return lambda: int(self.number(read(), TIMES))

    # ---- variables -----------------------------------------------------------------------

    def assign(self, values: Mapping[str, Value]) -> str:
        """Give variables new values, one after another; tells which."""
        for name, value in values.items():
            self._scope.values[name] = self.resolve(value)
        return ", ".join(f"{name} = {_brief(self._scope.values[name])}" for name in values)

    def inputs(
        self, given: Mapping[str, Value], takes: Mapping[str, Type | None]
    ) -> dict[str, Any]:
        """What a named tree is given, each of the type that it wants. Raises MissionFailure."""
        found: dict[str, Any] = self.resolve(given)
        for name, value in found.items():
            wanted = takes.get(name)
            if wanted is not None and not fits(type_of(value), wanted):
                raise self.failure(f"'{name}': expected {WORDS[wanted]}, got {describe(value)}")
        return found

    def elements(self, value: Value) -> Sequence[Any]:
        """A list to go through."""
        found = self.resolve(value)
        if not isinstance(found, list):
            raise self.failure(f"expected a list, got {show(found)}")
        return found

    def loop(self, variable: str) -> tuple[Callable[[Any], None], Callable[[], None]]:
        """What sets the variable of a loop, and what takes it away."""
        values = self._scope.values
        return lambda element: values.update({variable: element}), lambda: values.pop(
            variable, None
        )

    # ---- decisions -----------------------------------------------------------------------

    def rounds(self) -> Rounds:
        """What ends a loop."""
        settings: RepeatSettings = self.node.settings
        return Rounds(
            None if settings.count is None else self.times(lambda: self.node.settings.count),
            None if settings.before is None else self.question(lambda: self.node.settings.before),
            None if settings.after is None else self.question(lambda: self.node.settings.after),
        )

    def question(self, read: Callable[[], Condition]) -> Question:
        """A condition on variables. Asking raises MissionFailure where it cannot be answered.

        While the variables that it reads hold the same plain values, the answer is the same.

        Args:
            read: Gives the condition, which is another one once the node was revised.
        """
        condition = read()
        answer = self._answers(condition)

        def ask() -> ConditionResult:
            nonlocal condition, answer
            present = read()
            if present is not condition:
                condition, answer = present, self._answers(present)
            return answer()

        return ask

    def _answers(self, condition: Condition) -> Question:
        if isinstance(condition, bool):
            constant = ConditionResult(condition, "always holds" if condition else "never holds")
            return lambda: constant
        variables = self._scope.values
        names = tuple(dict.fromkeys(name.name for name in condition.references))
        known: ConditionResult | None = None
        known_of: list[Any] = []

        def ask() -> ConditionResult:
            nonlocal known, known_of
            values = [variables.get(name) for name in names]
            if known is not None and all(map(is_, values, known_of)):
                return known
            verdict = self._judge(condition)
            is_lasting = not condition.draws and all(isinstance(one, _LASTING) for one in values)
            known, known_of = (verdict, values) if is_lasting else (None, [])
            return verdict

        return ask

    def _judge(self, condition: Expression) -> ConditionResult:
        variables = self._scope.values
        try:
            answer = condition.evaluate(variables, self._scope.random_for(self.path, condition))
        except ExpressionError as error:
            raise self.failure(str(error)) from error
        if not isinstance(answer, bool):
            raise self.failure(f"'{condition.text}' gave {show(answer)}, not a boolean")
        names = dict.fromkeys(name.name for name in condition.references)
        values = ", ".join(
            f"{name} = {_brief(variables[name])}" for name in names if name in variables
        )
        holds = "holds" if answer else "does not hold"
        return ConditionResult(answer, holds + (f" ({values})" if values else ""))

    def fork(self, read: Callable[[], Condition]) -> Callable[[], tuple[int, str]]:
        """What picks the first child where a condition holds, else the second."""
        ask = self.question(read)

        def pick() -> tuple[int, str]:
            verdict = ask()
            return 0 if verdict.holds else 1, verdict.text

        return pick

    def lot(self, count: int) -> Callable[[], tuple[int, str]]:
        """What draws one of so many children, by the weights of the node."""

        def draw() -> tuple[int, str]:
            random = self._scope.random(self.path)
            (index,) = random.choices(range(count), weights=self.node.weights or None)
            return index, f"drew {index + 1} of {count}"

        return draw

    # ---- conditions on messages ----------------------------------------------------------

    def condition(self, key: str, expression: Expression) -> Callable[[Any], str | None]:
        """What says whether a message meets a condition, with the values that it names."""
        random = self._scope.random_for(f"{self.path}/{key}", expression)

        def met(message: Any) -> str | None:
            fields = MessageFields(message)
            try:
                if not expression.evaluate(self._scope.values, random, fields):
                    return None
            except ExpressionError as error:
                where = f"{self.place}: '{self.node.label}' {key}"
                raise MissionFailure(f"{where}: {error}") from error
            values = values_read(expression, fields)
            return f"{expression.text}" + (f" ({values})" if values else "")

        return met

    def watch(self, key: str, expression: Expression) -> Callable[[Any], str | None] | None:
        """What asks a condition again once a variable that it reads has changed.

        A condition on variables alone is asked at once, without a message, too. None where it
        reads no variable.
        """
        variables = self._scope.values
        names = tuple(dict.fromkeys(name.name for name in expression.references))
        if not any(name.variable or name.name in variables for name in expression.references):
            return None
        needs_message = not all(name.variable for name in expression.references)
        met = self.condition(key, expression)
        known = [variables.get(name) for name in names] if needs_message else None

        def ask(message: Any) -> str | None:
            nonlocal known
            values = [variables.get(name) for name in names]
            is_same = known is not None and all(map(is_, values, known))
            if is_same or (needs_message and message is None):
                return None
            known = values
            said = met(message)
            if said is None or needs_message:
                return said
            read = zip(names, values, strict=True)
            return f"{said} ({', '.join(f'{name} = {_brief(value)}' for name, value in read)})"

        return ask

    def target(self, condition: Expression | None) -> tuple[str, float] | None:
        """The field and the bound of a condition such as ``current_image >= 5``."""
        match condition and condition.root:
            case Comparison(first=Name(variable=False) as name, rest=((sign, _, bound),)) if (
                sign in (">", ">=") and name.name not in self._scope.values
            ):
                random = self._scope.random_for(f"{self.path}/target", condition)
                nodes = Evaluation(self._scope.values, {}, random)
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
    """What a condition reads of a message, for people."""
    names = dict.fromkeys(name.name for name in condition.references if not name.variable)
    found = {name: fields[name] for name in names if name in fields}
    return ", ".join(
        f"{name} of {len(value)}" if isinstance(value, list) else f"{name} = {show(value)}"
        for name, value in found.items()
    )


def _brief(value: Any) -> str:
    return f"a list of {len(value)}" if isinstance(value, list) else show(value)
