"""The missions of a session, for a view of this process: it subscribes to their events.

Nothing is encoded, sent or served for it, and no topic, service or action server is offered. So a
run is the same with a view as without.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import replace

from rclpy.node import Node

from bt_mission.base.wall_clock import Stopwatch
from bt_mission.executive.events.events import (
    Event,
    NodeChanged,
    RunStarted,
    StateChanged,
    TreeRevised,
)
from bt_mission.executive.events.messages import Batch, Robot
from bt_mission.executive.events.mission_file import MissionOrigin
from bt_mission.executive.events.source import (
    ControlRequest,
    ControlResponse,
    ListedExecutive,
    Received,
)
from bt_mission.ros import robot_relay, status_publisher
from bt_mission.ros.graph import quiet_node
from bt_mission.ros.mission_details import MissionDetailsBuilder
from bt_mission.ros.robot_topics import RobotTopics
from bt_mission.sessions.session import MissionRun, Session


class RunSource:
    """The events of one mission from now on, after its present state; and its robot.

    Args:
        run: The mission.
        node: Owns the subscriptions to the map and the camera, and to a robot that is not simulated
            here; nothing has to serve it.
    """

    is_there = True

    def __init__(self, run: MissionRun, node: Node) -> None:
        self.name = run.node.get_fully_qualified_name()
        self._run = run
        self._events: deque[Event] = deque()
        self._answers: list[ControlResponse] = []
        self._details = MissionDetailsBuilder(run.runner)
        self._since_details, self._since_snapshot = Stopwatch(), Stopwatch()
        namespace = self.name.rpartition("/")[0]
        self._robot = RobotTopics(node, namespace)
        self._is_simulated = run.snapshot() is not None
        if not self._is_simulated:
            self._robot.follow(namespace)
        self._before = tuple(self._present())
        self._has_state = False
        """Whether a view knows the state of the mission."""
        run.executive.events.subscribe(self._keep)
        run.executive.after_tick.append(run.runner.requirements.emit_changes)

    def take(self, *, needs_statuses: bool) -> Received:  # noqa: ARG002 - none is ever lost
        """Return what has happened since the last call, one event a batch."""
        batches = [*self._before, *map(self._batch, self._events)]
        self._before = ()
        self._events.clear()
        executive = self._run.executive
        if executive.cycles:  # before its first tick a node may have another clock
            if not self._has_state:
                self._has_state = True
                batches.append(self._batch(executive.state_event()))
            if self._since_details.elapsed_s >= status_publisher.DETAILS_PERIOD_S:
                self._since_details = Stopwatch()
                batches.append(self._batch(*self._details.changes()))
        answers, self._answers = self._answers, []
        readings, image = self._robot.take()
        return Received(tuple(batches), (*readings, *self._snapshot()), tuple(answers), image)

    def send(self, command: ControlRequest) -> None:
        """Do what is requested, between two steps of the session."""
        self._answers.append(self._run.runner.controls.perform(command))

    def watch_camera(self, *, is_on: bool) -> None:
        """Receive the images of the robot's camera, or no longer."""
        self._robot.watch_camera(is_on=is_on)

    def close(self) -> None:
        """Take no more events."""
        executive = self._run.executive
        executive.events.unsubscribe(self._keep)
        executive.after_tick.remove(self._run.runner.requirements.emit_changes)
        self._events.clear()
        self._robot.close()

    # ---- inside --------------------------------------------------------------------------

    def _keep(self, event: Event) -> None:
        if event.event_topic:
            self._events.append(event)
            self._has_state = self._has_state or isinstance(event, StateChanged)

    def _batch(self, *events: Event) -> Batch:
        has_tree = isinstance(events[0], RunStarted | TreeRevised)
        file = MissionOrigin.of(self._run.mission) if has_tree else None
        return Batch(self._run.executive.run, events, file=file)

    def _present(self) -> Iterator[Batch]:
        """Yield the state of the mission, as it is sent to viewers elsewhere that come late."""
        executive = self._run.executive
        state = executive.mission_state
        if state.tree is None or not state.tree.time_ns:
            return  # the tree comes when the mission has started
        yield self._batch(state.tree)
        statuses = tuple(
            NodeChanged(None, index, node.status, node.feedback_message)
            for index, node in enumerate(executive.nodes)
        )
        revision = state.tree.revision
        yield Batch(executive.run, statuses, is_complete=True, revision=revision)
        goals = (
            replace(goal, time_ns=state.goals_changed_ns[goal.id], change="")
            for goal in state.goals.values()
        )
        for event in (*state.requirements, *goals):
            yield self._batch(event)

    def _snapshot(self) -> tuple[Robot, ...]:
        if not self._is_simulated or self._since_snapshot.elapsed_s < robot_relay.EVERY_S:
            return ()
        self._since_snapshot = Stopwatch()
        look = self._run.snapshot()
        assert look is not None, "the robot is simulated"
        return tuple(robot_relay.readings_of(look))


class SessionGraph:
    """The missions of a session of this process, in place of a graph.

    Args:
        session: The session; the caller steps it.
    """

    where = "this process"

    def __init__(self, session: Session) -> None:
        self._runs = {run.node.get_fully_qualified_name(): run for run in session.runs}
        self.name = next(iter(self._runs))
        """The name of the first executive."""
        self._node = quiet_node("bt_mission_screen", session.node.context)
        self._sources: list[RunSource] = []

    def serve(self) -> None:
        """Do nothing: events arrive while the session is stepped."""

    def find(self) -> tuple[ListedExecutive, ...]:
        """All of them."""
        return tuple(map(ListedExecutive, self._runs))

    def attach(self, name: str) -> RunSource:
        """Return the source of an executive."""
        self._sources.append(RunSource(self._runs[name], self._node))
        return self._sources[-1]

    def close(self) -> None:
        """Leave, before the session is closed; missions that still run cost nothing more."""
        for source in self._sources:
            source.close()
        self._node.destroy_node()
