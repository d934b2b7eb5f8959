"""The mapper over real rclpy, on the virtual clock beside the simulated robot, and as a process."""

import math
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from bt_mission_interfaces.msg import Coverage
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import OccupancyGrid
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from action_servers.mapping.node import MOST_SAVES, MapperNode, MapperOptions
from bt_mission.robots.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.sensors.lidar import LidarSensor
from sim.world.loader import load_world
from sim.world.occupancy import rasterise
from tests.support.processes import PATIENCE_S
from tests.support.rig import Rig
from tests.support.robot_node import LATCHED

START_NS = 1_000_000_000


class Bench(Rig):
    """A Waffle among nine columns, its mapper, and somebody who listens."""

    def __init__(self, folder: Path) -> None:
        super().__init__(start_ns=START_NS)
        robot = load_robot("waffle")
        lean: Any = {"lean": True, "context": self.context}
        options = SimOptions(seed=3, start_ns=START_NS, camera=False, with_map=False, **lean)
        world = load_world("turtlebot3_world")
        self.sim = self.clock.world = self.add(SimNode(world, [RobotSpawn(robot)], options))
        map_prefix = str(folder / "map")
        self.mapper = self.add(MapperNode(robot, MapperOptions(map_prefix=map_prefix, **lean)))
        self.user = self.node("user")
        self.maps: list[tuple[float, OccupancyGrid]] = []
        self.coverage: list[Coverage] = []
        self.user.create_subscription(
            OccupancyGrid, "map", lambda grid: self.maps.append((self.now_s, grid)), LATCHED
        )
        self.user.create_subscription(Coverage, "coverage", self.coverage.append, LATCHED)
        self.twist = self.user.create_publisher(TwistStamped, "cmd_vel", 10)
        self.saver = self.user.create_client(Trigger, "save_map")

    def run_for(self, seconds: float, linear: float = 0.0, angular: float = 0.0) -> None:
        """Let time pass, with a command in each step."""
        end = self.now_s + seconds
        while self.now_s < end - 1e-9:
            if linear or angular:
                message = TwistStamped()
                message.twist.linear.x, message.twist.angular.z = linear, angular
                self.twist.publish(message)
            self.step()

    def save(self) -> Trigger.Response:
        answer = self.saver.call_async(Trigger.Request())
        self.clock.run_until_quiet()
        return answer.result()

    def steps_between_maps(self, since_s: float = 0.0) -> list[float]:
        """The times from map to map, s."""
        times = [time for time, _ in self.maps if time > since_s]
        return [b - a for a, b in pairwise(times)]


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """A bench."""
    bench = Bench(tmp_path)
    yield bench
    bench.close()


def test_the_first_map_comes_after_two_scans_and_the_next_once_a_second(bench: Bench) -> None:
    """Nothing is known to be free before."""
    bench.run_for(3.5)
    assert bench.maps[0][0] == pytest.approx(0.4)
    assert min(bench.steps_between_maps()) >= 1.0 - 1e-6


def test_tuning_that_is_set_holds_at_once_and_the_period_is_fixed(bench: Bench) -> None:
    """From one map a second to one in two; the reason of a refusal says what to do."""
    bench.run_for(2.0, angular=1.0)
    set_at_s = bench.now_s
    period, each = bench.mapper.set_parameters(
        [Parameter("update_period", value=0.1), Parameter("updates_per_map", value=10)]
    )
    assert not period.successful
    assert period.reason == (
        "update_period is read only when the node starts; restart it with "
        "--ros-args -p update_period:=0.1"
    )
    assert each.successful
    bench.run_for(6.0, angular=1.0)
    assert bench.steps_between_maps(set_at_s) == pytest.approx([2.0, 2.0])


def test_what_it_maps_agrees_with_the_world(bench: Bench) -> None:
    """While the robot turns and drives, free and occupied cells are so within a cell."""
    bench.run_for(3.0, angular=1.0)
    bench.run_for(3.0, linear=0.2, angular=0.3)
    bench.run_for(1.0)
    _, message = bench.maps[-1]
    cells = np.array(message.data, dtype=np.int8).reshape(message.info.height, message.info.width)
    truth = rasterise(load_world("turtlebot3_world"))
    size = message.info.resolution
    wrong = {0: 0, 100: 0}
    for value in wrong:
        rows, columns = np.nonzero(cells == value)
        x = message.info.origin.position.x + (columns + 0.5) * size
        y = message.info.origin.position.y + (rows + 0.5) * size
        column = np.floor((x - truth.origin[0]) / truth.resolution).astype(int)
        row = np.floor((y - truth.origin[1]) / truth.resolution).astype(int)
        inside = (row >= 1) & (column >= 1)
        inside &= (row < truth.cells.shape[0] - 1) & (column < truth.cells.shape[1] - 1)
        near = np.stack(
            [
                truth.cells[row[inside] + down, column[inside] + right]
                for down in (-1, 0, 1)
                for right in (-1, 0, 1)
            ]
        )
        agrees = (near == value).any(axis=0)
        wrong[value] = int((~agrees).sum())
        assert inside.sum() > 100
    assert wrong == {0: 0, 100: 0}
    assert message.header.frame_id == "map"


