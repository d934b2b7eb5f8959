"""The leaf that publishes one message, once somebody listens."""

from __future__ import annotations

from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.evaluator import Evaluator
from bt_mission.behaviours.leaves import Leaf
from bt_mission.behaviours.runtime import Publisher, Runtime, placed
from bt_mission.core.stamps import NS
from bt_mission.language.nodes.interfaces import PublishNode


class PublishLeaf(Leaf):
    """Publishes a message each time it starts, as soon as so many subscriptions are matched.

    It fails when they are not there in time.
    """

    def __init__(self, node: PublishNode, values: Evaluator) -> None:
        super().__init__(node.label)
        self._node = node
        self._values = values
        self._message: Any = None
        self._until_ns = 0
        self._runtime: Runtime
        self._publisher: Publisher

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime and make the publisher."""
        self._runtime = kwargs["runtime"]
        with placed(self._values.place):
            self._publisher = self._runtime.publisher(self._node.ros_name, self._node.type)

    def initialise(self) -> None:
        """Make the message.

        Raises:
            MissionFailure: When a value does not fit its field.
        """
        with self._values.starting():
            self._message = self._publisher.prepare(self._values.resolve(self._node.sent))
        self._until_ns = self._runtime.now_ns + round(self._node.server_timeout * NS)

    def update(self) -> Status:
        """Publish it once it is heard."""
        there = self._publisher.count_readers()
        if there >= self._node.readers:
            self._publisher.publish(self._message)
            self.feedback_message = f"published to {there}" if there else "published to nobody"
            return Status.SUCCESS
        wanted = "nobody listens" if there == 0 else f"{there} of {self._node.readers} listen"
        self.feedback_message = f"{wanted} to {self._publisher.name}"
        if self._runtime.now_ns < self._until_ns:
            return Status.RUNNING
        self.feedback_message += f" after {self._node.server_timeout:g} s"
        return Status.FAILURE
