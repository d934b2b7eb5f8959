"""What the leaves of a tree are given when a mission starts."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from random import Random
from typing import Any, Protocol

from bt_mission.core.errors import BtMissionError
from bt_mission.goals.goal import GoalClient
from bt_mission.goals.ledger import Ledger
from bt_mission.language.expressions.expression import draws
from bt_mission.language.follow import Follow


class MissionFailure(BtMissionError):  # noqa: N818 - it is the mission that fails, not our code
    """A fault of the mission itself that shows only while it runs; it ends the mission."""


@contextmanager
def placed(place: str) -> Iterator[None]:
    """Put the place of a step (``file:line:column``) before what goes wrong in its set-up."""
    try:
        yield
    except BtMissionError as error:
        raise MissionFailure(f"{place}: {error}") from error


class Generator(Random):
    """A random generator that tells whether it was drawn from since somebody looked."""

    was_drawn = False

    def random(self) -> float:
        """As in the base class."""
        self.was_drawn = True
        return super().random()

    def getrandbits(self, k: int, /) -> int:
        """As in the base class."""
        self.was_drawn = True
        return super().getrandbits(k)


_NEVER_DRAWN = Random(0)


@dataclass
class Scope:
    """A mission's variables, and its seeded random generators.

    Args:
        values: Inputs, the outputs written so far, and the variables that follow topics.
        seed: The mission's seed; each node draws from a generator of its own.
        followed: Which of them follow topics. Nobody but the topic changes those.
    """

    values: dict[str, Any]
    seed: int
    generators: dict[str, Generator] = field(default_factory=dict)
    followed: tuple[Follow, ...] = ()
    evaluators: dict[str, Any] = field(default_factory=dict, repr=False, compare=False)
    """The :class:`~bt_mission.behaviours.evaluator.Evaluator` of each node, by the node's path."""

    def inner(self, followed: tuple[Follow, ...] = ()) -> Scope:
        """A scope for a named tree: variables of its own, the same generators."""
        return Scope({}, self.seed, self.generators, followed, self.evaluators)

    def written(self) -> dict[str, Any]:
        """The variables with their values, those that follow topics left out."""
        names = {followed.variable for followed in self.followed}
        return {name: value for name, value in self.values.items() if name not in names}

    def replace(self, values: Mapping[str, Any]) -> None:
        """Take these values instead of those written; what follows a topic stays as it is."""
        for name in self.written():
            del self.values[name]
        self.values.update(values)

    def random(self, path: str) -> Random:
        """The generator of the node at ``path``, the same in every run of one seed."""
        if path not in self.generators:
            self.generators[path] = Generator(f"{self.seed}/{path}")
        return self.generators[path]

    def random_for(self, path: str, value: Any) -> Random:
        """The generator of a node for one of its values: its own only where that draws.

        A generator takes 2.5 KB, and most nodes never draw.
        """
        return self.random(path) if draws(value) else _NEVER_DRAWN


class ServiceClient(Protocol):
    """The client of a service: :class:`bt_mission.ros.clients.RosServiceClient`, for one."""

    name: str

    def is_ready(self) -> bool:
        """Is there a server?"""

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A request with these fields.

        Raises:
            BtMissionError: When a value does not fit its field.
        """

    def call(self, request: Any, on_answer: Callable[[Any], None]) -> Callable[[], None]:
        """Send a request; gives a function that forgets it, after which no answer is heard."""


class LatestMessage(Protocol):
    """Messages of a topic: :class:`bt_mission.ros.subscriber.LatestMessageSubscriber`, for one."""

    name: str

    def listen(self, listener: Callable[[Any], None]) -> None:
        """Hand messages to this listener from now on; the newest latched one at once."""

    def leave(self, listener: Callable[[Any], None]) -> None:
        """Hand nothing more to this listener."""

    def look_around(self) -> None:
        """Look at the graph, at every tick of somebody who listens."""

    def why_silent(self) -> str:
        """What is known of the topic's publishers, for people."""


class Publisher(Protocol):
    """Messages for a topic: :class:`bt_mission.ros.clients.TopicPublisher`, for one."""

    name: str

    def prepare(self, fields: Mapping[str, Any]) -> Any:
        """A message with these fields.

        Raises:
            BtMissionError: When a value does not fit its field.
        """

    def count_readers(self) -> int:
        """How many subscriptions are matched."""

    def publish(self, message: Any) -> None:
        """Send a message."""


class Runtime(Protocol):
    """Handed to every node's ``setup`` as ``runtime``.

    What makes a client raises BtMissionError for a type that is not installed.
    """

    ledger: Ledger
    scope: Scope

    @property
    def now_ns(self) -> int:
        """ROS time, ns; the same throughout a tick."""

    def goal_client(self, action: str, type_name: str) -> GoalClient:
        """The client of an action; one for each name and type."""

    def service_client(self, service: str, type_name: str) -> ServiceClient:
        """The client of a service; one for each name and type."""

    def subscriber(self, topic: str, type_name: str) -> LatestMessage:
        """The messages of a topic; one for each name and type."""

    def publisher(self, topic: str, type_name: str) -> Publisher:
        """The publisher of a topic; one for each name and type."""

    def log(self, text: str) -> None:
        """Say something to the people who watch the mission."""

    def warn(self, text: str) -> None:
        """Write a warning to the node's log; it is in no trace."""


def read_field(message: Any, dotted: str) -> Any:
    """A field of a message by its dotted name; arrays come as lists."""
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
