"""The executor of live runs: rclpy's behaviour, at a fraction of its processor time.

rclpy's single-threaded executor makes a wait set of all entities for each callback that it serves,
which costs more than most of the callbacks. :class:`LiveExecutor` sleeps until the middleware
reports an arrival, or a timer is due. A round serves each entity once, then the timers that are
due. No entity waits for longer than a round, and messages that a queue has dropped are not waited
for.
"""

from __future__ import annotations

import os
import select
from collections.abc import Callable, Sequence
from typing import Any
from weakref import finalize

from rclpy.action import ActionServer
from rclpy.clock_type import ClockType
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Task
from rclpy.timer import Timer
from typing_extensions import override

from bt_mission.base.stamps import NS
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.ros.executors.callbacks import call_timer, take_timer
from bt_mission.ros.executors.entities import Entities, ns_until_due
from bt_mission.ros.executors.expiry import forget_expired, ns_until_expiry
from bt_mission.ros.executors.serving import ServingExecutor

ASK_S = 0.005
"""Wall time between two looks at entities that are not reported, s: guard conditions, callbacks
that await something other than a future, and all entities under a middleware that reports none.
"""


class LiveExecutor(ServingExecutor):
    """Serves nodes on their own clocks.

    The kernel counts a wait in milliseconds, so a timer may be served a millisecond late.

    Args:
        context: The rclpy context of the nodes; the default one without.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._bell = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._sleep = select.epoll()
        self._end = finalize(self, _close, self._bell, self._sleep)
        self._end.atexit = False
        self._wall_timers: list[Timer] = []
        self._servers: list[ActionServer] = []
        super().__init__(context=context)
        self._sleep.register(self._bell, select.EPOLLIN)
        self._sleep.register(self.arrivals.fileno(), select.EPOLLIN)

    @property
    @override
    def now_ns(self) -> int:
        return int(self._clock.now().nanoseconds)

    @override
    def wake(self) -> None:
        super().wake()
        self._ring()

    @override
    def create_task(self, callback: Any, *args: Any, **kwargs: Any) -> Task:
        task = super().create_task(callback, *args, **kwargs)
        self._ring()
        return task

    @override
    def shutdown(self, timeout_sec: float | None = None) -> bool:
        has_ended = super().shutdown(timeout_sec)
        self._ring()
        return has_ended

    @override
    def spin_once(self, timeout_sec: float | None = None) -> None:
        self.serve(timeout_sec)

    @override
    def spin_once_until_future_complete(self, future: Any, timeout_sec: Any = None) -> None:
        future.add_done_callback(lambda _: self.wake())
        self.serve(getattr(timeout_sec, "timeout", timeout_sec), future.done)

    def serve(
        self, timeout_sec: float | None = None, is_done: Callable[[], bool] = lambda: False
    ) -> bool:
        """Serve what is ready; if there is nothing, wait for it.

        Args:
            timeout_sec: Limit of the wait, s; None or a negative value is no limit.
            is_done: Ends the wait if it returns true when the executor wakes.

        Returns:
            Whether anything was served.

        Raises:
            ExternalShutdownException: The context has been shut down.
        """
        most_s = None if timeout_sec is None or timeout_sec < 0 else timeout_sec
        since = Stopwatch()
        left_s = most_s
        while not self._is_shutdown:
            self._wait(left_s)
            if not self._context.ok():
                raise ExternalShutdownException
            if self._serve_round():
                return True
            if most_s is not None:
                left_s = max(most_s - since.elapsed_s, 0.0)
            if is_done() or left_s == 0.0:
                return False
        return False

    # ---- inside --------------------------------------------------------------------------

    def _serve_round(self) -> bool:
        """Resume coroutines, serve each entity and timer once. Return whether any was served."""
        has_ended = self._begun.resume()
        ready = self._serve_ready()
        return self._serve_timers() or self._forget_results() or bool(ready) or has_ended

    def _serve_timers(self) -> bool:
        has_fired = False
        for timer in filter(self._can_be_served, self._entities.timers):
            if take_timer(timer.handle):
                has_fired = True
                self._served += 1
                if (rest := call_timer(timer)) is not None:
                    self._begin(timer, rest)
        return has_fired

    def _forget_results(self) -> bool:
        """Drop the results of actions that have expired. Return whether there may be any."""
        forgotten = map(forget_expired, filter(self._can_be_served, self._servers))
        return sum(forgotten) > 0

    @override
    def _read(self, nodes: Sequence[Node]) -> Entities:
        entities = Entities(nodes, self._context, self.arrivals, with_events=True)
        # Setting `use_sim_time` creates or destroys a subscription: read the entities again.
        self._wall_timers = [timer for timer in entities.timers if not _is_simulated(timer.clock)]
        self._servers = [each for each in entities.waitables if isinstance(each, ActionServer)]
        return entities

    def _wait(self, most_s: float | None) -> None:
        """Sleep until there is something to serve, or somebody rings."""
        for file, _ in self._sleep.poll(0 if self._is_busy else self._until_timer_s(most_s)):
            if file == self._bell:
                os.eventfd_read(file)

    @property
    def _is_busy(self) -> bool:
        """Return whether there is something to serve that is not reported again."""
        return (
            self._structure_changed
            or self._begun.can_go_on
            or any(map(self._can_be_served, self.arrivals.leftovers()))
        )

    def _until_timer_s(self, most_s: float | None) -> float | None:
        """Return the time until the next timer is due, s, at most a limit; None without either."""
        waits = [] if most_s is None else [most_s]
        if self._entities.asked or self._begun.await_the_unknown:
            waits.append(ASK_S)
        timers = filter(self._can_be_served, self._wall_timers)
        wait_ns = ns_until_due(timer.handle for timer in timers)
        if wait_ns is not None:
            waits.append(max(wait_ns, 0) / NS)
        for server in filter(self._can_be_served, self._servers):
            wait_ns = ns_until_expiry(server)
            if wait_ns is not None and not _is_simulated(server._node.get_clock()):
                waits.append(max(wait_ns, 0) / NS)
        return min(waits, default=None)

    def _ring(self) -> None:
        """End the sleep, from any thread."""
        if self._end.alive:
            os.eventfd_write(self._bell, 1)


def _is_simulated(clock: Any) -> bool:
    """Return whether a clock moves only with messages, each of which ends the sleep."""
    return clock.clock_type == ClockType.ROS_TIME and bool(clock.ros_time_is_active)


def _close(bell: int, sleep: select.epoll) -> None:
    sleep.close()
    os.close(bell)
