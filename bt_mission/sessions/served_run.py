"""One mission that a server carries out, for those who look on, such as a recorder."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Self

from rclpy.node import Node

from bt_mission.executive.executive import Executive
from bt_mission.executive.report import Report
from bt_mission.language.mission import Mission
from bt_mission.ros.graph import ProcessNode
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.sessions.session import SessionObserver


class ServedRun:
    """A mission with its executive, under the name of the server that carries it out.

    Args:
        node: That of the server: below its name lie the topics of all its missions.
        runner: Carries the mission out.
        host: Has the executor serve a node.
        drop: No longer, and destroys it.
    """

    image_folder: Path | None = None

    def __init__(
        self,
        node: Node,
        runner: MissionRunner,
        host: Callable[[Node], Any],
        drop: Callable[[Node], Any],
    ) -> None:
        self.node = node
        self.runner = runner
        self.mission: Mission = runner.mission
        self.executive: Executive = runner.executive
        self.facts: Mapping[str, str] = {}
        self.files: Mapping[str, str] = {}
        self.end_listeners: list[Callable[[Report], None]] = []
        """Called with the report, once the mission and all its goals have ended."""
        self._observers: list[SessionObserver] = []
        self._host = host
        self._drop = drop

    @property
    def runs(self) -> tuple[Self]:
        """Itself: its one mission."""
        return (self,)

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""
        return self.runner.now_ns

    def inside(self) -> tuple[ProcessNode, ...]:
        """None: all of the graph is heard by subscriptions."""
        return ()

    def add_observer(self, observer: SessionObserver) -> None:
        """Serve an observer's node, too, and call it after each step."""
        self._host(observer.node)
        self._observers.append(observer)

    def remove_observer(self, observer: SessionObserver) -> None:
        """Call it no more, and destroy its node."""
        self._observers.remove(observer)
        self._drop(observer.node)

    def look(self) -> None:
        """Have observers look; called after each step."""
        for observer in self._observers:
            observer.look()

    def end(self, report: Report) -> None:
        """Tell those who wait for the end."""
        for listener in self.end_listeners:
            listener(report)
