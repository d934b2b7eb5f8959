"""A program on a virtual clock, without a simulator."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from rclpy.node import Node

from bt_mission.programs import ProgramHost
from bt_mission.programs.executors import ProgramExecutor
from tests.support.rig import Rig


class Programs:
    """Runs functions as the code of programs on the clock of a rig."""

    def __init__(self, rig: Rig) -> None:
        self.rig = rig
        self.host = ProgramHost(rig.clock)
        self.program = self.host.program("program", "0", rig.context)

    def add(self, make: Callable[..., Node], **options: Any) -> Any:
        """Make a node as a program does, and serve it."""
        nodes: list[Node] = []
        self.host.make_node(
            self.program, lambda: make(context=self.rig.context, **options), nodes.append
        )
        while not nodes:
            self.rig.step()
        if isinstance(nodes[0].executor, ProgramExecutor):
            nodes[0].executor.keep_spinning()
        else:
            self.program.executor.add_node(nodes[0])
        return nodes[0]

    def run(self, function: Callable[..., Any], *args: Any) -> tuple[float, Any]:
        """Run a function as a task. Return the virtual time that it took, s, and its result."""
        start_s = self.rig.now_s
        results: list[Any] = []
        self.program.executor.create_task(lambda: results.append(function(*args)))
        self.rig.clock.run_until_quiet()
        while not results:
            self.rig.step()
        return round(self.rig.now_s - start_s, 9), results[0]


@pytest.fixture
def programs(rig: Rig) -> Iterator[Programs]:
    """Functions as the code of programs."""
    made = Programs(rig)
    yield made
    made.host.close()
