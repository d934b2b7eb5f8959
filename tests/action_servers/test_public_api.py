"""An action of a user's own, written from public names and served beside ours."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator, Mapping
from typing import Any

import pytest
from bt_mission_interfaces.action import Move
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient

import action_servers
from action_servers import (
    SUCCEEDED,
    ZERO,
    Action,
    Drive,
    Finished,
    NumberLimit,
    Observation,
    Refusal,
    RobotModel,
    ServerOptions,
    ServersNode,
    Twist2D,
    load_robot,
)
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.world.loader import load_world
from tests.support.rig import Rig

START_NS = 1_000_000_000
ROBOT = load_robot("waffle")


class Circle:
    """Drives a circle of `radius` metres to the left, at 0.2 m/s, for so many seconds."""

    needs_base = True

    def __init__(self, robot: RobotModel, seconds: float, radius: float) -> None:
        self._twist = Twist2D(0.2, 0.2 / radius)
        self._seconds = seconds
        self._drive = Drive(robot)
        self._began_s: float | None = None

    def step(self, now: Observation) -> Twist2D | Finished:
        """Drive on, or end standing."""
        fault = self._drive.fault(now)
        if fault is not None:
            return fault
        self._began_s = now.time_s if self._began_s is None else self._began_s
        if now.time_s - self._began_s < self._seconds - 1e-6:
            return self._twist
        return self._drive.rest(now) or SUCCEEDED

    def feedback(self) -> Mapping[str, Any] | None:
        """Tell how far it has come."""
        return {"feedback": f"{self._drive.distance:.1f} m"}

    def result(self) -> Mapping[str, Any]:
        """Tell how far it has turned."""
        return {"status": f"turned by {math.degrees(self._drive.yaw):.0f} deg"}


def plan_circle(goal: Move.Goal, _now: Observation, robot: RobotModel) -> Circle | Refusal:
    """Return the maneuver; a velocity of its own is not for a circle."""
    if goal.linear_velocity:
        return Refusal("linear_velocity must be 0")
    return Circle(robot, goal.secs, radius=0.5)


class Count:
    """Ends at once with the first numbers; its type has no error_code."""

    needs_base = False

    def __init__(self, count: int) -> None:
        self._numbers = list(range(count))

    def step(self, now: Observation) -> Twist2D | Finished:
        """End; where the map is asked for, it is there."""
        assert now.grid is not None
        return SUCCEEDED if self._numbers else ZERO

    def feedback(self) -> Mapping[str, Any] | None:
        """Nothing."""
        return None

    def result(self) -> Mapping[str, Any]:
        """All of them."""
        return {"sequence": self._numbers}


EXTRA = [
    Action(
        name="circle",
        type="bt_mission_interfaces/action/Move",
        needs=("base", "scan", "odometry"),
        plan=plan_circle,
        limits=lambda _robot, _tuning: (
            NumberLimit(field="secs", low=1, high=60, unit="s", source="a minute"),
        ),
    ),
    Action(
        name="count",
        type="example_interfaces/action/Fibonacci",
        needs=("map",),
        plan=lambda goal, _now: Count(goal.order),
    ),
]


class Bench(Rig):
    """A simulated Waffle, the servers with two more actions, and a client, in virtual time."""

    def __init__(self, folder: Any) -> None:
        super().__init__(start_ns=START_NS)
        lean: Any = {"lean": True, "context": self.context}
        simulated = SimOptions(seed=1, start_ns=START_NS, **lean)
        self.sim = self.add(SimNode(load_world("empty_arena"), [RobotSpawn(ROBOT)], simulated))
        self.clock.world = self.sim
        options = ServerOptions(image_folder=folder, extra_actions=EXTRA, **lean)
        self.servers = self.add(ServersNode(ROBOT, options))
        self.client = self.node("client")
        self.run_for(1.0)

    def send(self, action_type: Any, name: str, goal: Any) -> Any:
        """Send a goal; gives the client's handle."""
        client = ActionClient(self.client, action_type, name)
        answer = client.send_goal_async(goal)
        self.run_for(0.2)
        return answer.result()


@pytest.fixture
def bench(tmp_path) -> Iterator[Bench]:
    """The nodes, taken down at the end."""
    made = Bench(tmp_path)
    yield made
    made.close()


def test_a_maneuver_of_ones_own_drives_the_robot(bench):
    """Half a circle of 0.5 m in 8 s at 0.2 m/s; ours are offered beside it."""
    assert {"/circle", "/count", "/turn", "/navigate_to_pose"} <= set(bench.servers.actions)
    handle = bench.send(Move, "circle", Move.Goal(secs=8))
    assert handle.accepted
    result = handle.get_result_async()
    bench.run_for(9.0)
    ended = result.result().result
    assert (ended.error_code, ended.error_msg) == (0, "")
    turned = float(ended.status.removeprefix("turned by ").removesuffix(" deg"))
    assert turned == pytest.approx(math.degrees(8.0 * 0.2 / 0.5), abs=5.0)
    assert bench.sim.robots[0].velocity == pytest.approx((0.0, 0.0), abs=0.01)


def test_its_refusal_is_a_rejection(bench):
    """With the reason for whoever asks the servers."""
    assert not bench.send(Move, "circle", Move.Goal(secs=0)).accepted
    assert bench.servers.why_rejected("/circle") == "secs must be from 1 to 60 s, got 0"
    assert not bench.send(Move, "circle", Move.Goal(secs=8, linear_velocity=0.1)).accepted
    assert bench.servers.why_rejected("/circle") == "linear_velocity must be 0"


def test_a_type_without_error_code_serves_as_well(bench):
    """Its result has the maneuver's fields alone."""
    handle = bench.send(Fibonacci, "count", Fibonacci.Goal(order=3))
    result = handle.get_result_async()
    bench.run_for(0.2)
    assert list(result.result().result.sequence) == [0, 1, 2]


def test_every_public_name_is_there():
    """And no other is."""
    for name in action_servers.__all__:
        assert getattr(action_servers, name) is not None
    assert set(action_servers.__all__) <= set(dir(action_servers))
    with pytest.raises(AttributeError, match="has no attribute 'Circle'"):
        _ = action_servers.Circle


def test_the_import_loads_no_ros():
    """Nor NumPy: names are imported when they are asked for."""
    program = (
        "import sys, action_servers; print([n for n in ('rclpy', 'numpy') if n in sys.modules])"
    )
    output = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    ).stdout
    assert output == "[]\n"
