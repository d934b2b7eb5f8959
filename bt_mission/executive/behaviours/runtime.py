"""The runtime of a mission's leaves: time, ledger, clients and variables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from random import Random
from typing import Any, Protocol

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.goals.goal import GoalClient
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.language.expressions.expression import draws
from bt_mission.language.follow import Follow


class MissionFailure(BtMissionError):  # noqa: N818 - it is the mission that fails, not our code
    """An error of the mission that occurs only while it runs; it ends the mission."""

    code = "BT-913"


@contextmanager
def placed(place: str) -> Iterator[None]:
    """Prefix errors of a node's set-up with the place of its step (``file:line:column``)."""
    try:
        yield
    except BtMissionError as error:
        raise MissionFailure(f"{place}: {error}", code=error.code or None) from error


class Generator(Random):
    """A random generator that records whether it was used since the last check."""

    was_drawn = False

    def random(self) -> float:
        """Return a float from 0 to 1, and note the use."""
        self.was_drawn = True
        return super().random()

    def getrandbits(self, k: int, /) -> int:
        """Return an integer of `k` random bits, and note the use."""
        self.was_drawn = True
        return super().getrandbits(k)


_NEVER_DRAWN = Random(0)


@dataclass
class Scope:
    """A mission's variables, and its seeded random generators.

    Args:
        values: Inputs, the outputs written so far, and the variables that follow topics.
        seed: The mission's seed; each node has a separate generator.
        followed: The variables that follow topics. Only the topic changes them.
    """

    values: dict[str, Any]
    seed: int
    generators: dict[str, Generator] = field(default_factory=dict)
    followed: tuple[Follow, ...] = ()
    evaluators: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    """The :class:`~bt_mission.executive.behaviours.evaluator.Evaluator` of each node, by path."""

    def inner(self, followed: tuple[Follow, ...] = ()) -> Scope:
        """Return the scope of a named tree: separate variables, the same generators."""
        return Scope({}, self.seed, self.generators, followed, self.evaluators)

    def written(self) -> dict[str, Any]:
        """The variables with their values, without those that follow topics."""
        names = {followed.variable for followed in self.followed}
        return {name: value for name, value in self.values.items() if name not in names}

    def replace(self, values: Mapping[str, Any]) -> None:
        """Replace the written values; variables that follow topics keep theirs."""
        for name in self.written():
            del self.values[name]
        self.values.update(values)

    def random(self, path: str) -> Random:
        """Return the generator of the node at ``path``, the same in every run of a seed."""
        if path not in self.generators:
            self.generators[path] = Generator(f"{self.seed}/{path}")
        return self.generators[path]

    def random_for(self, path: str, value: Any) -> Random:
        """Return a node's generator for one of its values: a separate one only if the value draws.

        A generator takes 2.5 KB, and most nodes never draw.
        """
        return self.random(path) if draws(value) else _NEVER_DRAWN


class ServiceClient(Protocol):
    """The client of a service, such as :class:`bt_mission.ros.clients.RosServiceClient`."""

    name: str

    def is_ready(self) -> bool:
        """Return whether a server is there."""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a request with these fields.

        Raises:
            BtMissionError: A value does not fit its field.
        """

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        """Send a request. Return a function that drops it; later responses are ignored."""


class LatestMessage(Protocol):
    """Messages of a topic, such as :class:`bt_mission.ros.subscriber.LatestMessageSubscriber`."""

    name: str

    def listen(self, listener: Callable[[Any], None]) -> None:
        """Pass messages to this listener from now on; the newest latched one at once."""

    def leave(self, listener: Callable[[Any], None]) -> None:
        """Hand nothing more to this listener."""

    def look_around(self) -> None:
        """Look at the graph. Called at every tick of a listener."""

    def why_silent(self) -> str:
        """Return what is known of the topic's publishers, as text."""


class Publisher(Protocol):
    """A publisher of a topic, such as :class:`bt_mission.ros.clients.TopicPublisher`."""

    name: str

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """Return a message with these fields.

        Raises:
            BtMissionError: A value does not fit its field.
        """

    def count_readers(self) -> int:
        """Return the number of matched subscriptions."""

    def publish(self, message: Any) -> None:
        """Send a message."""


class Runtime(Protocol):
    """The argument ``runtime`` of every node's ``setup``.

    A method that creates a client raises BtMissionError for a type that is not installed.
    """

    ledger: Ledger
    scope: Scope

    @property
    def now_ns(self) -> int:
        """ROS time, ns; the same throughout a tick."""

    def goal_client(self, action: str, type_name: str) -> GoalClient:
        """Return the client of an action; there is one for each name and type."""

    def service_client(self, service: str, type_name: str) -> ServiceClient:
        """Return the client of a service; there is one for each name and type."""

    def subscriber(self, topic: str, type_name: str) -> LatestMessage:
        """Return the messages of a topic; there is one object for each name and type."""

    def publisher(self, topic: str, type_name: str) -> Publisher:
        """Return the publisher of a topic; there is one for each name and type."""

    def log(self, text: str) -> None:
        """Log a line for viewers of the mission."""

    def warn(self, text: str) -> None:
        """Log a warning of the node; no trace has it."""


def read_field(message: Any, dotted: str) -> Any:
    """Return a field of a message by its dotted name; arrays as lists."""
    value = message
    for name in dotted.split("."):
        value = getattr(value, name)
    return value.tolist() if hasattr(value, "tolist") else value


def scalars(message: Any) -> Mapping[str, float | int | bool | str]:
    """The top-level fields of a message that are plain values, by name."""
    if message is None:
        return {}
    return {
        name: value
        for name in message.get_fields_and_field_types()
        if isinstance(value := getattr(message, name), bool | int | float | str)
    }
