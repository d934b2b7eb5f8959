"""Requests to an action server of rclpy: how many wait for a result, how many are answered."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

MOST_RESULT_REQUESTS = 1_000
"""Requests for the result of one goal that wait until it ends; a client makes one."""

BURST = 8
"""Requests of a kind that are answered in a row: looking for other ready entities costs rclpy as
much as a response. Those, such as the control step, wait meanwhile.
"""


class BoundedRequests:
    """Mixed in before rclpy's `ActionServer`, which keeps every request for a result.

    Beyond the limit they are answered at once, with the status unknown.

    Args:
        burst: The number of requests of a kind that are answered in a row.
    """

    def __init__(self, *args: Any, burst: int = 1, **options: Any) -> None:
        self._burst = burst
        self._result_requests: dict[bytes, int] = {}
        super().__init__(*args, **options)

    if TYPE_CHECKING:  # what rclpy's has

        def __getattr__(self, name: str) -> Any: ...

    def publish_feedback(self, message: Any) -> None:
        """Publish a feedback message, which includes its goal's id.

        `ServerGoalHandle.publish_feedback` makes a new one each time, for half of its cost.
        """
        self._handle.publish_feedback(message)

    async def execute(self, taken_data: dict[str, Any]) -> None:
        """Answer what was taken, and further requests up to the burst."""
        await self._answer(taken_data)
        for _ in range(self._burst - 1):
            taken_data = self._take_more(taken_data)
            if not taken_data:
                return
            await self._answer(taken_data)

    async def _answer(self, taken: dict[str, Any]) -> None:
        if "result" in taken and self._is_beyond_limit(*taken["result"]):
            taken = {part: data for part, data in taken.items() if part != "result"}
        server: Any = super()
        await server.execute(taken)
        if "expired" in taken:
            counts = self._result_requests
            self._result_requests = {
                goal: counts[goal] for goal in counts if goal in self._goal_handles
            }

    def _take_more(self, former: dict[str, Any]) -> dict[str, Any]:
        """Take another request of each ready kind."""
        self._is_goal_request_ready = "goal" in former
        self._is_cancel_request_ready = "cancel" in former
        self._is_result_request_ready = "result" in former
        self._is_goal_expired = False
        taken: dict[str, Any] = self.take_data()
        return taken

    def _is_beyond_limit(self, header: Any, request: Any) -> bool:
        """Count a request for a result; return whether it is beyond the limit and was answered."""
        goal = bytes(request.goal_id.uuid)
        future = self._result_futures.get(goal)
        if future is None or future.done():
            return False  # answered at once with the present status
        count = self._result_requests.get(goal, 0)
        if count < MOST_RESULT_REQUESTS:
            self._result_requests[goal] = count + 1
            return False
        answer = self.action_type.Impl.GetResultService.Response()  # its status is unknown
        self._handle.send_result_response(header, answer)
        return True
