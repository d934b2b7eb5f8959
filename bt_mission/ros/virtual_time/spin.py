"""rclpy's ways to spin, in virtual time."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from rclpy.executors import ExternalShutdownException
from rclpy.task import Future

from bt_mission.base.errors import BtMissionError
from bt_mission.base.stamps import NS
from bt_mission.ros.executors.serving import ServingExecutor


class TimeStuckError(BtMissionError):
    """Callbacks keep each other busy, so virtual time cannot advance."""

    code = "BT-903"


class NothingDueError(BtMissionError):
    """There is neither a timer nor a world that could move time."""

    code = "BT-903"

    def __init__(self) -> None:
        super().__init__("virtual time cannot move: no timer is set, and no world exists")


class NestedStepError(BtMissionError):
    """A callback waits for time to move, which waits for the callback to end."""

    code = "BT-903"

    def __init__(self) -> None:
        super().__init__(
            "a callback cannot spin: virtual time moves only when all callbacks have returned; "
            "make it `async def`, and await the future"
        )


class Spinning(ServingExecutor):
    """An executor that spins by steps; no timeout waits for the wall clock."""

    @abstractmethod
    def call_at(self, time_ns: int, function: Callable[[], Any]) -> Any:
        """Call a function at an instant."""

    @abstractmethod
    def run_until_quiet(self) -> None:
        """Serve callbacks at the present instant until none is ready."""

    @abstractmethod
    def step(self) -> int:
        """Jump to the next due instant and serve it."""

    def spin_once(self, timeout_sec: float | None = None) -> None:  # noqa: ARG002 - rclpy's form
        """Serve what is ready, then one step.

        Raises:
            ExternalShutdownException: When the context has been shut down.
        """
        self.spin_once_until_future_complete(Future())

    def spin_once_until_future_complete(
        self,
        future: Any,
        timeout_sec: Any = None,  # noqa: ARG002 - rclpy's form
    ) -> None:
        """Serve what is ready, then one step, unless ``future`` is done by then."""
        if self._is_shutdown:
            return
        if not self._context.ok():
            raise ExternalShutdownException
        self.run_until_quiet()
        if self._goes_on(future):
            self.step()

    def spin_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
        """Spin until ``future`` is done, or ``timeout_sec`` of virtual time have passed."""
        passed: list[None] = []
        if timeout_sec is not None and timeout_sec >= 0:
            end_ns = self.now_ns + round(timeout_sec * NS)
            self.call_at(end_ns, lambda: passed.append(None))
        while not passed and self._goes_on(future):
            self.spin_once_until_future_complete(future)

    def _goes_on(self, future: Any) -> bool:
        ended = future.done() or future.cancelled() or self._is_shutdown
        return not ended and self._context.ok()
