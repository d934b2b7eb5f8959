"""The executive on a clock that somebody else keeps, who may set it, stop it, or start it anew."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import rclpy
from bt_mission_interfaces.action import Turn
from rclpy.action import ActionServer
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.time import Time
from rosgraph_msgs.msg import Clock

from bt_mission.base.errors import BtMissionError
from bt_mission.ros import graph
from bt_mission.sessions.attached import AttachedOptions, AttachedSession
from bt_mission.sessions.load import load
from bt_mission.testing.live_graph import LOCAL, own_domain

MS = 1_000_000
WAIT = "mission: waits\ntree: {wait: 3, name: pause}\n"
PATIENCE = 500


class Keeper:
    """Publishes ``/clock`` as the test says, and has the executive follow."""

    def __init__(self, context: Context) -> None:
        self.node = Node("keeper", context=context, enable_rosout=False)
        self.publisher = self.node.create_publisher(Clock, "/clock", 10)

    def show(self, session: AttachedSession, time_ms: int) -> None:
        """Publish a time, until the executive has it; then let it do what is due."""
        message = Clock(clock=Time(nanoseconds=time_ms * MS).to_msg())
        for _ in range(PATIENCE):
            self.publisher.publish(message)
            session.step()
            if session.node.get_clock().now().nanoseconds == time_ms * MS:
                session._graph.drain()
                return
        raise AssertionError("the executive does not follow the clock")

    def run(self, session: AttachedSession, first_ms: int, last_ms: int) -> None:
        """Show one time after the other, 50 ms apart."""
        for time_ms in range(first_ms, last_ms + 1, 50):
            self.show(session, time_ms)


class Servers:
    """Servers of ``/turn``, which are never served."""

    def __init__(self, node: Node, count: int = 1, **qos: QoSProfile) -> None:
        self._servers = [
            ActionServer(node, Turn, "turn", lambda _: None, **qos) for _ in range(count)
        ]

    def close(self) -> None:
        """Leave the graph."""
        for server in self._servers:
            server.destroy()


@pytest.fixture
def keeper(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Keeper]:
    """In a domain of its own."""
    for name, value in LOCAL.items():
        monkeypatch.setenv(name, value)
    with own_domain() as domain_id:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(domain_id))
        context = Context()
        rclpy.init(context=context)
        keeper = Keeper(context)
        yield keeper
        keeper.node.destroy_node()
        context.shutdown()


def test_a_mission_outlives_a_simulator_that_starts_anew(keeper: Keeper) -> None:
    """Its clock starts at zero, stands still, is set back to zero, and goes on."""
    with AttachedSession(load(WAIT)) as session:
        keeper.run(session, 0, 2000)
        for _ in range(5):
            keeper.show(session, 2000)
        assert not session.is_done
        keeper.run(session, 0, 1000)
        assert not session.is_done
        keeper.run(session, 1050, 1200)
        assert session.executive.status == "success"
        events = [json.loads(line) for line in session.trace.newest]
        assert [event["jump"] for event in events if event.get("event") == "clock"] == [-1.95]


def test_a_mission_that_missed_the_clock_says_so(
    keeper: Keeper, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """It runs on the clock of this machine, and fails when another one is published after all."""
    monkeypatch.setattr(graph, "CLOCK_WAIT_S", 0.0)
    monkeypatch.setattr(graph, "SEARCH_S", 0.0)
    keeper.node.destroy_publisher(keeper.publisher)
    with AttachedSession(load(WAIT)) as session:
        assert "nothing has published /clock within" in capfd.readouterr().err
        session.step()
        publisher = keeper.node.create_publisher(Clock, "/clock", 10)
        for _ in range(PATIENCE):
            session.step()
            if session.is_done:
                break
        assert session.executive.status == "failure"
        assert "/clock is published only now" in session.executive.reason
        keeper.node.destroy_publisher(publisher)


def test_servers_that_cannot_be_used_are_refused_at_the_start(keeper: Keeper) -> None:
    """One whose statuses no client receives; a second one may be allowed, and is named then."""
    best_effort = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    turns = load("mission: m\ntree: {turn: {angle: 9}, timeout: 3}\n")
    with closing(Servers(keeper.node, status_pub_qos_profile=best_effort)):
        with pytest.raises(BtMissionError, match="/turn: its server /keeper publishes st") as error:
            AttachedSession(turns)
        assert error.value.code == "BT-917"
    both = "/turn has 2 servers (/keeper, /keeper): each of them runs every goal"
    with closing(Servers(keeper.node, count=2)):
        with pytest.raises(BtMissionError, match=re.escape(both)) as error:
            AttachedSession(turns)
        assert error.value.code == "BT-914"
        with AttachedSession(turns, AttachedOptions(allow_duplicates=True)) as session:
            assert session.report().warnings[0].startswith(both)


def test_a_mission_takes_skipped_time_as_passed(keeper: Keeper) -> None:
    """As everybody in the graph does."""
    with AttachedSession(load(WAIT)) as session:
        keeper.run(session, 500, 1000)
        keeper.show(session, 101_000)
        keeper.show(session, 101_050)
        assert session.executive.status == "success"