def test_coverage_tells_area_and_zones(bench: Bench) -> None:
    """The area grows, and the robot's own zones are among the zones."""
    bench.run_for(1.0)
    first = bench.coverage[-1]
    bench.run_for(6.0, linear=0.2, angular=0.2)
    last = bench.coverage[-1]
    assert 0.0 < first.area < last.area
    assert 0.0 < last.fraction <= 1.0
    assert (first.zones_visited, last.zones_visited) == (0, 1)
    assert last.zones > last.zones_visited


def test_save_map_writes_and_says_where(bench: Bench, tmp_path: Path) -> None:
    """Both files; before there is a map the answer is the reason."""
    before = bench.save()
    assert (before.success, before.message) == (
        False,
        "there is no map yet: no scan has been placed on it",
    )
    bench.run_for(1.0)
    after = bench.save()
    assert after.success
    assert after.message == f"map saved: {tmp_path / 'map.yaml'}"
    assert (tmp_path / "map.pgm").stat().st_size > 1000


@pytest.mark.parametrize("place", ["elsewhere/map", "link/map", "../map"])
def test_a_client_cannot_have_a_map_written_anywhere(
    bench: Bench, tmp_path: Path, place: str
) -> None:
    """The parameter may be set to another name in the folder; no link leads elsewhere."""
    other = tmp_path.parent / f"{tmp_path.name}_other"
    other.mkdir()
    (tmp_path / "link").symlink_to(other)
    target = other / "map" if place == "elsewhere/map" else tmp_path / place
    bench.run_for(1.0)
    bench.mapper.set_parameters([Parameter("map_prefix", value=str(target))])
    answer = bench.save()
    assert not answer.success
    assert f"is outside {tmp_path}" in answer.message
    assert not list(other.iterdir())
    assert not target.with_suffix(".pgm").exists()
    bench.mapper.set_parameters([Parameter("map_prefix", value=str(tmp_path / "second"))])
    assert bench.save().success


def test_a_map_without_news_is_not_sent_again(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A scan that does not change the map brings no message."""
    bench.run_for(2.0)
    count = len(bench.maps)
    nothing = np.full(bench.sim.robots[0].robot.lidar.rays, math.nan, dtype=np.float32)
    monkeypatch.setattr(bench.sim.robots[0].sensor(LidarSensor), "scan", lambda _: nothing)
    bench.run_for(3.0)
    assert len(bench.maps) <= count + 1


def test_of_many_maps_to_save_at_once_some_are_saved(bench: Bench) -> None:
    """The others are refused with the reason; after a second there are more."""
    bench.run_for(2.0)
    answers = [bench.saver.call_async(Trigger.Request()) for _ in range(100)]
    bench.clock.run_until_quiet()
    reports = [answer.result() for answer in answers]
    assert [report.success for report in reports] == [True] * MOST_SAVES + [False] * (
        100 - MOST_SAVES
    )
    assert reports[-1].message == "5 maps were saved within 1 s, which is the limit"
    bench.run_for(1.0)
    assert bench.save().success


@pytest.fixture
def user(monkeypatch: pytest.MonkeyPatch) -> Iterator[tuple[Node, SingleThreadedExecutor]]:
    """Somebody whom other processes of this machine can see."""
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = Context()
    rclpy.init(context=context)
    node = Node("user", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    yield node, executor
    executor.shutdown()
    node.destroy_node()
    context.shutdown()


@pytest.mark.process
def test_the_command_serves_until_it_is_interrupted(
    user: tuple[Node, SingleThreadedExecutor], tmp_path: Path
) -> None:
    """It answers that there is no map yet, and leaves with exit code 0."""
    node, executor = user
    command = [sys.executable, "-m", "bt_mission", "mapper", "--wall-clock", "--save-as"]
    with (
        subprocess.Popen([*command, str(tmp_path / "map")]) as mapper,
        ExitStack() as last,
    ):
        last.callback(mapper.kill)  # a failed assertion must not wait for it
        saver = node.create_client(Trigger, "save_map")
        assert saver.wait_for_service(timeout_sec=60.0)
        answer = saver.call_async(Trigger.Request())
        executor.spin_until_future_complete(answer, timeout_sec=30.0)
        result = answer.result()
        assert result is not None
        assert (result.success, result.message[:19]) == (False, "there is no map yet")
        mapper.send_signal(signal.SIGINT)
        assert mapper.wait(timeout=PATIENCE_S) == 0
