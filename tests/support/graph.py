"""A mission, and servers that the test plays, over real rclpy on one virtual clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.node import Node

from bt_mission.events.events import Event, NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.ros.graph import NodeOptions, destroy_actions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions
from bt_mission.sessions.load import load
from bt_mission.sessions.mission_server import MissionServer, MissionServerOptions
from bt_mission.sessions.served_missions import ServedMissions
from bt_mission.testing.scripted_server import ScriptedServer
from bt_mission.virtual_time import VirtualTimeExecutor
from bt_mission.virtual_time.discovery import pause

S = 1_000_000_000
TURN = "bt_mission_interfaces/action/Turn"
LEAN: dict[str, Any] = {"enable_rosout": False, "start_parameter_services": False}


class Rig:
    """Nodes on one virtual clock, which belong to a context of their own.

    Args:
        ros_args: For all nodes.
        clock: For the executor: where time begins, and the world that moves with it.
    """

    def __init__(self, ros_args: Sequence[str] = (), **clock: Any) -> None:
        self.context = Context()
        rclpy.init(context=self.context, args=["--ros-args", *ros_args] if ros_args else None)
        self.clock = VirtualTimeExecutor(context=self.context, **clock)
        self.nodes: list[Node] = []

    def close(self) -> None:
        """Destroy all nodes."""
        for node in reversed(list(dict.fromkeys([*self.nodes, *self.clock.get_nodes()]))):
            node.destroy_node()
            destroy_actions(node)
        self.clock.shutdown()
        self.context.shutdown()

    def node(self, name: str) -> Node:
        """Make a bare node."""
        node = Node(name, context=self.context, **LEAN)
        self.nodes.append(node)
        self.clock.add_node(node)
        return node

    def now(self, node: Node) -> int:
        """Return the time of a node's clock, ns."""
        return int(node.get_clock().now().nanoseconds)

    def step(self) -> None:
        """Go to the next instant."""
        self.clock.step()

    def steps_until(self, time_ns: int) -> None:
        """Go through all instants up to a time."""
        while self.clock.next_due_ns() <= time_ns:
            self.step()

    def settle(self, condition: Callable[[], bool] = lambda: True) -> None:
        """Serve until quiet, and until a condition holds, at this instant."""
        for _ in range(2000):
            self.clock.run_until_quiet()
            if condition():
                return
            pause(self.context)  # latched messages come by a thread of the middleware
        raise AssertionError("it never came")


@pytest.fixture
def rig() -> Iterator[Rig]:
    """Nodes on one virtual clock."""
    rig = Rig()
    yield rig
    rig.close()


class Graph(Rig):
    """A mission and servers; a beat of 20 Hz keeps time moving."""

    def __init__(self) -> None:
        super().__init__()
        self.client = self.node("client")
        self.client.create_timer(0.05, lambda: None)
        self.start_ns = self.clock.now_ns
        self.changes: list[NodeChanged] = []
        self.said: list[str] = []
        self.served: MissionServer | None = None

    def close(self) -> None:
        """Destroy all nodes, after what waits at this instant."""
        self.clock.run_until_quiet()
        super().close()

    # ---- who takes part ------------------------------------------------------------------

    def server(self, name: str = "turn", type_name: str = TURN, **habits: Any) -> ScriptedServer:
        """A server of its own node, which the test plays."""
        return ScriptedServer(self.node(f"{name}_server"), type_name, name, **habits)

    def mission(self, text: str, *, has_controls: bool = False, **where: Any) -> MissionRunner:
        """The executive of a mission, on a node of its own."""
        mission = load(text)
        options = RunnerOptions(
            say=self.said.append,
            goal_seed=str(mission.seed),
            has_controls=has_controls,
            has_presence=False,
        )
        node = MissionNode(
            mission, options, node=NodeOptions(context=self.context, lean=True, **where)
        )
        self.clock.add_node(node)
        node.runner.executive.events.subscribe(self._take)
        return node.runner

    def _take(self, event: Event) -> None:
        if isinstance(event, NodeChanged):
            self.changes.append(event)

    def serve(self, missions: ServedMissions | None = None, **options: Any) -> MissionServer:
        """The executive as a server, of missions in texts where nothing else is said."""
        self.served = MissionServer(
            self.clock.add_node,
            self.drop,
            node=NodeOptions(context=self.context, lean=True),
            options=MissionServerOptions(
                missions=missions or ServedMissions(allow_text=True),
                say=self.said.append,
                **options,
            ),
        )
        self.clock.add_node(self.served)
        return self.served

    def drop(self, node: Node) -> None:
        """A node leaves."""
        self.clock.remove_node(node)
        node.destroy_node()

    # ---- time ----------------------------------------------------------------------------

    @property
    def now_s(self) -> float:
        """Virtual time since the start, s."""
        return (self.clock.now_ns - self.start_ns) / S

    def step(self) -> None:
        """One instant."""
        self.clock.step()
        if self.served is not None:
            self.served.look()

    def run(self, seconds: float) -> None:
        """Let time pass."""
        self.steps_until(self.clock.now_ns + round(seconds * S))

    def until(self, done: Callable[[], Any], limit_s: float = 60.0) -> float:
        """Let time pass until something holds; gives the virtual time, s."""
        end_ns = self.clock.now_ns + round(limit_s * S)
        while not done():
            assert self.clock.now_ns < end_ns, f"not within {limit_s} s of virtual time"
            self.step()
        return self.now_s

    def until_heard(self, done: Callable[[], Any]) -> None:
        """Let time pass until the middleware's thread has brought something.

        That takes time of the wall, while a graph in which nothing happens passes through minutes
        of virtual time: so there is no limit that would be reached.
        """
        self.until(done, limit_s=1e6)

    def call(self, service_type: Any, name: str, **fields: Any) -> Any:
        """Call a service; gives its answer."""
        client = self.client.create_client(service_type, name)
        future = client.call_async(service_type.Request(**fields))
        self.until(future.done, 1.0)
        self.client.destroy_client(client)
        return future.result()


def outcome(executive: Executive, name: str) -> str:
    """What the leaf of this name says of its last goal."""
    (leaf,) = (node for node in executive.nodes if node.name == name)
    return leaf.feedback_message
