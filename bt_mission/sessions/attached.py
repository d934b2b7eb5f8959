"""The executive alone, on the clock of the ROS graph it joins."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rclpy.node import Node

from bt_mission.base.dds.publishers import CLOCK
from bt_mission.language.mission import Mission
from bt_mission.language.nodes.action import GoalNode
from bt_mission.language.permissions import ANYTHING, Permissions
from bt_mission.language.trees import all_steps, has_python
from bt_mission.ros.graph import CLOCK_WAIT_S, GraphConnection, NodeOptions
from bt_mission.ros.journal import open_journal, resumed_mission
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.ros.other_missions import OtherMissions
from bt_mission.sessions.revising import read_revision
from bt_mission.sessions.session import MissionRun, Session


@dataclass(frozen=True, kw_only=True)
class AttachedOptions:
    """The options of an attached mission.

    Attributes:
        namespace: The namespace of the robot whose servers to use.
        wall_clock: Use this machine's clock, without looking for ``/clock``.
        allow_duplicates: Continue if several nodes publish the same odometry or clock, or serve
            the same action.
        journal: The file of the journal.
        resume: Resume the mission of that journal, in its newest version.
        editable: Take new versions of the mission from other processes while it runs.
        permissions: What new versions may use.
    """

    namespace: str | None = None
    wall_clock: bool = False
    allow_duplicates: bool = False
    journal: Path | None = None
    resume: bool = False
    editable: bool = False
    permissions: Permissions = ANYTHING


class AttachedSession(Session):
    """Runs one mission against action servers in other processes.

    Args:
        mission: The mission to run.
        options: The options of the attachment.
        say: Called with lines of ``log`` nodes; None is the ROS log.

    Raises:
        BtMissionError: The mission cannot be set up, the journal cannot be used, or two robots
            would be taken for one.
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
            if chosen.journal is not None and chosen.resume:
                mission = resumed_mission(chosen.journal, mission)
            self.runs = ()
            if has_python(mission) or chosen.editable:
                self.watch = self._graph.watch_users()
                self.watch.last_words.append(self.leave)
            read = partial(read_revision, permissions=chosen.permissions)
            runner = RunnerOptions(
                say=say,
                read_revision=read if chosen.editable else None,
                allow_duplicates=chosen.allow_duplicates,
            )
            self._node = MissionNode(mission, runner, node=node)
            self.runs = (MissionRun.of(self._node.runner),)
            made.callback(self._node.destroy_node)
            steps = all_steps(mission)
            several = self._graph.refuse_conflicts(
                self._node,
                [step.ros_name for step in steps if isinstance(step, GoalNode)],
                allow_duplicates=chosen.allow_duplicates,
            )
            self._graph.host(self._node)
            OtherMissions(self._node.runner)
            if several is not None:
                self.runner.warn(several)
            if self._graph.lacks_clock:
                self.runner.warn(
                    f"nothing has published {CLOCK} within {CLOCK_WAIT_S:g} s: the mission runs on "
                    "the clock of this machine; if that is meant, use --wall-clock"
                )
            if chosen.journal is not None:
                journal = open_journal(chosen.journal, mission, self.runner, resume=chosen.resume)
                made.callback(journal.close)
            self._exit = made.pop_all()

    def step(self) -> None:
        """Serve what is next, for at most a tenth of a second."""
        self._graph.step(self.executive, self._node)
        self._call_onlookers()

    def _serve(self, node: Node) -> None:
        self._graph.host(node)

    def _drop(self, node: Node) -> None:
        self._graph.drop(node)
