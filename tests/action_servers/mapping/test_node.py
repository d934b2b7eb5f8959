"""The mapper over real rclpy, on the virtual clock, beside the simulated robot."""

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bt_mission_interfaces.msg import Coverage
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import OccupancyGrid
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_srvs.srv import Trigger

from action_servers.mapping.node import MOST_SAVES, MapperNode, MapperOptions
from bt_mission.core.robot.model import load_robot
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.sensors.lidar import LidarSensor
from sim.world.loader import load_world
from sim.world.occupancy import rasterise
from sim.world.world import World
from tests.support.rig import Rig

START_NS = 1_000_000_000
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Bench(Rig):
    """A Waffle in a world, its mapper, and somebody who listens."""

    def __init__(self, world: World, folder: Path) -> None:
        super().__init__(start_ns=START_NS)
        robot = load_robot("waffle")
        lean: Any = {"lean": True, "context": self.context}
        options = SimOptions(seed=3, start_ns=START_NS, camera=False, with_map=False, **lean)
        self.sim = self.clock.world = self.add(SimNode(world, [RobotSpawn(robot)], options))
        map_prefix = str(folder / "map")
        self.mapper = self.add(MapperNode(robot, MapperOptions(map_prefix=map_prefix, **lean)))
        self.user = self.node("user")
        self.maps: list[tuple[float, OccupancyGrid]] = []
        self.coverage: list[Coverage] = []
        self.user.create_subscription(OccupancyGrid, "map", self._on_map, LATCHED)
        self.user.create_subscription(Coverage, "coverage", self.coverage.append, LATCHED)
        self.twist = self.user.create_publisher(TwistStamped, "cmd_vel", 10)
        self.saver = self.user.create_client(Trigger, "save_map")

    def _on_map(self, message: OccupancyGrid) -> None:
        self.maps.append((self.now_s, message))

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


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    """A bench among nine columns."""
    bench = Bench(load_world("turtlebot3_world"), tmp_path)
    yield bench
    bench.close()


def test_the_first_map_comes_after_two_scans_and_the_next_once_a_second(bench: Bench) -> None:
    """Nothing is known to be free before."""
    bench.run_for(3.5)
    times = [time for time, _ in bench.maps]
    assert times[0] == pytest.approx(0.4)
    assert all(b - a >= 1.0 - 1e-6 for a, b in pairwise(times))


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
    times = [time for time, _ in bench.maps if time > set_at_s]
    assert [b - a for a, b in pairwise(times)] == pytest.approx([2.0] * (len(times) - 1))
    assert len(times) == 3


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
