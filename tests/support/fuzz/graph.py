"""A ROS graph without ROS around it: real types, and servers that do as a seed says."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache
from random import Random
from typing import Any

from bt_mission.executive.behaviours.runtime import Scope
from bt_mission.executive.goals.goal import Goal, GoalTrigger
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.message_types import ListOf, MessageShape, Scalar, Shape
from bt_mission.ros import interface_types

S = 1_000_000_000
STEPS_NS = (S // 20, S // 20, S, 30 * S)
"""How far the clock goes from one tick to the next."""

NUMBERS = (0.0, 1.0, -1.0, 0.5, 90.0, -0.25, 3.0, 1e-9, 1e30, 7.25)
VARIANTS = 6
"""Different messages of each type."""


@cache
def messages(message_class: Any) -> tuple[Any, ...]:
    """Return some messages of a type, the same in every run; one has numbers that are none."""
    rng = Random(message_class.__qualname__)
    shape = interface_types.shape_of(message_class)
    made = [interface_types.fill(message_class(), _value(rng, shape)) for _ in range(VARIANTS)]
    for name, part in shape.fields.items():
        if isinstance(part, Scalar) and part.name in ("float32", "float64"):
            setattr(made[-1], name, rng.choice((math.nan, math.inf)))
    return (message_class(), *made)


def _value(rng: Random, shape: Shape) -> Any:
    match shape:
        case MessageShape():
            return {name: _value(rng, part) for name, part in shape.fields.items()}
        case ListOf():
            count = (
                shape.size if shape.size is not None else rng.randint(0, min(shape.most or 3, 3))
            )
            return [_value(rng, shape.item) for _ in range(count)]
    match shape.type:
        case "bool":
            return rng.random() < 0.5
        case "text":
            return rng.choice(("", "a", "é", "$x", "1"))[: int(min(shape.most, 9))]
        case "integer":
            number = rng.choice((0, 1, 2, 7, -1, int(shape.most), int(shape.least)))
            return max(int(shape.least), min(number, int(shape.most)))
    return rng.choice(NUMBERS)


class Server:
    """The client of an action whose server does as its luck says."""

    def __init__(self, name: str, type_name: str, luck: Random) -> None:
        self.name = name
        self.is_delaying = True
        self._type = interface_types.action_type(type_name)
        self._luck = luck
        self._asked: list[Goal] = []
        self._running: list[Goal] = []
        self._cancels: list[Goal] = []

    def is_ready(self) -> bool:
        return self._luck.random() > 0.01

    def obstacle(self) -> str:
        return ""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return interface_types.fill(self._type.Goal(), fields)

    def send(self, goal: Goal, request: Any) -> None:
        self._asked.append(goal)

    def ask_result(self, goal: Goal) -> None:
        self._running.append(goal)

    def send_cancel(self, goal: Goal) -> None:
        self._cancels.append(goal)

    def move(self) -> None:
        """Answer some of what is open; all of it once patience has ended."""
        asked, self._asked = self._asked, []
        for goal in asked:
            if self.is_delaying and self._luck.random() < 0.1:
                self._asked.append(goal)
            else:
                goal.on(GoalTrigger.REJECTED if self._luck.random() < 0.1 else GoalTrigger.ACCEPTED)
        cancels, self._cancels = self._cancels, []
        for goal in cancels:
            if self.is_delaying and self._luck.random() < 0.1:
                goal.on(GoalTrigger.CANCEL_REFUSED)
            else:
                goal.on_result(5, self._luck.choice(messages(self._type.Result)))
        running, self._running = self._running, []
        for goal in running:
            if self._luck.random() < 0.5:
                goal.on_feedback(self._luck.choice(messages(self._type.Feedback)))
            if self._luck.random() < 0.75 and goal.is_live:
                self._running.append(goal)
            elif goal.is_live:
                status = self._luck.choice((4, 4, 4, 4, 5, 6, 0))
                goal.on_result(status, self._luck.choice(messages(self._type.Result)))


class Service:
    """The client of a service whose server answers by luck."""

    def __init__(self, name: str, type_name: str, luck: Random) -> None:
        self.name = name
        self._type = interface_types.service_type(type_name)
        self._luck = luck
        self._open: list[Callable[[Any], None]] = []

    def is_ready(self) -> bool:
        return self._luck.random() > 0.2

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return interface_types.fill(self._type.Request(), fields)

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        self._open.append(on_answer)
        return lambda: self._open.remove(on_answer) if on_answer in self._open else None

    def move(self) -> None:
        if self._open and self._luck.random() < 0.5:
            self._open.pop(0)(self._luck.choice(messages(self._type.Response)))


class Topic:
    """The messages of a topic, which come by luck, and a publisher for it."""

    def __init__(self, name: str, type_name: str, luck: Random) -> None:
        self.name = name
        self._type = interface_types.message_type(type_name)
        self._luck = luck
        self._listeners: list[Callable[[Any], None]] = []

    def listen(self, listener: Callable[[Any], None]) -> None:
        self._listeners.append(listener)

    def leave(self, listener: Callable[[Any], None]) -> None:
        self._listeners = [known for known in self._listeners if known != listener]

    def look_around(self) -> None:
        pass

    def why_silent(self) -> str:
        return "it has no publisher"

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        return interface_types.fill(self._type(), fields)

    def count_readers(self) -> int:
        return self._luck.randrange(3)

    def publish(self, message: Any) -> None:
        pass

    def move(self) -> None:
        for listener in tuple(self._listeners):
            if self._luck.random() < 0.5:
                listener(self._luck.choice(messages(self._type)))


class Graph:
    """The runtime of a mission."""

    def __init__(self, scope: Scope, luck: Random) -> None:
        self.now_ns = S
        self.scope = scope
        self.ledger = Ledger(scope.seed, 3 * S)
        self.luck = luck
        self._parts: dict[tuple[str, str, str], Any] = {}

    def move(self) -> None:
        """Let time go on, and everybody do something."""
        self.now_ns += self.luck.choice(STEPS_NS)
        for part in self._parts.values():
            part.move()

    def stop_delaying(self) -> None:
        """Have every goal answered from now on."""
        for part in self._parts.values():
            part.is_delaying = False

    def goal_client(self, action: str, type_name: str) -> Any:
        return self._part(Server, action, type_name)

    def service_client(self, service: str, type_name: str) -> Any:
        return self._part(Service, service, type_name)

    def subscriber(self, topic: str, type_name: str) -> Any:
        return self._part(Topic, topic, type_name)

    def publisher(self, topic: str, type_name: str) -> Any:
        return self._part(Topic, topic, type_name)

    def warn(self, text: str) -> None:
        pass

    def log(self, text: str) -> None:
        pass

    def _part(self, kind: Any, name: str, type_name: str) -> Any:
        key = (kind.__name__, name, type_name)
        if key not in self._parts:
            self._parts[key] = kind(name, type_name, self.luck)
        return self._parts[key]
