"""A mission, and servers that the test plays, over real rclpy on one virtual clock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node

from bt_mission.executive.events.events import Event, NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.ros.graph import NodeOptions
from bt_mission.ros.mission_node import MissionNode
from bt_mission.ros.mission_runner import MissionRunner, RunnerOptions
from bt_mission.sessions.load import load
from bt_mission.sessions.mission_server import MissionServer, MissionServerOptions
from bt_mission.sessions.revising import read_revision
from bt_mission.sessions.scripted_server import ScriptedServer
from bt_mission.sessions.served_missions import ServedMissions
from tests.support.rig import Rig

S = 1_000_000_000
TURN = "bt_mission_interfaces/action/Turn"


class Graph(Rig):
    """A mission and servers; a beat of 20 Hz keeps time moving."""

    def __init__(self) -> None:
        super().__init__()
        self.client = self.node("client")
        self.client.create_timer(0.05, lambda: None)
        self.changes: list[NodeChanged] = []
        self.logged: list[str] = []
        self.served: MissionServer | None = None

    def close(self) -> None:
        """Destroy all nodes, after what waits at this instant."""
        self.clock.run_until_quiet()
        super().close()

    # ---- who takes part ------------------------------------------------------------------

    def server(self, name: str = "turn", type_name: str = TURN, **habits: Any) -> ScriptedServer:
        """A server of its own node, which the test plays."""
        return ScriptedServer(self.node(f"{name}_server"), type_name, name, **habits)

    def mission(
        self,
        text: str,
        *,
        has_controls: bool = False,
        editable: bool = False,
        allow_duplicates: bool = False,
        **where: Any,
    ) -> MissionRunner:
        """The executive of a mission, on a node of its own."""
        mission = load(text)
        options = RunnerOptions(
            say=self.logged.append,
            goal_seed=str(mission.seed),
            has_controls=has_controls,
            has_presence=False,
            read_revision=read_revision if editable else None,
            allow_duplicates=allow_duplicates,
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

    def turning(self, text: str, **options: Any) -> tuple[ScriptedServer, MissionRunner]:
        """A server of turns and a mission, once the mission's first goal is there."""
        habits = {name: options.pop(name) for name in ("accepts", "cancels") if name in options}
        turn = self.server(**habits)
        runner = self.mission(text, **options)
        self.until(lambda: turn.goals)
        return turn, runner

    def serve(self, missions: ServedMissions | None = None, **options: Any) -> MissionServer:
        """The executive as a server, of missions sent as text unless another one is given."""
        self.served = MissionServer(
            self.clock.add_node,
            self.drop,
            node=NodeOptions(context=self.context, lean=True),
            options=MissionServerOptions(
                missions=missions or ServedMissions(allow_text=True),
                say=self.logged.append,
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

    def spin_until(self, done: Callable[[], Any]) -> None:
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
