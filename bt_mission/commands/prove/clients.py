"""Services, topics, publishers, Python classes and draws that may answer anything."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import partial
from random import Random
from typing import Any

from py_trees.common import Status

from bt_mission.commands.prove.answers import ANSWERS, SILENT, Answer, AnswerSet
from bt_mission.commands.prove.choices import NOTHING, Choices, Possibility
from bt_mission.commands.prove.domains import attribute_domain
from bt_mission.commands.prove.goal_servers import MOST_DELAYS, Question
from bt_mission.commands.prove.uses import Use
from bt_mission.commands.prove.values import (
    Known,
    Message,
    ValueCases,
    assign,
    default_fields,
    more_words,
)
from bt_mission.executive.behaviours.client_leaves import ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.leaves import Leaf
from bt_mission.executive.behaviours.runtime import Generator
from bt_mission.language.follow import Follow
from bt_mission.ros.interface_types import fill, service_type, topic_type


class Service:
    """A service that may answer anything; implements ``ServiceClient``."""

    def __init__(
        self,
        name: str,
        type_name: str,
        choices: Choices,
        answers: AnswerSet,
        cases: ValueCases,
        callers: Callable[[], Iterable[ServiceLeaf]],
        evaluator_of: Callable[[Any], Evaluator],
        on_use: Callable[[Service], None],
    ) -> None:
        self.name = name
        self._type = service_type(type_name)
        self._choices, self._answers, self._cases = choices, answers, cases
        self._callers, self._evaluator_of = callers, evaluator_of
        self._on_use = on_use
        self.is_away = False
        self.on_response: Callable[[Mapping[str, Any]], None] = _ignore
        """Called with the fields of each response."""
        self.calls: list[tuple[ServiceLeaf, Callable[[Any], None]]] = []
        """The leaves that wait for an answer, and what takes it."""
        self.is_mute = False
        self.is_seen = False
        """Has the present tick looked for it? It sees the same each time."""
        self.delays = 0
        """The ticks for which the answer was not there yet, though something happened."""
        self.is_untimed = False
        """May answers be late by any number of ticks?"""
        self.is_cut = Known()
        """Holds something if an answer might have been later than it was."""

    @property
    def has_success(self) -> bool:
        """Do its responses say whether they are a success?"""
        return hasattr(self._type.Response(), "success")

    def is_ready(self) -> bool:
        """Choose whether there is a server."""
        self._on_use(self)
        if self.is_seen:
            return not self.is_away
        self.is_seen = True
        rows = self._answers.at("missing" if self.is_away else "found", self.name)
        options = [_option(self.name, row) for row in rows]
        self.is_away = rows[self._choices.choose(options)].name in ("no_server", "away")
        return not self.is_away

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a request with these fields. Raises FillError."""
        return fill(self._type.Request(), fields)

    def call(self, _request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        """Take a call; return what forgets it."""
        self._on_use(self)
        leaf = next(leaf for leaf in self._callers() if leaf.answers.append == on_answer)
        call = leaf, on_answer
        self.calls.append(call)
        self.is_mute, self.delays = False, 0

        def forget() -> None:
            if call in self.calls:
                self.calls.remove(call)

        return forget

    def questions(self) -> Iterator[Question]:
        """Yield what may happen to the oldest call."""
        if not self.calls or self.is_mute:
            return
        options: list[Possibility] = []
        for row in self._answers.at("called", self.name):
            if row.name == "no_response":
                options.append(_option(self.name, row, self._fall_silent))
                continue
            if row.name == "fail" and not self.has_success:
                continue
            for fields, faults, _ in self._responses():
                given = {"success": row.name != "fail", **fields}
                respond = partial(self._respond, given)
                option = _option(self.name, row, respond, more_words(fields))
                options.append(option._replace(faults=option.faults + faults))
        if self.is_untimed:
            options.append(NOTHING)
        elif self.delays < MOST_DELAYS:
            options.append(NOTHING._replace(act=self._delay))
        else:
            self.is_cut[MOST_DELAYS] = True
        yield tuple(options)

    def _delay(self) -> None:
        self.delays += 1

    @property
    def is_owed(self) -> bool:
        """Does it owe an answer that it will give?"""
        return bool(self.calls) and not self.is_mute

    def _fall_silent(self) -> None:
        self.is_mute, self.delays = True, 0

    def _respond(self, fields: Mapping[str, Any]) -> None:
        self.delays = 0
        (_, answer), response = self.calls.pop(0), self._type.Response()
        known = {name: value for name, value in fields.items() if _has(response, name)}
        self.on_response(known)
        answer(assign(response, known))

    def _responses(self) -> list[Message]:
        outputs = self._evaluator_of(self.calls[0][0]).node.outputs
        responses = self._cases.of_outputs(outputs, self._type.Response(), ("success",))
        return self._cases.considered(responses, self._answers, self.name)

    def key(self, names: Collection[str] | None) -> tuple[Any, ...]:
        """Return its state, its delays apart.

        Args:
            names: Of the services that a leaf may still call; None for all.
        """
        callers = [self._evaluator_of(leaf).path for leaf, _ in self.calls]
        is_away = self.is_away and (names is None or self.name in names)
        return self.name, is_away, tuple(callers), self.is_mute and bool(callers)


class Topic:
    """A topic on which anything may be published; implements ``LatestMessage``.

    A message is one object: each field that somebody reads has each of its values. Between two
    ticks as many messages may come as there are readers.
    """

    def __init__(
        self,
        name: str,
        type_name: str,
        answers: AnswerSet,
        cases: ValueCases,
        waiting: Callable[[Topic], list[WaitFor]],
        evaluator_of: Callable[[Any], Evaluator],
        follows: list[Follow],
    ) -> None:
        self.name = name
        self._type = topic_type(type_name)
        self._answers, self._cases = answers, cases
        self._waiting, self._evaluator_of = waiting, evaluator_of
        self._follows = follows
        self.listeners: list[Callable[[Any], None]] = []
        self.on_message: Callable[[Mapping[str, Any]], None] = _ignore
        """Called with the fields of each message."""
        self.value: Mapping[str, Any] | None = None
        """The followed fields of the newest message; None before the first one."""
        self.is_quiet = False
        self.is_age_loose = False
        """May its newest message be too old at any tick, once it sends nothing more?"""
        self.age_s = 0.0
        """How old its newest message is at least, s, where that is abstract."""
        self.is_aged = Known()
        """Holds something if its newest message may have become too old at any tick."""
        self.count = 0
        """The number of its messages."""
        self._followed: dict[str, list[str]] = Known()
        for follow in follows:
            self._followed.setdefault(follow.settings.field, []).append(follow.variable)

    @property
    def has_limit(self) -> bool:
        """Does a variable become too old without new messages?"""
        return any(follow.settings.timeout is not None for follow in self._follows)

    def listen(self, listener: Callable[[Any], None]) -> None:
        """Hand messages to a listener."""
        self.listeners.append(listener)

    def leave(self, listener: Callable[[Any], None]) -> None:
        """Hand it no more."""
        if listener in self.listeners:
            self.listeners.remove(listener)

    def look_around(self) -> None:
        """The graph does not matter."""

    def why_silent(self) -> str:
        """Return what is known of the publishers."""
        return "nothing was published"

    def beat(self) -> None:
        """Publish the last value again, where it would become too old otherwise."""
        if self.has_limit and self.value is not None and not self.is_quiet:
            self._publish(self.value)

    def questions(self) -> Iterator[Question]:
        """Yield which messages may come."""
        waiting = self._waiting(self)
        options = self._messages(waiting)
        if options:
            for _ in range(len(waiting) + bool(self._follows)):
                yield (NOTHING, *options)
        if ages := self.ages_left:
            self.is_aged[self.name] = True
            words = [f"{self.name} is silent for {age_s:g} s" for age_s in ages]
            acts = [partial(self._age, age_s) for age_s in ages]
            yield (
                NOTHING,
                *(Possibility(text, 0, act) for text, act in zip(words, acts, strict=True)),
            )

    @property
    def ages_left(self) -> list[float]:
        """The ages that its newest message may still reach at any tick, s."""
        if not (self.is_quiet and self.is_age_loose):
            return []
        ages = {follow.settings.timeout or 0.0 for follow in self._follows}
        return sorted(age_s for age_s in ages if age_s > self.age_s)

    def _age(self, age_s: float) -> None:
        self.age_s = age_s

    def _messages(self, waiting: list[WaitFor]) -> list[Possibility]:
        if self.is_quiet or not (waiting or self._follows):
            return []
        row = ANSWERS["value" if self._follows else "message"]
        options = []
        for fields, faults, _ in self._differing(waiting):
            if self._changes_something(fields, waiting):
                words = more_words(fields).removeprefix(",")
                option = _option(self.name, row, partial(self._send, fields), words)
                options.append(option._replace(faults=faults))
        if self.has_limit and self.value is not None:
            options += [
                _option(self.name, row, self._fall_quiet)
                for row in self._answers.at("followed", self.name)
                if row.name == "quiet"
            ]
        return options

    def _differing(self, waiting: list[WaitFor]) -> list[Message]:
        read = {name: list(variables) for name, variables in self._followed.items()}
        conditions: list[Use] = []
        variables: dict[str, Any] = {}
        for leaf in waiting:
            values = self._evaluator_of(leaf)
            for name, variable in values.node.outputs.items():
                read.setdefault(name, []).append(variable)
            conditions.append(self._cases.condition_of(values.node))
            variables |= values.scope.values
        message = self._cases.message(self._type, {})
        messages = self._cases.messages(message, read, conditions, variables, self._followed)
        return self._cases.considered(messages, self._answers, self.name)

    def _changes_something(self, fields: Mapping[str, Any], waiting: list[WaitFor]) -> bool:
        """Does a message give a followed variable another value, or end a wait?"""
        if self._follows and repr(self._kept(fields)) != repr(self.value):
            return True
        message = self._cases.message(self._type, fields)
        for leaf in waiting:
            values = self._evaluator_of(leaf)
            use = self._cases.condition_of(values.node)
            if self._cases.answer(use, message, values.scope.values) is not False:
                return True
        return False

    def _kept(self, fields: Mapping[str, Any]) -> Mapping[str, Any]:
        message = self._cases.message(self._type, fields)
        return default_fields(message, self._followed)

    def _fall_quiet(self) -> None:
        self.is_quiet = True

    def _send(self, fields: Mapping[str, Any]) -> None:
        if self._follows:
            self.value = self._kept(fields)
        self._publish(fields)

    def _publish(self, fields: Mapping[str, Any]) -> None:
        self.count += 1
        self.on_message(fields)
        message = self._cases.message(self._type, fields)
        for listener in tuple(self.listeners):
            listener(message)

    @property
    def key(self) -> tuple[Any, ...]:
        """Its state. Nobody reads the value of one that sends nothing more."""
        if self.is_quiet:
            return self.name, self.age_s
        return self.name, repr(self.value)


class Speech:
    """A topic on which a mission publishes; implements ``Publisher``."""

    def __init__(self, name: str, type_name: str, choices: Choices, answers: AnswerSet) -> None:
        self.name = name
        self._type = topic_type(type_name)
        self._choices, self._answers = choices, answers
        self.is_away = False

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a message with these fields. Raises FillError."""
        return fill(self._type(), fields)

    def count_readers(self) -> int:
        """Choose whether there are enough subscriptions."""
        rows = self._answers.at("readers", self.name)
        if self.is_away:
            rows = [row for row in rows if row.name == "readers"] + self._answers.at(
                "missing", self.name
            )[1:]
        row = rows[self._choices.choose([_option(self.name, row) for row in rows])]
        self.is_away = row.name != "readers"
        return 0 if self.is_away else 1_000

    def publish(self, _message: Any) -> None:
        """Nobody reads it."""

    def key(self, names: Collection[str] | None) -> tuple[Any, ...]:
        """Return its state.

        Args:
            names: Of the topics on which a leaf may still publish; None for all.
        """
        return self.name, self.is_away and (names is None or self.name in names)


class AnyBehaviour(Leaf):
    """Stands for a class of the user's: returns each status, or raises."""

    _choices: Choices
    _answers: AnswerSet
    _cases: ValueCases

    def __init__(self, node: Any, values: Evaluator) -> None:
        super().__init__(node, values)
        self._domains = Known()
        self.answer = ""
        """The name of the row, or "running"."""
        self.on_answer: Callable[[], None] = _ignore
        """Called at each tick with the answer and the values of outputs."""

    def setup(self, **kwargs: Any) -> None:
        """Take the environment."""
        super().setup(**kwargs)
        environment = kwargs["runtime"]
        self._choices, self._answers, self._cases = (
            environment.choices,
            environment.answers,
            environment.cases,
        )

    def initialise(self) -> None:
        """Evaluate the inputs. Raises MissionFailure."""
        self._values.resolve(self._node.inputs)
        self.answer = ""

    def update(self) -> Status:
        """Choose at entry; later the answer follows from :meth:`questions`."""
        if not self.answer:
            rows = self._answers.at("python", self.name)
            index = self._choices.choose([_option(f"'{self.name}'", row) for row in rows])
            self.answer = rows[index].name
        if self.answer not in ("raise", "running"):
            self._write_outputs()
        self.on_answer()
        if self.answer == "raise":
            raise RuntimeError(f"raised by {self._node.target}")
        if self.answer == "running":
            return Status.RUNNING
        return Status.SUCCESS if self.answer == "success" else Status.FAILURE

    @property
    def outputs(self) -> dict[str, Any]:
        """The values of its attributes that variables read."""
        values = self._values.scope.values
        return {name: values[variable] for name, variable in self._node.outputs.items()}

    def _write_outputs(self) -> None:
        for attribute, variable in self._node.outputs.items():
            if attribute not in self._domains:
                domain = attribute_domain(self._node, self._values.file, attribute)
                self._domains[attribute] = domain or self._cases.guessed(variable, self.name)
            cases = self._cases.of(self._domains[attribute], variable)
            cases = self._cases.considered(cases, self._answers, self.name)
            cases = [case for case in cases if case.value == case.value]  # NaN: it raises
            options = [
                Possibility(f"'{self.name}' gives {variable} = {case.value!r}", case.faults)
                for case in cases
            ]
            index = self._choices.choose(options) if len(options) > 1 else 0
            self._values.scope.values[variable] = cases[index].value

    def questions(self) -> Iterator[Question]:
        """Yield how it may end, while it runs."""
        if self.status is Status.RUNNING and self.answer == "running":
            rows = [
                entry for entry in self._answers.at("python", self.name) if entry.name != "running"
            ]
            yield (
                NOTHING,
                *(_option(f"'{self.name}'", row, partial(self._take, row.name)) for row in rows),
            )

    def _take(self, answer: str) -> None:
        self.answer = answer


class Draw(Random):
    """A generator whose every draw is a choice.

    Args:
        name: Of the node that draws.
        values: Returns the values that a draw from 0 to 1 may have.
    """

    def __init__(
        self, name: str, choices: Choices, values: Callable[[], tuple[float, ...]]
    ) -> None:
        super().__init__(0)
        self._name, self._choices, self._values = name, choices, values
        self._options: dict[tuple[float, ...], tuple[Possibility, ...]] = Known()

    def random(self) -> float:
        """Choose a number."""
        values = self._values()
        if len(values) == 1:
            return values[0]
        if values not in self._options:
            self._options[values] = tuple(
                Possibility(f"{self._name} draws {value:.3g} of 1") for value in values
            )
        return values[self._choices.choose(self._options[values])]

    def choices(
        self, population: Any, weights: Any = None, *, cum_weights: Any = None, k: int = 1
    ) -> list[Any]:
        """Choose one; those of weight 0 are never drawn."""
        del cum_weights, k
        possible = [
            entry for index, entry in enumerate(population) if weights is None or weights[index] > 0
        ]
        options = [Possibility(f"{self._name} draws {entry + 1}") for entry in possible]
        return [possible[self._choices.choose(options)]]


class NamedGenerators(dict[str, Generator]):
    """Makes a generator for each name.

    Args:
        draw: Returns the generator of a name.
    """

    def __init__(self, draw: Callable[[str], Draw]) -> None:
        super().__init__()
        self._draw = draw

    def __contains__(self, _name: object) -> bool:
        return True

    def __missing__(self, name: str) -> Any:
        self[name] = self._draw(name)  # type: ignore[assignment]
        return self[name]


def _option(
    name: str, row: Answer, act: Callable[[], None] | None = None, more: str = ""
) -> Possibility:
    words = f"{name} {row.words}{more}" if row.words else ""
    return Possibility(words, row.faults, act, row.name not in SILENT)


def _ignore(*_: Any) -> None:
    """Note nothing."""


def _has(message: Any, dotted: str) -> bool:
    return dotted in default_fields(message, [dotted])
