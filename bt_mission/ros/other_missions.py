"""Other missions on the robot of a mission: each goal that drives replaces a goal of the other."""

from __future__ import annotations

from functools import partial
from typing import Any

from bt_mission_interfaces.msg import MissionState

from bt_mission.base.diagnostics import listed, quoted
from bt_mission.executive.events.events import FINAL
from bt_mission.ros.discovery import STATE_TYPE
from bt_mission.ros.graph import LATCHED
from bt_mission.ros.mission_runner import MissionRunner

LOOK_S = 1.0
"""ROS time between two looks for executives."""


class OtherMissions:
    """Names the missions that run on a robot besides one, by the states that they publish.

    A warning names each of them once. Destroying the node of the mission ends it.

    Args:
        runner: Of the mission.
    """

    def __init__(self, runner: MissionRunner) -> None:
        self._runner, self._node = runner, runner.node
        self._running: dict[str, str] = {}
        self._topics: set[str] = set()
        self._named: set[str] = set()
        runner.ledger.others = self.describe
        self.look()
        self._node.create_timer(LOOK_S, self.look)

    def look(self) -> None:
        """Subscribe to the states of the executives in the namespace of the robot."""
        namespace = self._node.get_namespace().rstrip("/")
        for topic, types in self._node.get_topic_names_and_types():
            executive, _, name = topic.rpartition("/")
            is_here = executive.rpartition("/")[0] == namespace and name == "state"
            if is_here and STATE_TYPE in types and topic not in self._topics:
                self._topics.add(topic)
                take = partial(self._take, executive)
                self._node.create_subscription(MissionState, topic, take, LATCHED)

    def describe(self) -> str:
        """Return the missions that run, with their nodes; empty for none."""
        mine = self._node.get_fully_qualified_name()
        names = [
            name
            for node, name in self._running.items()
            if self._node.count_publishers(f"{node}/state") > (node == mine)
        ]
        return listed(names) if names else ""

    def _take(self, node: str, state: Any) -> None:
        if state.run == self._runner.executive.run:
            return
        if not state.run or state.status in FINAL:
            self._running.pop(node, None)
            return
        name = self._running[node] = f"mission {quoted(state.mission)} ({node})"
        if state.run not in self._named:
            self._named.add(state.run)
            self._runner.warn(
                f"{name} runs on this robot, too: goals that move the same part replace each other"
            )
