"""The executive alone, on the clock of the ROS graph it joins."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from rclpy.node import Node

from bt_mission.language.mission import Mission
from bt_mission.ros.graph import GraphConnection, NodeOptions
from bt_mission.ros.journal import open_journal
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.sessions.session import Run, Session


@dataclass(frozen=True, kw_only=True)
class AttachedOptions:
    """How a mission joins a graph.

    Attributes:
        namespace: Of the robot whose servers to use.
        wall_clock: Keep to this machine's clock, without looking for ``/clock``.
        allow_duplicates: Go on where several nodes publish the same odometry or clock.
        journal: File in which to write down where the mission stands.
        resume: Go on with the mission of that journal.
    """

    namespace: str | None = None
    wall_clock: bool = False
    allow_duplicates: bool = False
    journal: Path | None = None
    resume: bool = False


class AttachedSession(Session):
    """Runs one mission against action servers in other processes.

    Args:
        mission: What to carry out.
        options: How it joins the graph.
        say: Where ``log`` nodes speak to; None is the ROS log.

    Raises:
        BtMissionError: When the mission cannot be set up, the journal not be used, or two robots be
            taken for one.
    """

    def __init__(
        self,
        mission: Mission,
        options: AttachedOptions | None = None,
        say: Callable[[str], None] | None = None,
    ) -> None:
        super().__init__()
        chosen = options or AttachedOptions()
        with ExitStack() as made:
            self._graph = GraphConnection(wall_clock=chosen.wall_clock)
            made.callback(self._graph.close)
            node = NodeOptions(
                namespace=chosen.namespace,
                context=self._graph.context,
                use_sim_time=self._graph.has_clock,
            )
            self._node = MissionNode(mission, RunnerOptions(say=say), node=node)
            self.runs = (Run.of(self._node.runner),)
            made.callback(self._node.destroy_node)
            if not chosen.allow_duplicates:
                self._graph.refuse_duplicates(self._node)
            self._graph.host(self._node)
            if chosen.journal is not None:
                journal = open_journal(chosen.journal, mission, self.runner, resume=chosen.resume)
                made.callback(journal.close)
            self._exit = made.pop_all()

    def drain(self) -> None:
        """Serve what is on its way once the mission has ended."""
        self._graph.drain()

    def step(self) -> None:
        """Serve what comes next, for at most a tenth of a second."""
        self._graph.step(self.executive, self._node)
        self._call_onlookers()

    def _serve(self, node: Node) -> None:
        self._graph.host(node)

    def _drop(self, node: Node) -> None:
        self._graph.drop(node)
