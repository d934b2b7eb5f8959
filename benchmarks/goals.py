"""What a goal costs through a leaf, against an action client alone.

Each side has a lock-step executor of its own with two nodes: the client's, and a scripted server
that accepts at once and ends the goal at once. Both look at the goal in a timer of 20 Hz, and send
the next one at the tick after its end.
Run it as: python benchmarks/goals.py [--rounds N]
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from itertools import count
from typing import Any

import rclpy
from bt_mission_interfaces.action import Turn
from measuring import CpuWatch, arguments, figure, in_turns, ratios, spread, table, times
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from bt_mission.base.dds.discovery import isolate
from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import TICK_RATE_HZ, RunnerOptions
from bt_mission.ros.virtual_time import VirtualTimeExecutor
from bt_mission.sessions.load import load
from bt_mission.sessions.scripted_server import ScriptedServer

TURN = "bt_mission_interfaces/action/Turn"
Options = dict[str, Any]
ALONE = RunnerOptions(has_controls=False, has_presence=False)
LEAN: Options = {
    "enable_rosout": False,
    "start_parameter_services": False,
    "parameter_overrides": [Parameter("start_type_description_service", value=False)],
}
"""As a mission's node on the stage."""

GOALS = 200
"""Goals of one measurement."""

TURNS = """\
mission: turns
tree:
  repeat: {count: 100000}
  do:
    turn: {angle: 90}
    timeout: 60
    outputs: {angle_turned: turned}
"""


class QuickServer(ScriptedServer):
    """A server whose goals have all succeeded when they are accepted."""

    async def _on_goal(self, request: Any, answer: Any) -> Any:
        await super()._on_goal(request, answer)
        self.goal.succeed(angle_turned=90.0)
        return answer


class BareClient(Node):
    """Sends one goal after another with an action client, and nothing else."""

    def __init__(self, options: Options) -> None:
        super().__init__("bare", **options, **LEAN)
        self._client = ActionClient(self, Turn, "turn")
        self._is_busy = self._is_matched = False
        self._response: Any = None
        self.turned = 0.0
        self.create_timer(1 / TICK_RATE_HZ, self._tick)

    def _tick(self) -> None:
        if self._response is not None:
            self.turned = self._response.result.angle_turned
            self._response, self._is_busy = None, False
        elif not self._is_busy and self._has_server():
            self._is_busy = True
            future = self._client.send_goal_async(Turn.Goal(angle=90.0))
            future.add_done_callback(self._on_answer)

    def _has_server(self) -> bool:
        """Look until the server is there for the first time."""
        self._is_matched = self._is_matched or self._client.server_is_ready()
        return self._is_matched

    def _on_answer(self, future: Any) -> None:
        future.result().get_result_async().add_done_callback(self._on_result)

    def _on_result(self, future: Any) -> None:
        self._response = future.result()


class Side:
    """An executor with a client and its server, in a separate namespace.

    :param client: makes the client's node.
    """

    _count = count(1)

    def __init__(self, client: Callable[[Options], Node], server: type[ScriptedServer]) -> None:
        self._made = ExitStack()
        namespace = f"side_{next(self._count)}"
        context = Context()
        rclpy.init(context=context)
        self._made.callback(context.shutdown)
        host = Node("server", context=context, namespace=namespace, **LEAN)
        self.server = server(host, TURN, "turn")
        self.client = client({"context": context, "namespace": namespace})
        self.executor = VirtualTimeExecutor(context=context)
        self._made.callback(self.executor.shutdown)
        for node in (host, self.client):
            self._made.callback(node.destroy_node)
            self.executor.add_node(node)

    def close(self) -> None:
        """Take everything down."""
        self._made.close()

    def spend(self) -> float:
        """Seconds of one goal, from the tick that sends it to the one that sends the next."""
        last = len(self.server.goals) + GOALS
        watch = CpuWatch()
        while len(self.server.goals) < last:
            self.executor.step()
        return watch.elapsed_s / GOALS


def compare(rounds: int) -> None:
    """Print what a goal costs, by who sends it."""
    print("### A goal, its acceptance and its result\n")
    mission = load(TURNS)
    sides = (
        Side(
            lambda options: MissionNode(mission, ALONE, node=NodeOptions(lean=True, **options)),
            QuickServer,
        ),
        Side(BareClient, QuickServer),
    )
    for side in sides:
        side.spend()  # until everything is imported and matched
    ours, bare = in_turns(rounds, *(side.spend for side in sides))
    for side in sides:
        side.close()
    ours_us = figure("a goal through a leaf, CPU", times(1e6, ours), "us")
    to_bare = figure("a leaf to a bare client", ratios(ours, bare))
    more_us = [1e6 * (own - other) for own, other in zip(ours, bare, strict=True)]
    head = ("a leaf, us a goal", "`ActionClient` alone, us a goal", "ratio", "more, us a goal")
    table(head, [map(spread, (ours_us, times(1e6, bare), to_bare, more_us))])


def main() -> None:
    """Print the table."""
    options = arguments(__doc__, rounds=15)
    isolate(visible=False)
    compare(options.rounds)


if __name__ == "__main__":
    main()
