"""A person's part in a running graph: a node, a clock, and Ctrl-C."""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import ExitStack
from typing import Self

from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.parameter import Parameter

from bt_mission.base.interrupts import InterruptSignals
from bt_mission.base.stamps import NS
from bt_mission.ros.graph import GraphConnection

NODE_PREFIX = "_bt_mission_hand"
"""Names that begin with an underscore are hidden in ROS: lists leave them out."""


class GraphSession:
    """The session of a user in the graph of this machine and its network.

    Limits are measured with the machine's steady clock: a simulation may run at any speed, or
    stand.

    Args:
        namespace: The namespace of names without a leading slash.
    """

    def __init__(self, namespace: str = "") -> None:
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        with ExitStack() as made:
            self.interrupts = made.enter_context(InterruptSignals())
            self._graph = GraphConnection(wall_clock=True)
            made.callback(self._graph.close)
            self.node = self._graph.host_quiet(f"{NODE_PREFIX}_{os.getpid()}", namespace)
            self._exit = made.pop_all()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._exit.close()

    @property
    def now_ns(self) -> int:
        """Steady time, ns."""
        return int(self._clock.now().nanoseconds)

    def step(self) -> None:
        """Serve what is next, for a tenth of a second at most."""
        self._graph.step(None, self.node)

    def glance(self) -> None:
        """Handle received messages, without waiting for more."""
        self._graph.drain()

    def follow_clock(self) -> None:
        """Have the node's own clock follow ``/clock`` from now on."""
        self.node.set_parameters([Parameter("use_sim_time", value=True)])


def wait(session: GraphSession, seconds: float, is_done: Callable[[], bool]) -> bool:
    """Serve until a condition is true, for some seconds at most. Return whether it is.

    Raises:
        KeyboardInterrupt: Ctrl-C.
    """
    end_ns = session.now_ns + round(seconds * NS)
    while not is_done():
        if session.interrupts.count:
            raise KeyboardInterrupt
        if session.now_ns >= end_ns:
            return False
        session.step()
    return True
