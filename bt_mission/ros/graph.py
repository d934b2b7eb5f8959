"""A ROS graph that other processes make up, its time, and the care for a mission on it."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.executive.executive import Executive, MissionStatus

if TYPE_CHECKING:
    from rclpy.node import Node

CLOCK_TOPIC = "/clock"
WAIT_S = 0.1
CLOCK_WAIT_S = 4.0
"""Wall time to look for a publisher of ``/clock`` before this machine's clock is taken; and to
see time stand still without a publisher before it counts as gone. Other participants of Fast DDS
announce themselves every 3 s, so discovery may take that long."""

QUIET: dict[str, Any] = {
    "enable_rosout": False,
    "start_parameter_services": False,
    "parameter_overrides": [Parameter("start_type_description_service", value=False)],
}
"""For a node that only looks on: no services of its own for others to find."""

LAST_ROUNDS = 20
"""Callbacks that may still run before a graph is left."""

END_WAIT_S = 10.0
"""Wall time after which a mission that ends leaves the goals that nobody confirms."""


@dataclass(frozen=True)
class ProcessNode:
    """A node of this process, whose publishers can be tapped.

    :param is_sensor: it sends only what somebody subscribes to, and the messages of a topic have
        one shape: as many elements in each sequence, as many characters in each text.
    """

    node: Node
    is_sensor: bool = False


class GraphConnection:
    """An executor on a graph that others make up.

    Time is the graph's: ``/clock`` where somebody publishes it, else the clock of this machine.

    :param wall_clock: keep to this machine's clock, without looking for ``/clock``.
    """

    def __init__(self, *, wall_clock: bool = False) -> None:
        with ExitStack() as made:
            self.context = rclpy.Context()
            rclpy.init(context=self.context, signal_handler_options=SignalHandlerOptions.NO)
            made.callback(self.context.shutdown)
            self.executor = SingleThreadedExecutor(context=self.context)
            made.callback(self.executor.shutdown)
            self._probe: Node | None = rclpy.create_node(
                "bt_mission_probe", context=self.context, **QUIET
            )
            self.has_clock = not wall_clock and self._find_clock(self._probe)
            self._exit = made.pop_all()
        self._since_last_time = Stopwatch()
        self._seen_ns = 0
        self._ending: tuple[Executive, Stopwatch] | None = None

    def close(self) -> None:
        """Leave the graph."""
        self._exit.close()

    def host(self, node: Node) -> None:
        """Serve a node, too."""
        self.executor.add_node(node)
        if self._probe is not None:
            # Not earlier: with its last node a context leaves the graph, and all it has found.
            self._probe.destroy_node()
            self._probe = None

    def drop(self, node: Node) -> None:
        """Serve a node no longer, and destroy it."""
        self.executor.remove_node(node)
        node.destroy_node()

    def step(self, executive: Executive | None, node: Node) -> None:
        """Serve what comes next, for at most a tenth of a second, and care for a mission.

        An exception in a callback ends it as failed; so does a clock that has gone. Its end is
        bounded by wall time, also where ROS time stands still.

        :param executive: of the mission that runs; without one an exception is the caller's.
        :param node: whose clock is the mission's.
        """
        try:
            self.executor.spin_once(timeout_sec=WAIT_S)
        except Exception as error:
            if executive is None:
                raise
            executive.fail(f"a callback failed: {type(error).__name__}: {error}")
        if executive is None:
            self._since_last_time = Stopwatch()
            return
        if self.has_clock:
            self._watch_clock(executive, node)
        if executive.status is MissionStatus.ENDING:
            self._see_to_the_end(executive)

    def drain(self) -> None:
        """Let results and answers that are on their way go out."""
        for _ in range(LAST_ROUNDS):
            self.executor.spin_once(timeout_sec=0.0)

    def _see_to_the_end(self, executive: Executive) -> None:
        if self._ending is None or self._ending[0] is not executive:
            self._ending = (executive, Stopwatch())
        executive.tick()
        if self._ending[1].elapsed_s > END_WAIT_S:
            executive.abandon(f"not every goal had ended after {END_WAIT_S:g} s")

    def _find_clock(self, probe: Node) -> bool:
        watch = Stopwatch()
        self.executor.add_node(probe)
        while not (found := probe.count_publishers(CLOCK_TOPIC) > 0):
            if watch.elapsed_s > CLOCK_WAIT_S:
                break
            self.executor.spin_once(timeout_sec=WAIT_S)
        self.executor.remove_node(probe)
        return found

    def _watch_clock(self, executive: Executive, node: Node) -> None:
        """End a mission when the publisher of ``/clock`` has left and time stands still."""
        now_ns = node.get_clock().now().nanoseconds
        if now_ns != self._seen_ns:
            self._seen_ns = now_ns
            self._since_last_time = Stopwatch()
        elif self._since_last_time.elapsed_s > CLOCK_WAIT_S and not node.count_publishers(
            CLOCK_TOPIC
        ):
            executive.abandon(f"{CLOCK_TOPIC} has gone: time stands still")
