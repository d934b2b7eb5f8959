"""A robot, its servers and a client on one virtual clock, to be put anywhere and told to drive.

What is measured is the truth of the simulation, never what the servers say of themselves.
"""

from __future__ import annotations

import math
import os
import random
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import mujoco
import numpy as np
import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.context import Context
from rclpy.node import Node
from std_srvs.srv import Trigger
from unique_identifier_msgs.msg import UUID

from action_servers.server.node import ServerOptions, ServersNode
from bt_mission.robots.model import load_robot
from bt_mission.ros.virtual_time import VirtualTimeExecutor
from sim.physics.names import OBSTACLE_PREFIX, SOLID, STEP_NS
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.world.loader import load_world
from sim.world.world import World

START_NS = 1_000_000_000
PERIOD_NS = 50_000_000
STATUS = {
    GoalStatus.STATUS_SUCCEEDED: "succeeded",
    GoalStatus.STATUS_CANCELED: "canceled",
    GoalStatus.STATUS_ABORTED: "aborted",
}

STANDS_LINEAR, STANDS_ANGULAR = 0.01, 0.02
"""m/s and rad/s of true velocity below which the base stands."""

INTRUDER = "intruder"
INTRUDER_SIZE = (0.1, 0.6, 0.4)
"""Metres: something as thick as a wall and wider than a Waffle."""

RAYS = 61
"""Rays across the hull's width that look for what is ahead: one every 5 mm on a Waffle."""


@dataclass
class Sent:
    """One goal, as its client sees it."""

    accepted: bool | None = None
    status: str = ""
    result: Any = None


