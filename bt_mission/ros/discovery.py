"""The executives of a graph, for viewers."""

from __future__ import annotations

import os
from typing import Any, Self

from bt_mission_interfaces.srv import ReviseMission

from bt_mission.base.dds.discovery import RANGE
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events.source import ExecutiveSource, ListedExecutive
from bt_mission.ros.executors.participants import Discovery
from bt_mission.ros.graph import REQUESTS, GraphConnection, type_hash_of
from bt_mission.ros.mission_client import TOPICS, MissionClient

STATE_TYPE = "bt_mission_interfaces/msg/MissionState"

SERVE_S = 0.05
"""Wall time for which messages are received at a stretch."""


class ExecutiveDirectory:
    """A watcher's own place in a graph. Use it as a context manager."""

    def __init__(self) -> None:
        self._graph = GraphConnection(wall_clock=True)
        self._node = self._graph.host_quiet("bt_mission_watch")
        self._hashes = [type_hash_of(self._node, kind) for kind, *_ in TOPICS.values()]
        self._discovery = Discovery(self._node)
        domain, reach = os.environ.get("ROS_DOMAIN_ID", "0"), os.environ.get(RANGE, "SUBNET")
        self.where = f"ROS domain {domain or 0}, {RANGE}={reach}"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._graph.close()

    def serve(self, wait_s: float = 0.0) -> None:
        """Handle what was received, for at most :data:`SERVE_S`.

        Args:
            wait_s: The limit of the wait for a message.
        """
        since = Stopwatch()
        while since.elapsed_s < SERVE_S + wait_s and self._graph.executor.serve(wait_s):
            wait_s = 0.0

    def is_over(self) -> bool:
        """Return whether all executives that are there are found."""
        return self._discovery.is_over()

    def find(self) -> tuple[ListedExecutive, ...]:
        """The executives that are there now, by name."""
        names = {
            topic.removesuffix("/state"): topic
            for topic, types in self._node.get_topic_names_and_types()
            if STATE_TYPE in types and topic.endswith("/state")
            if self._node.count_publishers(topic)
        }
        return tuple(self._look_at(names[name]) for name in sorted(names))

    def attach(self, name: str, *, with_robot: bool = True) -> ExecutiveSource:
        """Return the source of an executive and its robot, even if it is not in the graph yet."""
        return MissionClient(self._node, name, with_robot=with_robot)

    def revise(self, name: str, request: Any, wait_s: float) -> Any:
        """Send an executive a new version of its mission; return its response, None without one.

        Args:
            request: Of ``bt_mission_interfaces/srv/ReviseMission``.
            wait_s: The limit of the wait for the service, and of that for the response, s.
        """
        client = self._node.create_client(ReviseMission, f"{name}/revise", qos_profile=REQUESTS)
        since = Stopwatch()
        while not client.service_is_ready() and since.elapsed_s < wait_s:
            self.serve(SERVE_S)
        if not client.service_is_ready():
            return None
        future, since = client.call_async(request), Stopwatch()
        while not future.done() and since.elapsed_s < wait_s:
            self.serve(SERVE_S)
        return future.result() if future.done() else None

    def _look_at(self, topic: str) -> ListedExecutive:
        name = topic.removesuffix("/state")
        for (other, (kind, *_)), own in zip(TOPICS.items(), self._hashes, strict=True):
            for publisher in self._node.get_publishers_info_by_topic(f"{name}/{other}"):
                if publisher.topic_type_hash != own:
                    why = f"its {kind.__name__} messages are from another version of bt-mission: "
                    why += "install the same on both sides"
                    return ListedExecutive(name, why, is_foreign=True)
        if (count := self._node.count_publishers(topic)) > 1:
            return ListedExecutive(
                name, f"{count} executives share this name: give each a --namespace"
            )
        return ListedExecutive(name)
