"""Two robots, or a robot and a simulation, are not driven as one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from action_servers.core.maneuver import ZERO
from bt_mission.core.robot.model import load_robot
from tests.support.bench import Bench
from tests.support.fake_robot import FakeRobot
from tests.support.served import goal


@pytest.fixture
def open_bench(tmp_path: Path) -> Any:
    """Servers as in a process of their own: another robot may be in the graph."""
    made = Bench(FakeRobot(load_robot("waffle")), tmp_path / "images", lean=False)
    made.steps(2)
    yield made
    made.close()


@pytest.fixture
def clocked_bench(tmp_path: Path) -> Any:
    """The same on simulated time, as the process of the servers asks for it."""
    made = Bench(
        FakeRobot(load_robot("waffle")),
        tmp_path / "images",
        lean=False,
        ros_args=["-p", "use_sim_time:=true"],
    )
    made.steps(2)
    yield made
    made.close()


def test_a_goal_is_rejected_while_two_publish_the_odometry(open_bench: Any) -> None:
    """The reason names the topic, both nodes and what to do; with one left, goals are accepted."""
    other = open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    refused = open_bench.send("turn")
    open_bench.steps(2)
    assert refused.accepted is False
    why = open_bench.servers.why_rejected("/turn")
    assert why.startswith("/odom has 2 publishers (/client_2, /robot): two robots, or a robot and")
    assert "--allow-duplicates" in why
    open_bench.clients[1].destroy_publisher(other)
    accepted = open_bench.send("turn")
    open_bench.steps(2)
    assert accepted.accepted is True


def test_the_base_stops_when_a_second_robot_comes(open_bench: Any) -> None:
    """Within half a second; the goal says why."""
    sent = open_bench.send("turn")
    open_bench.until(lambda: open_bench.moved)
    open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    open_bench.steps(12)
    assert (sent.status, open_bench.commands[-1]) == ("aborted", ZERO)
    assert "/odom has 2 publishers" in sent.result.error_msg


def test_a_goal_is_rejected_while_two_publish_the_clock(clocked_bench: Any) -> None:
    """Also where the ROS arguments alone say that time is simulated. With one clock they start."""
    first, second = (
        client.create_publisher(Clock, "/clock", 1) for client in clocked_bench.clients
    )
    refused = clocked_bench.send("turn")
    clocked_bench.steps(2)
    assert refused.accepted is False
    why = clocked_bench.servers.why_rejected("/turn")
    assert why.startswith("/clock has 2 publishers (/client_1, /client_2): ")
    clocked_bench.clients[1].destroy_publisher(second)
    accepted = clocked_bench.send("turn")
    clocked_bench.steps(2)
    assert accepted.accepted is True
    assert first.get_subscription_count() > 0


def test_the_clock_of_others_does_not_matter_on_the_wall_clock(open_bench: Any) -> None:
    """Two simulations beside a robot leave it alone."""
    for client in open_bench.clients:
        client.create_publisher(Clock, "/clock", 1)
    sent = open_bench.send("turn")
    open_bench.steps(2)
    assert sent.accepted is True


def test_what_does_not_drive_goes_on(open_bench: Any) -> None:
    """To record a distance moves nothing."""
    open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    sent = open_bench.send("record_distance", goal("record_distance"))
    open_bench.steps(2)
    assert sent.accepted is True
