"""Looking on at a session from inside its process, without changing what happens in it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from bt_mission.sessions.session import Session

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.ros.graph import ProcessNode
    from bt_mission.ros.mission_node import MissionNode
    from bt_mission.ros.mission_runner import MissionRunner


class SessionObserver(Protocol):
    """What looks on, such as a recorder."""

    node: Node

    def look(self) -> None:
        """Called after each step of the session."""


class ObservableSession(Session, Protocol):
    """A session that can be looked on at: on the stage, or attached."""

    node: MissionNode
    runner: MissionRunner

    @property
    def image_folder(self) -> Path | None:
        """Where the run makes its pictures; None where that is not known."""

    @property
    def facts(self) -> Mapping[str, str]:
        """What is known of the place of the run: the world, the hull of the robot."""

    def inside(self) -> Iterable[ProcessNode]:
        """The nodes of the process that take part."""

    def add_observer(self, observer: SessionObserver, /) -> None:
        """Call an observer after each step; serve its node where messages do not come at once."""

    def remove_observer(self, observer: SessionObserver, /) -> None:
        """Call it no more, and destroy its node."""
