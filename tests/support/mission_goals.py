"""Goals of ``execute_mission`` that a test sends."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from bt_mission_interfaces.action import ExecuteMission
from rclpy.action import ActionClient

STATUS = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}


class Sent:
    """A goal of a client."""

    def __init__(self, ros: Any, client: ActionClient, **fields: Any) -> None:
        self._ros = ros
        self.feedback: list[Any] = []
        self._answer = client.send_goal_async(
            ExecuteMission.Goal(**fields),
            feedback_callback=lambda message: self.feedback.append(message.feedback),
        )
        ros.until(self._answer.done)
        self.handle = self._answer.result()
        self.accepted = self.handle.accepted
        self._end = self.handle.get_result_async() if self.accepted else None

    def cancel(self) -> None:
        """Ask for its end."""
        self._ros.until(self.handle.cancel_goal_async().done)

    @property
    def is_done(self) -> bool:
        """Has it ended?"""
        return self._end is not None and self._end.done()

    def end(self) -> tuple[str, Any]:
        """Wait for its end; gives how it ended, and the result."""
        assert self._end is not None
        self._ros.until(self._end.done)
        return STATUS[self._end.result().status], self._end.result().result
