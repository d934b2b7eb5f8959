"""Shows every goal of an action, whoever sent it: its states and its feedback."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TextIO

from action_msgs.msg import GoalStatusArray
from rclpy.qos import QoSProfile, ReliabilityPolicy, qos_profile_action_status_default

from bt_mission.hand.canceling import FINAL, states_of
from bt_mission.hand.goal_lines import said
from bt_mission.hand.looking import FEEDBACK, STATUS
from bt_mission.hand.values import as_json, plain
from bt_mission.ros_types import action_type

if TYPE_CHECKING:
    from bt_mission.hand.about import About
    from bt_mission.hand.joining import Hand

DEPTH = 100


class Watch:
    """Writes a line for each change of a goal's state, and for feedback that has changed.

    :param hand: its node owns the subscriptions.
    :param action: the action's full name.
    :param about: its type.
    :param json: an object a line, with all feedback.
    """

    def __init__(
        self, hand: Hand, action: str, about: About, stream: TextIO, *, json: bool
    ) -> None:
        node = hand.node
        self._hand = hand
        self._stream = stream
        self._json = json
        self._units = about.part("feedback").units()
        self._states: dict[str, str] = {}
        self._since_ns: dict[str, int] = {}
        self._last: dict[str, str] = {}
        self._lines: list[str] = []
        node.create_subscription(
            GoalStatusArray, action + STATUS, self._on_status, qos_profile_action_status_default
        )
        node.create_subscription(
            action_type(about.type).Impl.FeedbackMessage,
            action + FEEDBACK,
            self._on_feedback,
            QoSProfile(depth=DEPTH, reliability=ReliabilityPolicy.BEST_EFFORT),
        )

    def flush(self) -> None:
        """Write what has come; here, outside of callbacks, a closed pipe may be noticed."""
        lines, self._lines = self._lines, []
        for line in lines:
            print(line, file=self._stream, flush=True)

    def _on_status(self, message: Any) -> None:
        states = states_of(message)
        for goal, state in states.items():
            if self._states.get(goal) == state:
                continue
            is_new = goal not in self._states
            self._states[goal] = state
            self._since_ns.setdefault(goal, self._hand.now_ns)
            if self._json:
                self._lines.append(as_json({"goal": goal, "state": state}))
            elif not (is_new and state in FINAL):  # ended before we looked
                self._lines.append(f"{goal[:8]} {self._since_s(goal):9.2f} s  {state}")
        for goal in self._states.keys() - states.keys():
            del self._states[goal]

    def _on_feedback(self, message: Any) -> None:
        goal = bytes(message.goal_id.uuid).hex()
        self._since_ns.setdefault(goal, self._hand.now_ns)
        if self._json:
            self._lines.append(as_json({"goal": goal, "feedback": plain(message.feedback)}))
            return
        text = said(message.feedback, self._units)
        if self._last.get(goal) != text:
            self._last[goal] = text
            self._lines.append(f"{goal[:8]} {self._since_s(goal):9.2f} s  {text}")

    def _since_s(self, goal: str) -> float:
        return (self._hand.now_ns - self._since_ns[goal]) / 1e9
