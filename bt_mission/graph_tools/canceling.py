"""Cancels goals of an action, whoever sent them, and sees them end."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalInfo, GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.qos import qos_profile_action_status_default
from unique_identifier_msgs.msg import UUID

from bt_mission.core.diagnostics import listed
from bt_mission.core.errors import BtMissionError, NotThereError
from bt_mission.graph_tools.goal_request import ANSWER_S, GRACE_S
from bt_mission.graph_tools.graph_query import STATUS
from bt_mission.graph_tools.graph_session import wait

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession

STATUS_WAIT_S = 1.0
"""The status of goals is latched: it comes as soon as the topic is matched."""

STATES = {
    GoalStatus.STATUS_UNKNOWN: "unknown",
    GoalStatus.STATUS_ACCEPTED: "accepted",
    GoalStatus.STATUS_EXECUTING: "executing",
    GoalStatus.STATUS_CANCELING: "canceling",
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}
ALL = "0" * 32
"""The id that stands for every goal of an action."""

FINAL = ("succeeded", "canceled", "aborted")


def states_of(message: Any) -> dict[str, str]:
    """The state of each goal that a status message tells of, by the digits of its id."""
    return {
        bytes(one.goal_info.goal_id.uuid).hex(): STATES.get(one.status, "unknown")
        for one in message.status_list
    }


@dataclass(frozen=True)
class Canceled:
    """What came of it.

    :param all_taken: did the server take every cancel?
    :param all_ended: was the end of every goal confirmed?
    """

    all_taken: bool
    all_ended: bool


def cancel_goals(
    hand: GraphSession, action: str, digits: str, say: Callable[[str], None], *, server_s: float
) -> Canceled:
    """Cancel the goal whose id begins with these digits, or all, and wait for their end.

    :raises NotThereError: when nobody serves the action.
    :raises BtMissionError: when no goal, or more than one, has such an id.
    :raises KeyboardInterrupt: when Ctrl-C came.
    """
    states: dict[str, str] = {}
    node = hand.node
    node.create_subscription(
        GoalStatusArray,
        action + STATUS,
        lambda message: states.update(states_of(message)),
        qos_profile_action_status_default,
    )
    client = node.create_client(CancelGoal, f"{action}/_action/cancel_goal")
    if not wait(hand, server_s, client.service_is_ready):
        raise NotThereError(f"no server of {action} after {server_s:g} s")
    wait(hand, STATUS_WAIT_S, lambda: bool(states))
    asked = _chosen(states, digits) if digits else ALL
    under_way = {one for one, state in states.items() if state not in FINAL}
    request = CancelGoal.Request(goal_info=GoalInfo(goal_id=UUID(uuid=list(bytes.fromhex(asked)))))
    future = client.call_async(request)
    if not wait(hand, ANSWER_S, future.done):
        say(f"{action} did not answer within {ANSWER_S:g} s")
        return Canceled(all_taken=True, all_ended=False)
    taken = {bytes(one.goal_id.uuid).hex() for one in future.result().goals_canceling}
    refused = (under_way if asked == ALL else under_way & {asked}) - taken
    if not taken and not refused:
        say(f"no goal of {action} is under way" if asked == ALL else f"goal {asked[:8]} has ended")
    return _see_ended(hand, states, taken, refused, say)


def _see_ended(
    hand: GraphSession,
    states: dict[str, str],
    taken: set[str],
    refused: set[str],
    say: Callable[[str], None],
) -> Canceled:
    for goal in sorted(refused):
        say(f"goal {goal[:8]}: the server refused to cancel")
    wait(hand, GRACE_S, lambda: all(states.get(one) in FINAL for one in taken))
    for goal in sorted(taken):
        state = states.get(goal, "unknown")
        late = "" if state in FINAL else f": its end was not confirmed within {GRACE_S:g} s"
        say(f"goal {goal[:8]} {state}{late}")
    ended = all(states.get(one) in FINAL for one in taken)
    return Canceled(all_taken=not refused, all_ended=ended and not refused)


def _chosen(states: dict[str, str], digits: str) -> str:
    """The goal that is meant; a whole id is taken as it is."""
    wanted = digits.replace("-", "").lower()
    if not wanted or any(digit not in "0123456789abcdef" for digit in wanted):
        raise BtMissionError(f"expected hexadecimal digits of a goal's id, got '{digits}'")
    found = [goal for goal in states if goal.startswith(wanted)]
    if len(found) == 1:
        return found[0]
    if len(wanted) == 32:
        return wanted
    known = listed(goal[:8] for goal, state in states.items() if state not in FINAL)
    what = "several goals have" if found else "no goal has"
    raise BtMissionError(f"{what} an id that begins with {wanted} (under way: {known})")
