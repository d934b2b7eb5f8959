"""What tools see of a running mission: its tree once, and after that what changes.

``~/tree``, ``~/node_details``, ``~/requirements`` and ``~/state`` are latched; ``~/changes``
carries the changes of one tick, and nothing is sent for a tick that changes nothing. Who comes late
asks ``~/statuses`` for all statuses at once, and goes on from its sequence number. ``~/details``
and ``~/log`` are made only while somebody subscribes, and paced by wall time, since the mission's
clock may run a hundred times as fast.
"""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable
from typing import Any

from bt_mission_interfaces.msg import (
    MissionDetails,
    MissionLog,
    MissionState,
    NodeStatus,
    StatusChanges,
    Tree,
    TreeNode,
)
from bt_mission_interfaces.srv import GetStatuses
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from rclpy.node import Node
from rclpy.qos import QoSProfile
from std_msgs.msg import String

from bt_mission.behaviours.builder import node_details
from bt_mission.behaviours.python_leaf import PythonLeaf
from bt_mission.core.stamps import set_ns
from bt_mission.core.wall_clock import Stopwatch
from bt_mission.executive.status import Change
from bt_mission.ros.graph import LATCHED, REQUESTS
from bt_mission.ros.mission_details import MissionDetailsBuilder, MissionRun
from bt_mission.ros.requirement_status import RequirementStatus

CHANGES = QoSProfile(depth=100)
DETAILS = QoSProfile(depth=10)
LOG = QoSProfile(depth=100)

DETAILS_PERIOD_S = 0.1
"""Wall time between two messages of details."""

COMPLETE_EVERY = 10
"""Every so many messages all goals and variables are told, not only those that have changed."""

CODES = {
    Status.INVALID: NodeStatus.INVALID,
    Status.RUNNING: NodeStatus.RUNNING,
    Status.SUCCESS: NodeStatus.SUCCESS,
    Status.FAILURE: NodeStatus.FAILURE,
}

StatusListener = Callable[[str, Any], None]
"""Takes a message with what it is: ``tree``, ``node_details``, ``requirements``, ``state`` or
``changes``."""


