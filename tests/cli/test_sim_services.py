"""Real processes around a simulator that somebody's tool pauses, steps, resets and ends."""

import os
from collections.abc import Iterator
from typing import Any

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from simulation_interfaces import srv
from simulation_interfaces.msg import SimulationState

pytestmark = pytest.mark.process

S = 1_000_000_000
OK = 1
STOPPED, PLAYING, PAUSED, QUITTING = range(4)

TURNS = """\
mission: turns
tree:
  retry: {attempts: 5}
  do:
    turn: {angle: 300, angular_velocity: 0.5}
    timeout: 60
"""

THERE = """\
mission: there
tree:
  sequence:
    - wait: 1
    - navigate_to_pose:
        pose:
          header: {frame_id: map}
          pose: {position: {x: 1.0, y: 0.5}, orientation: {w: 1.0}}
      timeout: 60
"""


class Tool:
    """Somebody's program, which knows the standard interfaces of simulators and nothing of us."""

    def __init__(self, domain_id: int) -> None:
        self.context = Context()
        rclpy.init(context=self.context, domain_id=domain_id)
        self.node = Node("tool", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        kinds = ("SetSimulationState", "ResetSimulation", "StepSimulation", "SpawnEntity")
        names = ("set_simulation_state", "reset_simulation", "step_simulation", "spawn_entity")
        self._clients = {
            kind: self.node.create_client(getattr(srv, kind), f"/bt_mission_sim/{name}")
            for kind, name in zip(kinds, names, strict=True)
        }
        self.clocks: list[int] = []
        self.node.create_subscription(Clock, "/clock", self._on_clock, 10)

    def wait(self) -> None:
        """Wait until the simulator is there."""
        for client in self._clients.values():
            assert client.wait_for_service(60.0)

    def ask(self, kind: str, **fields: Any) -> tuple[int, str]:
        """Return how a request went."""
        future = self._clients[kind].call_async(getattr(srv, kind).Request(**fields))
        self.executor.spin_until_future_complete(future, timeout_sec=60.0)
        result = future.result().result
        return result.result, result.error_message

    def set_state(self, state: int) -> tuple[int, str]:
        """Ask for a state."""
        return self.ask("SetSimulationState", state=SimulationState(state=state))

    def see_clocks(self, count: int) -> list[int]:
        """Return this number of new times on /clock, ns."""
        seen = len(self.clocks)
        while len(self.clocks) < seen + count:
            self.executor.spin_once(timeout_sec=10.0)
        return self.clocks[seen:]

    def close(self) -> None:
        """Leave."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.context.shutdown()

    def _on_clock(self, message: Clock) -> None:
        self.clocks.append(message.clock.sec * S + message.clock.nanosec)


@pytest.fixture
def tool(live_graph, monkeypatch) -> Iterator[Tool]:
    """A tool in the graph of the processes."""
    monkeypatch.setitem(os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    tool = Tool(live_graph.domain_id)
    yield tool
    tool.close()


@pytest.mark.thorough
def test_a_reset_in_the_middle_of_a_mission_and_between_two(live_graph, tool):
    """The running goal ends with the reason, and the mission and its viewers continue."""
    simulator, servers = live_graph.robot("empty_arena", "waffle", "--no-camera", "--speed", "2")
    watch = live_graph.start("watch", "--plain")
    tool.wait()
    first = live_graph.run(TURNS)
    servers.until("goal accepted")
    tool.see_clocks(200)  # two of the ten seconds that it turns
    assert tool.ask("ResetSimulation") == (OK, "")
    assert first.wait(within=120) == 0
    assert "the ROS clock was set back by" in first.output
    assert "aborted: /turn: the ROS clock was set back by" in first.output
    assert "2 goals sent, 0 orphaned" in first.output
    watch.until("mission success")

    assert tool.ask("ResetSimulation") == (OK, "")
    assert min(tool.see_clocks(20)) < 2 * S  # ten may have waited
    second = live_graph.run(THERE)
    assert second.wait(within=120) == 0
    assert "1 goal sent, 0 orphaned" in second.output
    watch.until("mission success")

    assert tool.set_state(QUITTING) == (OK, "")
    assert simulator.wait(within=30) == 0
    for process, code in ((servers, 0), (watch, 130)):
        process.interrupt()
        assert process.wait(within=60) == code
    assert not [started.name for started in live_graph.processes if "Traceback" in started.output]


@pytest.mark.thorough
def test_a_mission_waits_while_the_simulation_is_paused(live_graph, tool):
    """For longer than an executive waits for a clock that is gone; nothing fails."""
    simulator, servers = live_graph.robot("empty_arena", "waffle", "--no-camera")
    tool.wait()
    mission = live_graph.run(TURNS.replace("timeout: 60", "timeout: 15"))
    servers.until("goal accepted")
    assert tool.set_state(PAUSED) == (OK, "")
    standing = tool.see_clocks(60)[10:]  # ten a second
    assert len(set(standing)) == 1
    assert mission.code is None
    assert tool.ask("StepSimulation", steps=20) == (OK, "")
    assert set(tool.see_clocks(20)[10:]) == {standing[0] + S // 10}
    assert tool.set_state(PLAYING) == (OK, "")
    assert mission.wait(within=60) == 0
    assert "1 goal sent, 0 orphaned" in mission.output
    simulator.interrupt()
    assert simulator.wait(within=30) == 0


@pytest.mark.thorough
def test_what_is_spawned_is_seen_by_others(live_graph, tool):
    """A pillar half a metre ahead is in the scan that another process gets."""
    simulator = live_graph.start("sim", "--world", "empty_arena", "--no-camera")
    tool.wait()
    request = srv.SpawnEntity.Request(name="pillar", uri="cylinder?radius=0.1")
    request.initial_pose.header.frame_id = "waffle"
    request.initial_pose.pose.position.x = 0.5
    fields = {name: getattr(request, name) for name in ("name", "uri", "initial_pose")}
    assert tool.ask("SpawnEntity", **fields) == (OK, "")
    scans: list[float] = []
    tool.node.create_subscription(
        LaserScan, "scan", lambda scan: scans.append(scan.ranges[0]), qos_profile_sensor_data
    )
    while len(scans) < 2:
        tool.executor.spin_once(timeout_sec=10.0)
    assert 0.3 < scans[-1] < 0.5
    assert tool.ask("SpawnEntity", **fields)[0] == srv.SpawnEntity.Response.NAME_NOT_UNIQUE
    assert tool.set_state(QUITTING) == (OK, "")
    assert simulator.wait(within=30) == 0
    assert "'pillar' spawned at" in simulator.output
