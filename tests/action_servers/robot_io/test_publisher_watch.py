"""Two robots, or a robot and a simulation, are not driven as one."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from action_servers.core.maneuver import ZERO
from bt_mission.robots.model import load_robot
from tests.support.bench import Bench
from tests.support.fake_robot import FakeRobot


@pytest.fixture
def make_bench(tmp_path: Path) -> Iterator[Any]:
    """Make servers as in a process of their own: another robot may be in the graph."""
    made = []

    def make(*ros_args: str) -> Bench:
        robot = FakeRobot(load_robot("waffle"))
        made.append(Bench(robot, tmp_path / "images", lean=False, ros_args=ros_args))
        made[-1].steps(2)
        return made[-1]

    yield make
    for bench in made:
        bench.close()


@pytest.fixture
def open_bench(make_bench: Any) -> Bench:
    """On the wall clock, as far as the servers know."""
    bench: Bench = make_bench()
    return bench


def accepts(bench: Any, name: str = "turn") -> bool:
    """Whether a goal is accepted."""
    sent = bench.send(name)
    bench.steps(2)
    assert sent.accepted is not None
    return bool(sent.accepted)


def test_a_goal_is_rejected_while_two_publish_the_odometry(open_bench: Any) -> None:
    """The reason names the topic, both nodes and what to do; with one left, goals are accepted."""
    other = open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    assert not accepts(open_bench)
    why = open_bench.servers.why_rejected("/turn")
    assert why.startswith("/odom has 2 publishers (/client_2, /robot): two robots, or a robot and")
    assert "--allow-duplicates" in why
    open_bench.clients[1].destroy_publisher(other)
    assert accepts(open_bench)


def test_the_base_stops_when_a_second_robot_comes(open_bench: Any) -> None:
    """Within half a second; the goal says why."""
    sent = open_bench.send("turn")
    open_bench.until(lambda: open_bench.moved)
    open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    open_bench.steps(12)
    assert (sent.status, open_bench.commands[-1]) == ("aborted", ZERO)
    assert "/odom has 2 publishers" in sent.result.error_msg


def test_a_goal_is_rejected_while_two_publish_the_clock(make_bench: Any) -> None:
    """Also where the ROS arguments alone say that time is simulated. With one clock they start."""
    clocked_bench = make_bench("-p", "use_sim_time:=true")
    first, second = (
        client.create_publisher(Clock, "/clock", 1) for client in clocked_bench.clients
    )
    assert not accepts(clocked_bench)
    why = clocked_bench.servers.why_rejected("/turn")
    assert why.startswith("/clock has 2 publishers (/client_1, /client_2): ")
    clocked_bench.clients[1].destroy_publisher(second)
    assert accepts(clocked_bench)
    assert first.get_subscription_count() > 0


def test_the_clock_of_others_does_not_matter_on_the_wall_clock(open_bench: Any) -> None:
    """Two simulations beside a robot leave it alone."""
    for client in open_bench.clients:
        client.create_publisher(Clock, "/clock", 1)
    assert accepts(open_bench)


def test_what_does_not_drive_goes_on(open_bench: Any) -> None:
    """To record a distance moves nothing."""
    open_bench.clients[1].create_publisher(Odometry, "odom", 10)
    assert accepts(open_bench, "record_distance")
