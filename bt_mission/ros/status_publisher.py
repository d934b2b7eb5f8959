"""The topics of a running mission: its tree once, and after that what changes.

``~/tree``, ``~/requirements`` and ``~/state`` are latched; ``~/changes`` carries the changes of one
tick, and nothing is sent for a tick that changes nothing. A late subscriber asks ``~/statuses`` for
all statuses at once, and continues from its sequence number. ``~/details`` and ``~/log`` are made
only while somebody subscribes, and paced by wall time, since the mission's clock may run a hundred
times as fast.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from bt_mission_interfaces.msg import (
    MissionDetails,
    MissionLog,
    MissionState,
    Requirements,
    StatusChanges,
    Tree,
)
from bt_mission_interfaces.srv import GetStatuses
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bt_mission.base.stamps import clock_ns
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events.events import (
    Event,
    NodeChanged,
    NodesReset,
    RequirementChanged,
    StateChanged,
    TreeRevised,
)
from bt_mission.ros import event_messages
from bt_mission.ros.graph import LATCHED, REQUESTS
from bt_mission.ros.mission_details import MissionDetailsBuilder
from bt_mission.ros.mission_runtime import MissionRuntime
from bt_mission.ros.requirement_watch import RequirementWatch

CHANGES = QoSProfile(depth=100)
DETAILS = QoSProfile(depth=10)
LOG = QoSProfile(depth=100)

DETAILS_PERIOD_S = 0.1
"""Wall time between two messages of details."""

COMPLETE_EVERY = 10
"""Every Nth message of details has all goals and variables, not only changed ones."""

MessageListener = Callable[[str, Any], None]
"""Takes a topic's name (``tree``, ``requirements``, ``state`` or ``changes``) and a message."""


