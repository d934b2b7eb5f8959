"""Goals of an action, from any sender: watched, or cancelled and awaited."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from bt_mission.base.diagnostics import listed
from bt_mission.base.errors import BtMissionError, NotThereError
from bt_mission.base.stamps import NS
from bt_mission.commands.graph.goal_events import FeedbackReceived, GoalEvent, GoalStateChanged
from bt_mission.commands.graph.goal_request import ANSWER_S, GRACE_S
from bt_mission.commands.graph.graph_query import FEEDBACK, STATUS
from bt_mission.executive.goals.goal import NO_CALLBACK
from bt_mission.ros.graph import REQUESTS
from bt_mission.ros.graph_session import wait
from bt_mission.ros.interface_types import action_type

if TYPE_CHECKING:
    from bt_mission.ros.graph_session import GraphSession

STATUS_WAIT_S = 1.0
"""The status of goals is latched: it arrives as soon as the topic is matched."""

STATES = {
    GoalStatus.STATUS_UNKNOWN: "unknown",
    GoalStatus.STATUS_ACCEPTED: "accepted",
    GoalStatus.STATUS_EXECUTING: "executing",
    GoalStatus.STATUS_CANCELING: "canceling",
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}
FINAL = ("succeeded", "canceled", "aborted")

ALL = "0" * 32
"""The id that stands for every goal of an action."""

FEEDBACK_DEPTH = 100


class GoalWatch:
    """Hears each change of a goal's state, and all feedback. Raises UnknownType."""

    def __init__(self, session: GraphSession, action: str, type_name: str) -> None:
        self._session = session
        self._states: dict[str, str] = {}
        self._since_ns: dict[str, int] = {}
        self._events: list[GoalEvent] = []
        _subscribe_to_states(session, action, self._on_states)
        session.node.create_subscription(
            action_type(type_name).Impl.FeedbackMessage,
            action + FEEDBACK,
            self._on_feedback,
            QoSProfile(depth=FEEDBACK_DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT),
        )

    def take(self) -> Iterator[GoalEvent]:
        """Return the events since the last call.

        The caller writes them outside of callbacks, where a closed pipe is noticed.
        """
        events, self._events = self._events, []
        yield from events

    def _on_states(self, states: dict[str, str]) -> None:
        for goal, state in states.items():
            before = self._states.get(goal)
            self._states[goal] = state
            is_end = state in FINAL
            # Goals that ended before the start are not reported.
            if state != before and not (before is None and is_end):
                self._events.append(GoalStateChanged(goal, self._since_s(goal), state, is_end))

    def _on_feedback(self, message: Any) -> None:
        goal = bytes(message.goal_id.uuid).hex()
        self._events.append(FeedbackReceived(message.feedback, self._since_s(goal), goal))

    def _since_s(self, goal: str) -> float:
        first_ns = self._since_ns.setdefault(goal, self._session.now_ns)
        return (self._session.now_ns - first_ns) / NS


@dataclass(frozen=True)
class CancelResult:
    """Whether the server accepted every cancel, and whether the end of every goal was confirmed."""

    all_taken: bool
    all_ended: bool


def cancel_goals(
    session: GraphSession, action: str, digits: str, say: Callable[[str], None], *, server_s: float
) -> CancelResult:
    """Cancel the goal whose id begins with these digits, or all, and wait for their end.

    Raises:
        NotThereError: The action has no server.
        BtMissionError: No goal, or more than one, has such an id.
        KeyboardInterrupt: Ctrl-C.
    """
    states: dict[str, str] = {}
    _subscribe_to_states(session, action, states.update)
    client = session.node.create_client(
        CancelGoal, f"{action}/_action/cancel_goal", qos_profile=REQUESTS
    )
    if not wait(session, server_s, client.service_is_ready):
        raise NotThereError(f"no server of {action} after {server_s:g} s")
    wait(session, STATUS_WAIT_S, lambda: bool(states))
    asked = _chosen(states, digits) if digits else ALL
    under_way = {goal_id for goal_id, state in states.items() if state not in FINAL}
    request = CancelGoal.Request(goal_info=GoalInfo(goal_id=UUID(uuid=list(bytes.fromhex(asked)))))
    future = client.call_async(request)
    if not wait(session, ANSWER_S, future.done):
        say(f"{action} did not answer within {ANSWER_S:g} s")
        return CancelResult(all_taken=True, all_ended=False)
    taken = {bytes(canceling.goal_id.uuid).hex() for canceling in future.result().goals_canceling}
    refused = (under_way if asked == ALL else under_way & {asked}) - taken
    if not taken and not refused:
        say(f"no goal of {action} is running" if asked == ALL else f"goal {asked[:8]} has ended")
    for goal in sorted(refused):
        say(f"goal {goal[:8]}: the server refused to cancel{NO_CALLBACK}")
    ended = wait(session, GRACE_S, lambda: all(states.get(goal_id) in FINAL for goal_id in taken))
    for goal in sorted(taken):
        state = states.get(goal, "unknown")
        late = "" if state in FINAL else f": its end was not confirmed within {GRACE_S:g} s"
        say(f"goal {goal[:8]} {state}{late}")
    return CancelResult(all_taken=not refused, all_ended=ended and not refused)


def _subscribe_to_states(
    session: GraphSession, action: str, take: Callable[[dict[str, str]], None]
) -> None:
    """Have the states of an action's goals taken, each by the digits of the goal's id."""

    def on_status(message: Any) -> None:
        take(
            {
                bytes(status.goal_info.goal_id.uuid).hex(): STATES.get(status.status, "unknown")
                for status in message.status_list
            }
        )

    session.node.create_subscription(
        GoalStatusArray, action + STATUS, on_status, qos_profile_action_status_default
    )


def _chosen(states: dict[str, str], digits: str) -> str:
    """Return the goal of an id; a whole id is taken as it is."""
    wanted = digits.replace("-", "").lower()
    if not wanted or any(digit not in "0123456789abcdef" for digit in wanted):
        raise BtMissionError(
            f"expected hexadecimal digits of a goal's id, got '{digits}'", code="BT-1101"
        )
    matches = [goal for goal in states if goal.startswith(wanted)]
    if len(matches) == 1:
        return matches[0]
    if len(wanted) == 32:
        return wanted
    known = listed(goal[:8] for goal, state in states.items() if state not in FINAL)
    what = "several goals have" if matches else "no goal has"
    raise BtMissionError(
        f"{what} an id that begins with {wanted} (running: {known})", code="BT-912"
    )