class Rig:
    """One world with one robot; `seed` decides sensor noise and goal ids.

    :param intruder: have a box ready that can be put in the way at any time.
    """

    def __init__(
        self,
        world: str,
        *,
        robot: str = "waffle",
        seed: int = 0,
        intruder: bool = False,
    ) -> None:
        self.robot = load_robot(robot)
        self.world = load_world(world)
        self._ids = random.Random(seed)
        self._clients: dict[str, ActionClient] = {}
        # No other process is to take part; within a process DDS works all the same.
        os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
        self.context = Context()
        rclpy.init(context=self.context)
        self.sim = SimNode(
            _with_intruder(self.world) if intruder else self.world,
            [RobotSpawn(self.robot)],
            SimOptions(seed=seed, start_ns=START_NS, lean=True, context=self.context),
        )
        self.servers = ServersNode(
            self.robot,
            ServerOptions(image_folder=Path("images"), lean=True, context=self.context),
        )
        self.client = Node(
            "client", context=self.context, enable_rosout=False, start_parameter_services=False
        )
        self.clock = VirtualTimeExecutor(start_ns=START_NS, world=self.sim, context=self.context)
        for node in (self.sim, self.servers, self.client):
            self.clock.add_node(node)
        self._groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        self._groups[SOLID] = 1
        # A box that is moved leaves the tree of boxes that the midphase made of it.
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_MIDPHASE
        self._intruder = self.model.geom(f"{OBSTACLE_PREFIX}{INTRUDER}").id if intruder else None
        self._away = None if self._intruder is None else self.model.geom_pos[self._intruder].copy()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        for node in (self.client, self.servers, self.sim):
            node.destroy_node()
        self.clock.shutdown()
        self.context.shutdown()

    # ---- the truth -----------------------------------------------------------------------

    @property
    def model(self) -> mujoco.MjModel:
        """The model of the world."""
        return self.sim.physics.model

    @property
    def data(self) -> mujoco.MjData:
        """The state of the world."""
        return self.sim.physics.data

    @property
    def now_s(self) -> float:
        """Virtual time, s."""
        return self.clock.now_ns / 1e9

    @property
    def collisions(self) -> int:
        """Collisions so far."""
        return self.sim.robots[0].collisions

    @property
    def stands(self) -> bool:
        """Whether the base stands, by its true velocity."""
        linear, angular = self.sim.robots[0].velocity
        return abs(linear) < STANDS_LINEAR and abs(angular) < STANDS_ANGULAR

    def gap_ahead(self) -> float:
        """Metres that the hull could go straight on until contact; inf where nothing is."""
        x, y, yaw = self.sim.robots[0].pose
        hull = self.robot.hull
        along = np.array([math.cos(yaw), math.sin(yaw), 0.0])
        across = np.array([-math.sin(yaw), math.cos(yaw), 0.0])
        hit = np.zeros(1, dtype=np.int32)
        nearest = math.inf
        for side in np.linspace(-hull.half_width, hull.half_width, RAYS):
            start = np.array([x, y, self.robot.lidar.z + self.robot.base_height]) + side * across
            far = mujoco.mj_ray(self.model, self.data, start, along, self._groups, 1, -1, hit, None)
            if far >= 0.0:
                nearest = min(nearest, far - hull.front)
        return nearest

    # ---- moving things -------------------------------------------------------------------

    def place(self, x: float, y: float, yaw: float) -> bool:
        """Put the robot somewhere at rest, m and rad; returns whether it touches nothing there."""
        self.dismiss_intruder()
        half = yaw / 2
        self.data.qpos[:2] = x, y
        self.data.qpos[3:7] = math.cos(half), 0.0, 0.0, math.sin(half)
        self.data.qvel[:] = 0.0
        mujoco.mj_forward(self.model, self.data)
        near = min((o.distance(x, y) for o in self.world.obstacles), default=math.inf)
        return near > self.robot.turning_radius

    def intrude(self, gap: float) -> None:
        """Let a box appear ahead, its face `gap` metres from the hull, square to the way."""
        x, y, yaw = self.sim.robots[0].pose
        depth, _, height = INTRUDER_SIZE
        away = self.robot.hull.front + gap + depth / 2
        at = [x + away * math.cos(yaw), y + away * math.sin(yaw), height / 2]
        self.model.geom_pos[self._intruder] = at
        self.model.geom_quat[self._intruder] = [math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
        mujoco.mj_kinematics(self.model, self.data)

    def dismiss_intruder(self) -> None:
        """Take the box away."""
        if self._intruder is not None:
            self.model.geom_pos[self._intruder] = self._away

    def silence(self, topic: str) -> None:
        """Let the robot never again say anything on a topic."""
        for publisher in self.sim.publishers:
            if publisher.topic_name == f"/{topic}":
                publisher.publish = lambda _: None

    # ---- goals ---------------------------------------------------------------------------

    def prepare(self, name: str, action_type: Any) -> None:
        """Make the client of an action, before time begins to matter."""
        self._clients[name] = ActionClient(self.client, action_type, name)

    def send(self, name: str, goal: Any) -> Sent:
        """Send a goal; its record fills while time passes."""
        sent = Sent()

        def ended(future: Any) -> None:
            response = future.result()
            sent.status, sent.result = STATUS[response.status], response.result

        def answered(future: Any) -> None:
            sent.accepted = future.result().accepted
            if sent.accepted:
                future.result().get_result_async().add_done_callback(ended)

        goal_id = UUID(uuid=list(self._ids.randbytes(16)))
        future = self._clients[name].send_goal_async(goal, goal_uuid=goal_id)
        future.add_done_callback(answered)
        return sent

    def look_closely(self) -> None:
        """Let time pass in steps of 5 ms from now on, those of the physics."""
        self.client.create_timer(STEP_NS / 1e9, lambda: None)

    def call_stop(self, service: str = "stop") -> Callable[[], bool]:
        """Call the stop service; returns what tells whether it has answered."""
        client = self.client.create_client(Trigger, service)
        future = client.call_async(Trigger.Request())
        return future.done

    def wait(self, seconds: float) -> None:
        """Let time pass."""
        end_ns = self.clock.now_ns + round(seconds * 1e9)
        while self.clock.next_due_ns() <= end_ns:
            self.clock.step()

    def until(self, done: Callable[[], bool], limit_s: float) -> bool:
        """Let time pass until something holds; returns whether it came to hold in time."""
        end_ns = self.clock.now_ns + round(limit_s * 1e9)
        while not done():
            if self.clock.now_ns >= end_ns:
                return False
            self.clock.step()
        return True


def _with_intruder(world: World) -> World:
    # Askew, so that MuJoCo does not take its direction for the world's for good.
    far = max(world.size)
    box = {"name": INTRUDER, "x": far, "y": far, "size": INTRUDER_SIZE, "yaw": 30.0}
    written = world.model_dump(by_alias=True, exclude_unset=True)
    return World.model_validate(written | {"boxes": [*written.get("boxes", []), box]})
