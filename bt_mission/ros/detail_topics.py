"""What a mission is doing, for people and tools that look on: ``~/details`` and ``~/log``.

Nothing is made up for nobody: without a subscription a tick costs one look at the watch, and ten
times a second one question to the middleware.
With one, wall time paces the messages, not the mission's clock, which may run a hundred times as
fast: who looks on must not slow down what is looked at.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_mission_interfaces.msg import MissionDetails, MissionLog
from builtin_interfaces.msg import Time
from rclpy.qos import QoSProfile

from bt_mission.behaviours.runtime import NS
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.ros.mission_details import MissionDetailsBuilder

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour
    from rclpy.node import Node

    from bt_mission.ros.mission_run import MissionRun

DETAILS = QoSProfile(depth=10)
LOG = QoSProfile(depth=100)

EVERY_S = 0.1
"""Wall time between two messages."""

COMPLETE_EVERY = 10
"""Every so many messages all goals and variables are told, not only those that have changed."""


class DetailTopics:
    """Publishes what a mission does, while somebody listens.

    :param node: owns the topics; their names begin with its own.
    """

    def __init__(self, node: Node) -> None:
        self._details = node.create_publisher(MissionDetails, "~/details", DETAILS)
        self._log = node.create_publisher(MissionLog, "~/log", LOG)
        self._since_last = Stopwatch()
        self._run = ""
        self._mission: MissionDetailsBuilder | None = None
        self._count = 0

    def begin(self, run: str, mission: MissionRun, indices: dict[Behaviour, int]) -> None:
        """Follow a mission that starts."""
        self._run, self._mission = run, MissionDetailsBuilder(run, mission, indices)
        self._count = 0
        mission.log_listeners.append(self._on_log)

    def flush(self, *, at_once: bool = False) -> None:
        """Publish, if it is time and somebody listens.

        :param at_once: do not wait until it is time: the mission's state has changed.
        """
        if self._mission is None:
            return
        if not at_once and self._since_last.elapsed_s < EVERY_S:
            return
        self._since_last = Stopwatch()
        if not self._details.get_subscription_count():
            self._count = 0
            return
        complete = self._count % COMPLETE_EVERY == 0
        self._count += 1
        self._details.publish(self._mission.describe(complete=complete))

    def _on_log(self, time_ns: int, text: str) -> None:
        if self._log.get_subscription_count():
            self._log.publish(MissionLog(stamp=_stamp(time_ns), run=self._run, text=text))


def _stamp(time_ns: int) -> Time:
    seconds, nanoseconds = divmod(time_ns, NS)
    return Time(sec=seconds, nanosec=nanoseconds)
