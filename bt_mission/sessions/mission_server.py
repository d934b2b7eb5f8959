"""The executive as a server: one mission at a time, each a goal of ``execute_mission``.

A goal stays accepted, and not yet executing, while the mission before it ends; it is asked
to end only once the newer one is loaded and checked. The goals of a mission that is cancelled,
replaced or stopped end first; then the mission does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from bt_mission_interfaces.action import ExecuteMission
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node
from rclpy.task import Future

from bt_mission.base.action_requests import BoundedRequests
from bt_mission.base.dds.publishers import duplicate_publishers
from bt_mission.base.diagnostics import InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.goal_rate import MOST_LINES, GoalRate, RateLimit
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import NS
from bt_mission.executive.controls import MissionControls
from bt_mission.executive.status import MissionStatus
from bt_mission.language.permissions import Permissions
from bt_mission.ros.control_services import ControlServices
from bt_mission.ros.executors.clock_messages import ValidClock
from bt_mission.ros.graph import REQUESTS, NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import RunnerOptions
from bt_mission.ros.status_publisher import StatusPublisher
from bt_mission.sessions.revising import read_revision
from bt_mission.sessions.served_missions import NO_TEXT, ServedMissions
from bt_mission.sessions.session import MissionRun, Onlooker, Session

if TYPE_CHECKING:
    from rclpy.action.server import ServerGoalHandle

    from bt_mission.executive.executive import Executive
    from bt_mission.language.mission import Mission
    from bt_mission.language.revision import Revision

RESULT_TIMEOUT_S = 10
"""The time for which a result is kept for clients, s, as by rcl_action's C++ servers."""

FEEDBACK_NS = NS
"""Feedback is sent at least this often while a mission runs."""

ON_NEW_GOAL = ("replace", "refuse")
REPLACED = "replaced by a newer mission"
VIOLATED = 912
"""``VIOLATED`` of the result: as a number, since interfaces of before it serve just as well."""
Result = ExecuteMission.Result


class ServedSession(Session):
    """A mission of a server, under the name of the server.

    Args:
        handle: The goal.
        node: The mission's node.
        server: The name below which the topics of all its missions are.
    """

    def __init__(self, handle: ServerGoalHandle, node: MissionNode, server: MissionServer) -> None:
        super().__init__()
        self.handle = handle
        self.mission_node = node
        self.runs = (MissionRun.of(node.runner, server),)
        self._server = server
        self._feedback: tuple[str, str] = ("", "")
        self._feedback_ns = 0

    def step(self) -> None:
        """The server's executor has taken a step: call the onlookers, and send feedback."""
        self._call_onlookers()
        if not self.is_done:
            self._send_feedback()

    def close(self) -> None:
        """Part with the onlookers."""
        for onlooker in reversed(tuple(self._onlookers)):
            onlooker.close()
            self.detach(onlooker)

    def _serve(self, node: Node) -> None:
        self._server.host(node)

    def _drop(self, node: Node) -> None:
        self._server.drop(node)

    def _send_feedback(self) -> None:
        """Send feedback when the state or the tip has changed, and once in a while."""
        executive = self.executive
        tip = executive.root.tip()
        shown = (executive.mission_state.status, tip.name if tip else "")
        if shown == self._feedback and self.now_ns - self._feedback_ns < FEEDBACK_NS:
            return
        self._feedback, self._feedback_ns = shown, self.now_ns
        leaves = executive.running_leaves
        elapsed_ns = self.now_ns - executive.started_ns if executive.started_ns else 0
        self.handle.publish_feedback(
            ExecuteMission.Feedback(
                status=shown[0],
                tip=shown[1],
                running=[leaf.name for leaf in leaves],
                doing=[leaf.feedback_message for leaf in leaves],
                elapsed=elapsed_ns / NS,
            )
        )


@dataclass(frozen=True, kw_only=True)
class MissionServerOptions:
    """The options of a mission server.

    Attributes:
        missions: The missions that clients may run.
        on_new_goal: What a mission does that comes while another runs: ``replace`` or ``refuse``;
            the default of the parameter of that name.
        allow_duplicates: Continue if several nodes publish the same odometry or clock.
        say: Called with each line; None is the ROS log.
        onlookers: Makes the onlookers of each mission, before its first tick.
        editable: Take new versions of the running mission from other processes.
    """

    missions: ServedMissions
    on_new_goal: str = ON_NEW_GOAL[0]
    allow_duplicates: bool = False
    say: Callable[[str], None] | None = None
    onlookers: Callable[[ServedSession], Iterable[Onlooker]] = lambda _: ()
    editable: bool = False


@dataclass(frozen=True)
class _WaitingGoal:
    """A goal that starts when the mission before it has ended, and its mission, checked."""

    handle: ServerGoalHandle
    mission: Mission