class StatusPublisher:
    """Publishes one mission after another, also to listeners of this process, such as a recorder.

    Args:
        node: The topics begin with its name. Before the first mission it gives the time of the
            stamps; after that the mission does.
        has_topics: False serves the listeners only.
    """

    def __init__(self, node: Node, *, has_topics: bool = True) -> None:
        self._node = node
        self._listeners: list[MessageListener] = []
        self.sequence = 0
        """The number of the newest message of changes; 0 before the first."""
        self._run: MissionRuntime | None = None
        self._watch: RequirementWatch | None = None
        self._has_tree = False
        """Whether the tree was sent."""
        self._pending: list[NodeChanged | NodesReset | TreeRevised] = []
        self._revised: TreeRevised | None = None
        """The newest revision of the mission."""
        self._has_verdicts = False
        self._state: StateChanged | None = None
        self._has_state = False
        """Whether the newest state was sent."""
        self._topics: dict[str, Any] = {}
        self._details: MissionDetailsBuilder | None = None
        self._since_details = Stopwatch()
        self._details_count = 0
        if has_topics:
            self._topics = {
                "tree": node.create_publisher(Tree, "~/tree", LATCHED),
                "requirements": node.create_publisher(Requirements, "~/requirements", LATCHED),
                "state": node.create_publisher(MissionState, "~/state", LATCHED),
                "changes": node.create_publisher(StatusChanges, "~/changes", CHANGES),
                "details": node.create_publisher(MissionDetails, "~/details", DETAILS),
                "log": node.create_publisher(MissionLog, "~/log", LOG),
            }
            self._service = node.create_service(
                GetStatuses, "~/statuses", self._answer, qos_profile=REQUESTS
            )
            self.add(self._publish)

    def close(self) -> None:
        """Destroy the topics and the service."""
        if self._topics:
            self._node.destroy_service(self._service)
        self._listeners.clear()
        self._leave()
        while self._topics:
            self._node.destroy_publisher(self._topics.popitem()[1])

    def add(self, listener: MessageListener) -> None:
        """Hand a listener what was sent so far, and what changes from now on."""
        if self._listeners and self._has_tree:
            self.publish_if_changed()
        self._listeners.append(listener)
        for what, message in self._sent():
            listener(what, message)

    def remove(self, listener: MessageListener) -> None:
        """Hand it nothing more."""
        if listener in self._listeners:
            self._listeners.remove(listener)
        if not self._listeners:
            self._drop_pending()

    def begin(self, run: MissionRuntime, requirements: RequirementWatch) -> None:
        """Follow a mission that starts.

        Its tree is sent once the executive has emitted that the run has started: a node that has
        just joined a graph has no time yet.
        """
        self._leave()
        had_verdicts = self._run is not None and self._run.executive.mission_state.requirements
        self.sequence, self._run, self._watch = 0, run, requirements
        self._pending, self._has_tree, self._has_verdicts = [], False, False
        self._revised = None
        executive = run.executive
        self._state, self._has_state = None, False
        if had_verdicts:
            self._send_requirements(run)  # those of the mission before are over
        executive.events.subscribe(self._take)
        if self._topics:
            self._details = MissionDetailsBuilder(run)
            self._details_count = 0

    def publish_idle(self) -> None:
        """Publish that there is no mission yet."""
        now_ns = clock_ns(self._node.get_clock())
        self._state = StateChanged(now_ns, "", "", "idle", "")
        self._send("state", event_messages.state(self._state))

    def publish_if_changed(self) -> None:
        """Publish what has changed since the last call; at first the tree."""
        has_turned = self._send_changes()
        if self._details is not None:
            self._publish_details(self._details, at_once=has_turned)

    def _sent(self) -> Iterator[tuple[str, Any]]:
        """The latched messages, as sent."""
        if self._run is not None and self._has_tree:
            assert self._run.executive.mission_state.tree is not None, "it was sent"
            tree = self._run.executive.mission_state.tree
            yield "tree", event_messages.tree(tree, self._run.mission, self._revised)
            if self._run.executive.mission_state.requirements:
                yield "requirements", self._requirements(self._run)
        if self._state is not None and (self._has_state or self._run is None):
            yield "state", event_messages.state(self._state)

    def _leave(self) -> None:
        if self._run is not None:
            self._run.executive.events.unsubscribe(self._take)

    def _take(self, event: Event) -> None:
        match event:
            case NodeChanged() | NodesReset():
                if self._listeners:
                    self._pending.append(event)
            case TreeRevised():
                self._pending.append(event)
                if not self._listeners or not self._has_tree:
                    self._drop_pending()
            case StateChanged():
                self._state, self._has_state = event, False
            case RequirementChanged():
                self._has_verdicts = True
            case Event(event_topic="log"):
                if self._topics and self._topics["log"].get_subscription_count():
                    assert self._run is not None, "its events come here"
                    executive = self._run.executive
                    line = event_messages.log(event, executive.run, executive.node_infos)
                    self._topics["log"].publish(line)

    def _send_changes(self) -> bool:
        """Send tree, changes and state; return whether the state has changed."""
        run = self._run
        if run is None or self._watch is None or not self._listeners:
            return False
        if not self._has_tree:
            tree = run.executive.mission_state.tree
            if tree is None or not tree.time_ns:
                return False  # the run has not started
            self._has_tree = True
            self._send("tree", event_messages.tree(tree, run.mission, self._revised))
        self._send_pending(run)
        self._watch.emit_changes()
        if self._has_verdicts:
            self._has_verdicts = False
            self._send_requirements(run)
        if self._has_state:
            return False
        self._has_state, self._state = True, self._state or run.executive.state_event()
        self._send("state", event_messages.state(self._state))
        return True

    def _send_pending(self, run: MissionRuntime) -> None:
        """Send changes of nodes, each with the tree to which its indices belong."""
        pending, self._pending = self._pending, []
        changes: list[NodeChanged | NodesReset] = []
        for event in pending:
            if isinstance(event, TreeRevised):
                self._send_changes_of(run, changes)
                self._revised, changes = event, []
                tree = run.executive.mission_state.tree
                assert tree is not None, "it was sent"
                revised = replace(tree, mission=event.mission, nodes=event.nodes)
                self._send("tree", event_messages.tree(revised, run.mission, event))
            else:
                changes.append(event)
        self._send_changes_of(run, changes)

    def _send_changes_of(
        self, run: MissionRuntime, changes: list[NodeChanged | NodesReset]
    ) -> None:
        if changes:
            self.sequence += 1
            message = event_messages.changes(
                run.now_ns, run.executive.run, self.sequence, changes, self._revision
            )
            self._send("changes", message)

    def _drop_pending(self) -> None:
        """Forget changes that no listener gets; the newest tree is sent to the next one."""
        for event in self._pending:
            if isinstance(event, TreeRevised):
                self._revised = event
        self._pending.clear()

    @property
    def _revision(self) -> int:
        return 0 if self._revised is None else self._revised.number

    def _send_requirements(self, run: MissionRuntime) -> None:
        self._send("requirements", self._requirements(run))

    def _publish(self, what: str, message: Any) -> None:
        topic = self._topics[what]
        if what != "changes" or topic.get_subscription_count():  # the others are latched
            topic.publish(message)

    def _send(self, what: str, message: Any) -> None:
        for listener in self._listeners:
            listener(what, message)

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

    def _answer(self, _request: Any, answer: Any) -> Any:
        self.publish_if_changed()
        if self._run is not None:
            executive = self._run.executive
            answer.run, answer.sequence = executive.run, self.sequence
            answer.revision = executive.revisions
            answer.statuses = [
                event_messages.node_status(index, node.status, node.feedback_message)
                for index, node in enumerate(executive.nodes)
            ]
        return answer

    def _requirements(self, run: MissionRuntime) -> Requirements:
        executive = run.executive
        return event_messages.requirements(
            run.now_ns, executive.run, executive.mission_state.requirements
        )
