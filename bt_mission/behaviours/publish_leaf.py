"""The leaf that publishes one message, once somebody listens."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.leaf import Leaf
from bt_mission.behaviours.runtime import NS, MissionFailure, Publisher, Runtime, placed
from bt_mission.core.errors import BtMissionError


class PublishLeaf(Leaf):
    """Publishes a message each time it starts, as soon as so many subscriptions are matched.

    It fails when they are not there in time.

    :param topic: name of the topic, such as ``/lamp``.
    :param type_name: its type, such as ``std_msgs/msg/Bool``.
    :param fields: gives the fields of the message, at each start.
    :param readers: how many subscriptions to wait for.
    :param limit_s: how long to wait for them, s.
    :param place: ``file:line:column`` of the step.
    """

    def __init__(
        self,
        name: str,
        topic: str,
        type_name: str,
        fields: Callable[[], Mapping[str, Any]],
        readers: int,
        limit_s: float,
        place: str,
    ) -> None:
        super().__init__(name)
        self.topic = topic
        self.type_name = type_name
        self._fields = fields
        self._readers = readers
        self._limit_s = limit_s
        self._place = place
        self._message: Any = None
        self._until_ns = 0
        self._runtime: Runtime
        self._speech: Publisher

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and make the publisher."""
        self._runtime = kwargs["runtime"]
        with placed(self._place):
            self._speech = self._runtime.publisher(self.topic, self.type_name)

    def initialise(self) -> None:
        """Make the message.

        :raises MissionFailure: when a value does not fit its field.
        """
        try:
            self._message = self._speech.prepare(self._fields())
        except BtMissionError as error:
            raise MissionFailure(f"{self._place}: '{self.name}' cannot start: {error}") from error
        self._until_ns = self._runtime.now_ns + round(self._limit_s * NS)

    def update(self) -> Status:
        """Publish it once it is heard."""
        there = self._speech.count_readers()
        if there >= self._readers:
            self._speech.publish(self._message)
            self.feedback_message = f"published to {there}" if there else "published to nobody"
            return Status.SUCCESS
        wanted = "nobody listens" if there == 0 else f"{there} of {self._readers} listen"
        self.feedback_message = f"{wanted} to {self._speech.name}"
        if self._runtime.now_ns < self._until_ns:
            return Status.RUNNING
        self.feedback_message += f" after {self._limit_s:g} s"
        return Status.FAILURE
