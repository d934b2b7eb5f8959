"""The executive alone, on the clock of the ROS graph it joins."""

from __future__ import annotations

import secrets
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING, Self

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from bt_mission.executive import MissionStatus
from bt_mission.node import MissionNode
from bt_mission.pacing import Stopwatch

if TYPE_CHECKING:
    from rclpy.node import Node

    from bt_mission.mission import Mission

CLOCK_TOPIC = "/clock"
WAIT_S = 0.1
CLOCK_WAIT_S = 4.0
"""Wall time to look for a publisher of ``/clock`` before this machine's clock is taken; and to
see time stand still without a publisher before it counts as gone. Fast DDS announces a
participant anew every 3 s, so discovery may take that long."""

END_WAIT_S = 10.0
"""Wall time after which a mission that ends leaves the goals that nobody confirms."""


class Attached:
    """Runs one mission against action servers in other processes.

    Time is the graph's: ``/clock`` where somebody publishes it, else the clock of this machine.

    :param mission: what to carry out.
    :param namespace: of the robot whose servers to use.
    :param wall_clock: keep to this machine's clock, without looking for ``/clock``.
    :param say: where ``log`` nodes speak to; None is the ROS log.
    :raises BtMissionError: when the mission cannot be set up.
    """

    collisions: int | None = None
    distance_travelled_m: float | None = None

    def __init__(
        self,
        mission: Mission,
        *,
        namespace: str | None = None,
        wall_clock: bool = False,
        say: Callable[[str], None] | None = None,
    ) -> None:
        self.mission = mission
        with ExitStack() as made:
            context = rclpy.Context()
            rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
            made.callback(context.shutdown)
            self._executor = SingleThreadedExecutor(context=context)
            made.callback(self._executor.shutdown)
            probe = rclpy.create_node("bt_mission_probe", context=context, enable_rosout=False)
            self._follows_clock = not wall_clock and self._find_clock(probe)
            self.node = MissionNode(
                mission,
                context=context,
                namespace=namespace,
                use_sim_time=self._follows_clock,
                say=say,
                # A server remembers ids for a while: another run must not repeat them.
                goal_seed=secrets.token_hex(8),
            )
            made.callback(self.node.destroy_node)
            # Not earlier: with its last node a context leaves the graph, and all it has found.
            probe.destroy_node()
            self._executor.add_node(self.node)
            self._exit = made.pop_all()
        self.executive = self.node.executive
        self.trace = self.node.trace
        self._since_last_time = Stopwatch()
        self._seen_ns = 0
        self._ending: Stopwatch | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    @property
    def is_done(self) -> bool:
        """Has the mission ended, with every goal accounted for?"""
        return self.executive.is_done

    @property
    def now_ns(self) -> int:
        """ROS time, ns."""
        return self.node.now_ns

    @property
    def start_ns(self) -> int:
        """ROS time of the first tick, ns; before it, the present."""
        return self.executive.started_ns or self.now_ns

    def step(self) -> None:
        """Serve what comes next, for at most a tenth of a second."""
        try:
            self._executor.spin_once(timeout_sec=WAIT_S)
        except Exception as error:  # noqa: BLE001 - a callback may raise anything; goals come first
            self.executive.fail(f"a callback failed: {type(error).__name__}: {error}")
        if self._follows_clock:
            self._watch_clock()
        if self.executive.status is MissionStatus.ENDING:
            self._see_to_the_end()

    def _see_to_the_end(self) -> None:
        """Look at the last goals also while ROS time stands still, for a bounded wall time."""
        self._ending = self._ending or Stopwatch()
        self.executive.tick()
        if self._ending.elapsed_s > END_WAIT_S:
            self.executive.abandon(f"not every goal had ended after {END_WAIT_S:g} s")

    def _find_clock(self, probe: Node) -> bool:
        watch = Stopwatch()
        self._executor.add_node(probe)
        while not (found := probe.count_publishers(CLOCK_TOPIC) > 0):
            if watch.elapsed_s > CLOCK_WAIT_S:
                break
            self._executor.spin_once(timeout_sec=WAIT_S)
        self._executor.remove_node(probe)
        return found

    def _watch_clock(self) -> None:
        """End the mission when the publisher of ``/clock`` has left and time stands still."""
        now_ns = self.now_ns
        if now_ns != self._seen_ns:
            self._seen_ns = now_ns
            self._since_last_time = Stopwatch()
        elif self._since_last_time.elapsed_s > CLOCK_WAIT_S and not self.node.count_publishers(
            CLOCK_TOPIC
        ):
            self.executive.abandon(f"{CLOCK_TOPIC} has gone: time stands still")