class BoundedMissionServer(BoundedRequests, ActionServer):
    """An action server of rclpy, whose requests are bounded."""


class MissionServer(ValidClock, Node):
    """Offers ``execute_mission``, and runs the missions.

    Args:
        host: Has the executor serve a node.
        drop: Removes a node from the executor, and destroys it.
        node: How to make this node, and that of each mission.
        options: All other options.
    """

    def __init__(
        self,
        host: Callable[[Node], Any],
        drop: Callable[[Node], Any],
        *,
        node: NodeOptions,
        options: MissionServerOptions,
    ) -> None:
        super().__init__(**node.arguments())
        self.host = host
        self.drop = drop
        self._options = node
        self._missions = options.missions
        self._refuses_duplicates = not options.allow_duplicates
        self._say = options.say or self._log_line
        self._make_onlookers = options.onlookers
        self._declare_on_new_goal(options.on_new_goal)
        self._rate = GoalRate(RESULT_TIMEOUT_S)
        self._lines = RateLimit(1.0, MOST_LINES)
        self._closed: str | None = None
        self._run: ServedSession | None = None
        self._waiting: _WaitingGoal | None = None
        self._ends: dict[bytes, Future] = {}
        self._status_publisher = StatusPublisher(self)
        self._status_publisher.publish_idle()
        self._is_editable = options.editable
        self._controls = MissionControls(lambda: self.executive)
        self._control_services = ControlServices(self, self._controls, self._revise)
        self._server = BoundedMissionServer(
            self,
            ExecuteMission,
            self.resolve_topic_name("execute_mission"),
            execute_callback=self._execute,
            goal_callback=self._check,
            handle_accepted_callback=self._take,
            cancel_callback=self._cancel,
            result_timeout=RESULT_TIMEOUT_S,
            goal_service_qos_profile=REQUESTS,
            result_service_qos_profile=REQUESTS,
            cancel_service_qos_profile=REQUESTS,
        )

    @property
    def executive(self) -> Executive | None:
        """The executive of the running mission, or None."""
        return self._run.executive if self._run else None

    @property
    def mission_node(self) -> Node:
        """The node with the clock of a running mission; without one, this node."""
        return self._run.mission_node if self._run else self

    @property
    def is_busy(self) -> bool:
        """Whether a mission runs or waits, or a result has to be sent."""
        return self._run is not None or self._waiting is not None or bool(self._ends)

    def close(self, reason: str) -> None:
        """Refuse missions from now on, and end the running one."""
        self._closed = reason
        if self._waiting is not None:
            self._give_up(reason)
        if self._run is not None:
            self._run.executive.interrupt(reason)

    def abandon(self, reason: str) -> None:
        """End the running mission at once; the orphaned goals are named."""
        if self._run is not None:
            self._run.executive.interrupt(reason)
            self._run.executive.abandon(reason)
            self._say(self._run.executive.reason)
            self._run.close()

    def look(self) -> None:
        """Advance: start the waiting goal, send feedback, end ended ones.

        Call it after each step.
        """
        run = self._run
        if run is not None:
            self._status_publisher.publish_if_changed()
            run.step()
            if run.is_done:
                self._finish(run)
        if self._run is None and self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            self._start(waiting)

    async def _revise(self, request: Any) -> Revision:
        assert self._run is not None, "a mission runs"
        return await self._run.runner.revise_on_request(request)

    def _log_line(self, text: str) -> None:
        log_of(self).info(text)

    # ---- the action ----------------------------------------------------------------------

    def _declare_on_new_goal(self, default: str) -> None:
        what = "What a mission does that comes while another runs: replace it, which ends first and"
        what += " is aborted, or be refused."
        descriptor = ParameterDescriptor(
            description=what, additional_constraints=" or ".join(ON_NEW_GOAL), read_only=True
        )
        chosen = self.declare_parameter("on_new_goal", default, descriptor).value
        if chosen not in ON_NEW_GOAL:
            raise BtMissionError(
                f"on_new_goal: expected {' or '.join(ON_NEW_GOAL)}, got {chosen}", code="BT-909"
            )
        self._replaces = chosen == "replace"

    def _check(self, _goal: Any) -> GoalResponse:
        why = self._closed
        if why is None and self.is_busy and not self._replaces:
            why = "another mission runs (on_new_goal: refuse)"
        now_ns = self.get_clock().now().nanoseconds
        if why is None:
            why = self._rate.refusal(now_ns)
        if why is None:
            self._rate.count(now_ns)
            return GoalResponse.ACCEPT
        if self._lines.admits(now_ns):
            self._say(f"mission refused: {why}")
        return GoalResponse.REJECT

    def _take(self, handle: ServerGoalHandle) -> None:
        self._ends[_key(handle)] = Future()
        if self._run is not None and any(
            goal.id == _key(handle) for goal in self._run.runner.ledger.open_goals
        ):
            why = "a mission cannot wait for another one on the executive that runs it; "
            why += "serve a second executive in another namespace"
            handle.execute()
            self._end(handle, Result.UNSOUND, why)
            return
        try:
            self._refuse_duplicates()
            mission = self._missions.load(handle.request)
        except Exception as error:  # noqa: BLE001 - a user's module may raise when it is imported
            handle.execute()
            self._refuse(handle, error)
            return
        if self._waiting is not None:
            self._give_up(REPLACED)
        if self._run is not None:
            self._run.executive.interrupt(REPLACED)
        self._waiting = _WaitingGoal(handle, mission)

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        if self._run is not None and handle == self._run.handle:
            self._run.executive.interrupt("canceled")
        elif self._waiting is not None and handle == self._waiting.handle:
            self._give_up("canceled")
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        code, result = await self._ends[_key(handle)]
        del self._ends[_key(handle)]
        if code == Result.NONE:
            handle.succeed()
        elif code == Result.STOPPED and handle.is_cancel_requested:
            handle.canceled()
        else:
            handle.abort()
        return result

    def _read_revision(self, running: Mission, request: Any) -> Mission:
        if not self._missions.allow_text:
            raise BtMissionError(NO_TEXT, code="BT-908")
        return read_revision(running, request, Permissions(python=self._missions.python))

    # ---- one mission ---------------------------------------------------------------------

    def _give_up(self, reason: str) -> None:
        """End the goal that waits."""
        waiting, self._waiting = self._waiting, None
        assert waiting is not None
        waiting.handle.execute()
        self._end(waiting.handle, Result.STOPPED, reason)

    def _start(self, waiting: _WaitingGoal) -> None:
        handle = waiting.handle
        handle.execute()
        try:
            self._refuse_duplicates()
            mission = self._missions.begin(handle.request, waiting.mission)
            node = MissionNode(
                mission,
                RunnerOptions(
                    say=self._say,
                    goal_seed=_key(handle).hex(),
                    has_controls=False,
                    has_presence=not self._options.lean,
                    read_revision=self._read_revision if self._is_editable else None,
                    allow_duplicates=not self._refuses_duplicates,
                ),
                node=replace(self._options, name="bt_mission_run", namespace=self.get_namespace()),
            )
        except Exception as error:  # noqa: BLE001 - a user's behaviour may raise when it is made
            self._refuse(handle, error)
            return
        self._run = served = ServedSession(handle, node, self)
        self.host(node)
        for onlooker in self._make_onlookers(served):
            served.attach(onlooker)
        if (why := duplicate_publishers(self)) is not None:
            node.runner.warn(why)
        self._controls.begin(node.runner.executive)
        self._status_publisher.begin(node.runner, node.runner.requirements)

    def _refuse(self, handle: ServerGoalHandle, error: Exception) -> None:
        """End a goal whose mission cannot start."""
        if isinstance(error, BtMissionError):
            self._say(f"mission not started:\n{error}")
            why = error.on_one_line if isinstance(error, InputError) else str(error)
            self._end(handle, Result.UNSOUND, why)
            return
        why = f"the mission cannot be set up: {type(error).__name__}: {error}"
        self._say(why)
        self._end(handle, Result.UNKNOWN, why)

    def _refuse_duplicates(self) -> None:
        """Raise BtMissionError if two robots would be taken for one."""
        why = duplicate_publishers(self) if self._refuses_duplicates else None
        if why is not None:
            raise BtMissionError(why, code="BT-914")

    def _finish(self, run: ServedSession) -> None:
        executive = run.executive
        report = run.runner.report()
        self._say(report.as_text())
        self._run = None
        run.close()  # a recording is whole before the client has its result
        self.drop(run.mission_node)
        codes = {
            MissionStatus.SUCCESS: Result.NONE,
            MissionStatus.FAILURE: Result.FAILED,
            MissionStatus.INTERRUPTED: Result.STOPPED,
        }
        code, reason = codes[executive.status], executive.reason
        if code == Result.NONE and not report.passed:
            code, reason = VIOLATED, report.failing
        self._end(
            run.handle,
            code,
            reason,
            status=report.status,
            summary=report.as_text(),
            duration=report.virtual_s,
            ticks=report.ticks,
            goals_sent=report.goals_sent,
            goals_left_behind=report.goals_left_behind,
        )

    def _end(self, handle: ServerGoalHandle, code: int, reason: str, **fields: Any) -> None:
        result = Result(error_code=code, error_msg=reason, **fields)
        self._ends[_key(handle)].set_result((code, result))


def _key(handle: ServerGoalHandle) -> bytes:
    return bytes(handle.goal_id.uuid)
