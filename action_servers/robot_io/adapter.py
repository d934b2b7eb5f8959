"""The one adapter between a ROS action and a maneuver.

A goal is checked before it is accepted. The pilot has its maneuver from the moment of acceptance,
so that an early cancel finds it. Execution only waits for the end.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any, Literal, TypeAlias

from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.exceptions import InvalidHandle
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.task import Future

from action_servers.core.action import Action, ServerContext
from action_servers.core.maneuver import (
    Fields,
    Finished,
    Maneuver,
    Observation,
    Refusal,
)
from action_servers.core.pilot import Interlock, ManeuverOutcome, ManeuverRun, Pilot, raised
from action_servers.robot_io.messages import fill, generated_type
from action_servers.robot_io.sensors import SensorSubscriptions
from bt_mission.base.action_requests import BoundedRequests
from bt_mission.base.geometry import Twist2D
from bt_mission.base.goal_rate import MOST_LINES, MOST_WAITING, GoalRate, RateLimit
from bt_mission.base.ros_log import log_of

SHOWN_CHARACTERS = 300


RESULT_TIMEOUT_S = 10
"""The time for which a result is kept, s, as by rcl_action's C++ servers; with rclpy's default of
900 s every status message would carry all goals of a quarter of an hour.
"""

REQUESTS = QoSProfile(depth=MOST_WAITING)

QUIET_S = 1.0
"""Seconds between two lines of the log about goals beyond the limit."""


Method: TypeAlias = Literal["step", "feedback", "result"]

Before: TypeAlias = Callable[[Method, Fields], "tuple[int, str] | None"]
"""Called before a method of a maneuver, with the newest feedback. The maneuver raises its
exceptions. Before a step, a code and a reason end the goal as aborted.
"""


class HookedManeuver:
    """A maneuver that others may have fail. `before` may change while it runs."""

    def __init__(self, maneuver: Maneuver, before: Sequence[Before]) -> None:
        self._maneuver = maneuver
        self._before = before
        self._feedback: Fields = {}

    @property
    def needs_base(self) -> bool:
        """As of the maneuver."""
        return self._maneuver.needs_base

    def step(self, now: Observation) -> Twist2D | Finished:
        """Return the step of the maneuver, or the end of the goal."""
        return self._ask("step") or self._maneuver.step(now)

    def feedback(self) -> Fields | None:
        """Return the feedback of the maneuver."""
        self._ask("feedback")
        fields = self._maneuver.feedback()
        if fields is not None:
            self._feedback = fields
        return fields

    def result(self) -> Fields:
        """Return the result of the maneuver."""
        self._ask("result")
        return self._maneuver.result()

    def _ask(self, method: Method) -> Finished | None:
        for before in tuple(self._before):
            end = before(method, self._feedback)
            if end is not None:
                return Finished("aborted", *end)
        return None


class BoundedActionServer(BoundedRequests, ActionServer):
    """An action server of rclpy, whose requests are bounded."""


class ActionAdapter:
    """Offers one action on a node; a pilot runs its goals.

    The result's `error_code` and `error_msg` (or `error_string`) are filled from the end of the
    maneuver. A goal whose maneuver raises is aborted with the cause. `interlock` may
    refuse it. `sensors` give the robot's state when a
    goal arrives, and `context` what its plan asks for.
    """

    def __init__(
        self,
        node: Node,
        pilot: Pilot,
        action: Action,
        context: ServerContext,
        sensors: SensorSubscriptions,
        interlock: Interlock,
        burst: int = 1,
    ) -> None:
        self._clock = node.get_clock()
        self._log = log_of(node).get_child(action.name)
        self._pilot = pilot
        self._action = action
        self._context = context
        self._type = generated_type(action.type)
        self._needs_map = "map" in action.needs
        self.name = node.resolve_topic_name(action.name)
        self._sensors = sensors
        self._interlock = interlock
        self._part = action.part
        self._next: Maneuver | None = None
        self._running: dict[bytes, tuple[ManeuverRun, Future]] = {}
        self._before: list[Before] = []
        self._closed: str | None = None
        self._rate = GoalRate(RESULT_TIMEOUT_S)
        self._lines = RateLimit(QUIET_S, MOST_LINES)
        self.refused = ""
        """Why the last goal was rejected; a rejection in ROS has no reason."""
        self._server = BoundedActionServer(
            node,
            self._type,
            self.name,  # resolved: rcl applies no remapping to the plain name of an action
            execute_callback=self._execute,
            goal_callback=self._check,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,
            result_timeout=RESULT_TIMEOUT_S,
            goal_service_qos_profile=REQUESTS,
            result_service_qos_profile=REQUESTS,
            cancel_service_qos_profile=REQUESTS,
            burst=burst,
        )

    def log_from(self, level: LoggingSeverity) -> None:
        """Log what becomes of goals from this level on, in the whole process."""
        self._log.set_level(level)

    def close(self, reason: str) -> None:
        """Refuse every goal from now on."""
        self._closed = reason

    def interpose(self, before: Before) -> Callable[[], None]:
        """Call a function before each step of the maneuvers; return a function that ends that."""
        self._before.append(before)
        for run, _ in self._running.values():
            run.maneuver = self._interposed(run.maneuver)

        def remove() -> None:
            if before in self._before:
                self._before.remove(before)

        return remove

    def destroy(self) -> None:
        """Withdraw the action; its goals must have ended."""
        self._server.destroy()  # type: ignore[no-untyped-call]  # rclpy's

    def _check(self, goal: Any) -> GoalResponse:
        now_ns = self._clock.now().nanoseconds
        too_many = self._rate.refusal(now_ns)
        if too_many is not None:
            self.refused = too_many
            self._log.warning(f"goal rejected: {too_many}", throttle_duration_sec=QUIET_S)
            return GoalResponse.REJECT
        why = self._closed
        try:
            if why is None:
                now = self._sensors.observe(on_map=self._needs_map)
                planned = self._action.planned(goal, now, self._context)
                if isinstance(planned, Refusal):
                    why = planned.reason
                else:
                    self._next, drives = planned, planned.needs_base
                    why = self._interlock.refusal(needs_base=drives, part=self._part)
        except Exception as error:  # noqa: BLE001 - no goal, whatever it holds, may end the server
            self._log.error("".join(traceback.format_exception(error)))
            why = f"{type(error).__name__}: {error}"
        if why is None:
            self._rate.count(now_ns)
            return GoalResponse.ACCEPT
        self.refused = why
        if self._lines.admits(now_ns):
            self._log.warning(f"goal rejected: {why}")
        return GoalResponse.REJECT

    def _begin(self, handle: ServerGoalHandle) -> None:
        maneuver, self._next = self._next, None
        assert maneuver is not None  # rclpy continues here directly after _check
        ended = Future()
        meanwhile = ExitStack()

        def on_end(outcome: ManeuverOutcome) -> None:
            meanwhile.close()
            ended.set_result(outcome)

        message = self._type.Impl.FeedbackMessage(goal_id=handle.goal_id)
        names: set[str] = set()

        def on_feedback(fields: Fields) -> None:
            nonlocal names
            if fields.keys() != names:  # a message of other fields would keep their values
                names = {*fields}
                message.feedback = self._type.Feedback()
            fill(message.feedback, fields, self._now)
            try:
                self._server.publish_feedback(message)
            except InvalidHandle:
                return  # the server is destroyed

        self._log.info(f"goal accepted: {shown(handle.request)}")
        title = f"{_key(handle).hex()[:8]} of {self.name}"
        run = ManeuverRun(
            self._interposed(maneuver),
            on_feedback,
            on_end,
            self._log.warning,
            self._part,
            title,
        )
        self._running[_key(handle)] = (run, ended)
        self._pilot.start(run)
        try:
            if self._needs_map:
                meanwhile.enter_context(self._sensors.localization())
            meanwhile.enter_context(self._action.during(maneuver, _key(handle).hex()))
        except Exception as error:  # noqa: BLE001 - the goal was accepted, so it ends with the cause
            self._pilot.fail(run, error)
        handle.execute()

    def _interposed(self, maneuver: Maneuver) -> Maneuver:
        if not self._before or isinstance(maneuver, HookedManeuver):
            return maneuver
        return HookedManeuver(maneuver, self._before)

    def _cancel(self, handle: ServerGoalHandle) -> CancelResponse:
        # Never refused: rclpy skips the goal after one whose cancel is refused, and a goal that has
        # just ended may still report its end after a cancel.
        running = self._running.get(_key(handle))
        if running is not None:
            self._pilot.cancel(running[0])
        return CancelResponse.ACCEPT

    async def _execute(self, handle: ServerGoalHandle) -> Any:
        _, ended = self._running[_key(handle)]
        outcome: ManeuverOutcome = await ended
        del self._running[_key(handle)]
        result, outcome = self._result(outcome)
        self._report(outcome)
        if outcome.status == "succeeded":
            handle.succeed()
        elif outcome.status == "canceled":
            handle.canceled()
        else:
            handle.abort()
        return result

    def _result(self, outcome: ManeuverOutcome) -> tuple[Any, ManeuverOutcome]:
        result = self._type.Result()
        try:
            fill(result, outcome.result or {}, self._now)
        except Exception as error:  # noqa: BLE001 - a result that cannot be sent ends no server
            result = self._type.Result()
            outcome = raised(error)
        codes = {
            "error_code": int(outcome.error_code),
            "error_msg": outcome.reason,
            "error_string": outcome.reason,
        }
        for name in codes.keys() & result.get_fields_and_field_types().keys():
            setattr(result, name, codes[name])
        return result, outcome

    def _now(self) -> Any:
        return self._clock.now().to_msg()

    def _report(self, outcome: ManeuverOutcome) -> None:
        if outcome.cause is not None:
            self._log.error("".join(traceback.format_exception(outcome.cause)))
        if outcome.status == "aborted":
            self._log.warning(f"goal aborted, code {int(outcome.error_code)}: {outcome.reason}")
        else:
            self._log.info(f"goal {outcome.status}")


def shown(message: Any) -> str:
    """Return the fields of a goal in one line of limited length."""
    fields = message.get_fields_and_field_types()
    text = ", ".join(
        f"{name}={_figure(getattr(message, name), kind)}" for name, kind in fields.items()
    )
    return text if len(text) <= SHOWN_CHARACTERS else f"{text[:SHOWN_CHARACTERS]}..."


def _figure(value: Any, kind: str) -> Any:
    """Return a value with the digits of its type: 0.2 as float32 is read as 0.20000000298."""
    return float(f"{value:.7g}") if kind == "float" else value


def _key(handle: ServerGoalHandle) -> bytes:
    return bytes(handle.goal_id.uuid)