class StatusPublisher:
    """Publishes one mission after another, and tells listeners of this process, such as a recorder.

    Args:
        node: The topics begin with its name. Before the first mission it gives the time of the
            stamps; after that the mission does.
        has_topics: False tells the listeners only.
    """

    def __init__(self, node: Node, *, has_topics: bool = True) -> None:
        self._node = node
        self._listeners: list[StatusListener] = []
        self.run = ""
        """Names the run; empty before the first."""
        self.sequence = 0
        """Of the newest message of changes; 0 before the first."""
        self.indices: dict[Behaviour, int] = {}
        """The nodes of the tree, each with its number."""
        self._mission = ""
        self._run: MissionRun | None = None
        self._has_tree = False
        """Has the tree been told?"""
        self._pending: list[NodeStatus] = []
        self._ended: dict[Behaviour, None] = {}
        """Nodes that stand as ended."""
        self._reset: dict[Behaviour, None] = {}
        """Nodes that had ended, and are to run again in a new round of a loop above them."""
        self._seen: tuple[str, str, bool] | None = None
        self._shown: tuple[str, str] | None = None
        self._topics: dict[str, Any] = {}
        self._details: MissionDetailsBuilder | None = None
        self._requirements: RequirementStatus | None = None
        self._since_details = Stopwatch()
        self._details_count = 0
        if has_topics:
            self._topics = {
                "tree": node.create_publisher(Tree, "~/tree", LATCHED),
                "node_details": node.create_publisher(String, "~/node_details", LATCHED),
                "requirements": node.create_publisher(DiagnosticArray, "~/requirements", LATCHED),
                "state": node.create_publisher(MissionState, "~/state", LATCHED),
                "changes": node.create_publisher(StatusChanges, "~/changes", CHANGES),
                "details": node.create_publisher(MissionDetails, "~/details", DETAILS),
                "log": node.create_publisher(MissionLog, "~/log", LOG),
            }
            self._service = node.create_service(
                GetStatuses, "~/statuses", self._answer, qos_profile=REQUESTS
            )
            self.add(lambda what, message: self._topics[what].publish(message))

    def close(self) -> None:
        """Destroy the topics and the service."""
        if self._topics:
            self._node.destroy_service(self._service)
        self._listeners.clear()
        while self._topics:
            self._node.destroy_publisher(self._topics.popitem()[1])

    def add(self, listener: StatusListener) -> None:
        """Tell a listener what has been told so far, and what changes from now on."""
        if self._listeners and self._has_tree:
            self.publish_if_changed()
        self._listeners.append(listener)
        if self._has_tree and self._run is not None:
            listener("tree", self._tree(self._run))
            listener("node_details", self._node_details(self._run))
        if self._requirements is not None and self._requirements.message is not None:
            listener("requirements", self._requirements.message)
        if self._shown is not None:
            listener("state", self._state(*self._shown))

    def remove(self, listener: StatusListener) -> None:
        """Tell a listener no more."""
        if listener in self._listeners:
            self._listeners.remove(listener)

    def begin(self, mission: str, run: MissionRun) -> None:
        """Follow a mission that starts.

        Its tree is told with the first :meth:`publish_if_changed`: before its first tick a node on
        the stage does not have the mission's time yet.
        """
        self.run, self._mission = secrets.token_hex(8), mission
        self.sequence, self._run = 0, run
        self._pending, self._ended, self._reset = [], {}, {}
        self._has_tree = False
        self.indices = {node: index for index, node in enumerate(run.executive.nodes)}
        self._follow_requirements(run)
        run.executive.listeners.append(self._on_change)
        if self._topics:
            self._details = MissionDetailsBuilder(self.run, run, self.indices)
            self._details_count = 0
            run.log_listeners.append(self._on_log)

    def _follow_requirements(self, run: MissionRun) -> None:
        if self._requirements is not None:
            self._tell("requirements", DiagnosticArray())  # those of the last mission are over
        self._requirements = None
        if run.mission.requirements:
            watch = run.requirements
            self._requirements = RequirementStatus(
                self.run, watch.results, lambda: watch.count_violated
            )

    def publish_idle(self) -> None:
        """Tell that there is no mission yet."""
        self._tell_state("idle", "")

    def publish_if_changed(self) -> None:
        """Tell what has changed since the last time, if anything has; at first the tree."""
        has_turned = self._tell_changes()
        if self._details is not None:
            self._publish_details(self._details, at_once=has_turned)

    @property
    def statuses(self) -> list[NodeStatus]:
        """The status of every node, in the order of the tree."""
        return [
            _status(index, node.status, node.feedback_message)
            for node, index in self.indices.items()
        ]

    def _tell_changes(self) -> bool:
        """Tell of tree, changes and state; return whether the state is another one."""
        if self._run is None or not self._listeners or not self._run.now_ns:
            return False  # a node that has just joined a graph has no time yet
        if not self._has_tree:
            self._has_tree = True
            self._tell("tree", self._tree(self._run))
            self._tell("node_details", self._node_details(self._run))
        self._tell_rounds()
        if self._pending:
            self.sequence += 1
            changes = StatusChanges(
                stamp=self._stamp(),
                run=self.run,
                sequence=self.sequence,
                changes=self._pending,
            )
            self._pending = []
            self._tell("changes", changes)
        executive = self._run.executive
        if self._requirements is not None:
            told = self._requirements.describe(self._run.now_ns, is_done=executive.is_done)
            if told is not None:
                self._tell("requirements", told)
        seen = (executive.status, executive.explanation, executive.paused is not None)
        if seen == self._seen:
            return False
        self._seen = seen
        self._tell_state(executive.state, executive.explanation)
        return True

    def _publish_details(self, details: MissionDetailsBuilder, *, at_once: bool) -> None:
        if not self._topics or (not at_once and self._since_details.elapsed_s < DETAILS_PERIOD_S):
            return
        self._since_details = Stopwatch()
        if not self._topics["details"].get_subscription_count():
            self._details_count = 0
            return
        is_complete = self._details_count % COMPLETE_EVERY == 0
        self._details_count += 1
        self._topics["details"].publish(details.describe(complete=is_complete))

    def _on_log(self, time_ns: int, text: str) -> None:
        if self._topics and self._topics["log"].get_subscription_count():
            line = MissionLog(stamp=set_ns(Time(), time_ns), run=self.run, text=text)
            self._topics["log"].publish(line)

    def _answer(self, _request: Any, answer: Any) -> Any:
        self.publish_if_changed()
        answer.run, answer.sequence, answer.statuses = self.run, self.sequence, self.statuses
        return answer

    def _tell_state(self, status: str, reason: str) -> None:
        self._shown = (status, reason)
        self._tell("state", self._state(status, reason))

    def _tell(self, what: str, message: Any) -> None:
        for listener in self._listeners:
            listener(what, message)

    def _tell_rounds(self) -> None:
        """Add what the executive tells nobody: a new round of a loop resets what is below it.

        What ends in that round at once, as it did in the last one, is no change to it either.
        """
        invalid = Status.INVALID
        for node in [node for node in self._reset if node.status is not invalid]:
            del self._reset[node]
            self._ended[node] = None
            self._pending.append(_status(self.indices[node], node.status, node.feedback_message))
        if self._pending:
            for node in [node for node in self._ended if node.status is invalid]:
                del self._ended[node]
                self._reset[node] = None
                self._pending.append(_status(self.indices[node], invalid, ""))

    def _on_change(self, change: Change) -> None:
        self._reset.pop(change.node, None)
        if change.status in (Status.SUCCESS, Status.FAILURE):
            self._ended[change.node] = None
        else:
            self._ended.pop(change.node, None)
        if self._listeners:
            self._pending.append(_status(self.indices[change.node], change.status, change.message))

    def _tree(self, run: MissionRun) -> Tree:
        executive = run.executive
        return Tree(
            stamp=set_ns(Time(), executive.started_ns or run.now_ns),
            run=self.run,
            mission=self._mission,
            nodes=[
                TreeNode(
                    name=node.name,
                    kind=type(node.behaviour if isinstance(node, PythonLeaf) else node).__name__,
                    path=executive.path_of(node),
                    parent=self.indices[node.parent or node],
                )
                for node in self.indices
            ],
        )

    def _node_details(self, run: MissionRun) -> String:
        return String(data=json.dumps({"run": self.run, "nodes": node_details(run.mission)}))

    def _state(self, status: str, reason: str) -> MissionState:
        return MissionState(
            stamp=self._stamp(), run=self.run, mission=self._mission, status=status, reason=reason
        )

    def _stamp(self) -> Any:
        if self._run is None:
            return self._node.get_clock().now().to_msg()
        return set_ns(Time(), self._run.now_ns)


def _status(index: int, status: Status, message: str) -> NodeStatus:
    return NodeStatus(node=index, status=CODES[status], message=message)
