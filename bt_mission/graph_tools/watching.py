"""Hears every goal of an action, whoever sent it: its states and its feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from action_msgs.msg import GoalStatusArray
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_action_status_default

from bt_mission.graph_tools.canceling import FINAL, states_of
from bt_mission.graph_tools.graph_query import FEEDBACK, STATUS
from bt_mission.ros.interface_types import action_type

if TYPE_CHECKING:
    from bt_mission.graph_tools.graph_session import GraphSession
    from bt_mission.graph_tools.watch_views import WatchView

DEPTH = 100


class GoalWatch:
    """Tells a view of each change of a goal's state, and of all feedback.

    :param hand: its node owns the subscriptions.
    :param action: the action's full name.
    :param type_name: of the action. Raises UnknownType.
    """

    def __init__(self, hand: GraphSession, action: str, type_name: str, view: WatchView) -> None:
        self._hand = hand
        self._view = view
        self._states: dict[str, str] = {}
        self._since_ns: dict[str, int] = {}
        hand.node.create_subscription(
            GoalStatusArray, action + STATUS, self._on_status, qos_profile_action_status_default
        )
        hand.node.create_subscription(
            action_type(type_name).Impl.FeedbackMessage,
            action + FEEDBACK,
            self._on_feedback,
            QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT),
        )

    def _on_status(self, message: Any) -> None:
        for goal, state in states_of(message).items():
            before = self._states.get(goal)
            self._states[goal] = state
            # What ended before we looked is no news.
            if state != before and not (before is None and state in FINAL):
                self._view.state(goal, self._since_s(goal), state, is_end=state in FINAL)

    def _on_feedback(self, message: Any) -> None:
        goal = bytes(message.goal_id.uuid).hex()
        self._view.feedback(goal, self._since_s(goal), message.feedback)

    def _since_s(self, goal: str) -> float:
        first_ns = self._since_ns.setdefault(goal, self._hand.now_ns)
        return (self._hand.now_ns - first_ns) / 1e9
