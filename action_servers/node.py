"""The action servers as a ROS node: one base, one pilot, five actions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rclpy
from bt_mission_interfaces.action import CameraSweep, ExploreForward, Turn
from nav2_msgs.action import FollowWaypoints, NavigateToPose
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from action_servers import camera_sweep, explore_forward, turn
from action_servers.adapter import Action, ActionAdapter
from action_servers.interrupts import Interrupts
from action_servers.maneuver import Observation, Refusal
from action_servers.messages import seconds
from action_servers.navigation.actions import plan_follow_waypoints, plan_navigate_to_pose
from action_servers.pilot import Pilot
from action_servers.real_base import Base
from action_servers.real_executive import watch_executives
from action_servers.real_file import read_parameters
from action_servers.real_listeners import Choice
from action_servers.real_parameters import declare_wiring, made_with, overrides
from action_servers.sensors import Sensors
from action_servers.storage import ImageFolder
from bt_mission.common.robot import RobotModel, load_robot

if TYPE_CHECKING:
    from rclpy.context import Context

NODE_NAME = "bt_mission_servers"
DEFAULT_TURN_VELOCITY = "default_turn_velocity"

LAST_CALLBACKS = 100
"""Callbacks that are served after the servers were told to stop: a result takes three."""

LAST_WORDS_S = 0.5
"""Seconds to wait until the robot has confirmed the last command; it stops by itself then."""


class ServersNode(Node):
    """Offers `explore_forward`, `turn`, `camera_sweep`, `navigate_to_pose`, `follow_waypoints`.

    It knows the robot only through its topics: `scan`, `odom`, `tf`, `map`, `camera/image_raw`
    and `cmd_vel`, relative to `namespace`.

    :param robot: limits, hull and sensors of the robot.
    :param image_folder: where each camera sweep makes a folder of its own.
    :param lean: no parameter services, log topic or type description, and only warnings in the
        log, as on the stage.
    :param context: the rclpy context; None is the default one.
    :param use_sim_time: follow `/clock`.
    :param command_type: the type of `cmd_vel`; "auto" is what the robot listens for, and goals
        that drive are refused while it would not hear.
    :param parameters: values of parameters by name, instead of their defaults.
    :raises rclpy.exceptions.ParameterException: for a parameter out of its range.
    """

    def __init__(
        self,
        robot: RobotModel,
        *,
        image_folder: Path,
        lean: bool = False,
        context: Context | None = None,
        namespace: str | None = None,
        use_sim_time: bool = False,
        command_type: Choice = "stamped",
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(
            NODE_NAME,
            context=context,
            namespace=namespace,
            enable_rosout=not lean,
            start_parameter_services=not lean,
            parameter_overrides=[
                Parameter("use_sim_time", value=use_sim_time),
                Parameter("start_type_description_service", value=not lean),
                *overrides(parameters or {}),
            ],
        )
        if lean:
            _log(self).set_level(LoggingSeverity.WARN)
        robot, wiring = declare_wiring(self, robot, command_type)
        self._robot = robot
        self._image_folder = image_folder
        self._declare_parameters()
        self._sensors = Sensors(self, wiring, robot.lidar)
        self._base = Base(self, wiring, self._lose_base)
        self._pilot = Pilot(
            self._sensors.observe,
            self._base.command,
            max_linear=robot.max_linear_velocity,
            max_angular=robot.max_angular_velocity,
        )
        self._adapters = [
            ActionAdapter(self, self._pilot, self._base.guarded(action))
            for action in self._actions()
        ]
        if not lean:
            watch_executives(self, self._lose_base)
        self._control_timer = self.create_timer(1.0 / robot.control_rate, self._pilot.step)

    def stop(self, reason: str) -> None:
        """Command zero velocity, end every goal as aborted with `reason`, and accept no more.

        The results go out as soon as the executor serves this node again.
        """
        for adapter in self._adapters:
            adapter.close(reason)
        self._pilot.stop(reason)

    def wait_until_stopped(self, timeout_s: float) -> None:
        """Block until every subscriber of `cmd_vel` has acknowledged the last command."""
        self._base.wait_until_stopped(timeout_s)

    def destroy_node(self) -> None:
        """Stop the robot, then leave the graph."""
        self.stop("the action servers have been shut down")
        for adapter in self._adapters:
            adapter.destroy()
        self._adapters.clear()
        Node.destroy_node(self)

    def _lose_base(self, reason: str) -> None:
        if not self._pilot.idle:
            self._pilot.stop(reason)

    def _actions(self) -> tuple[Action, ...]:
        robot, observe = self._robot, self._sensors.observe
        on_map = partial(observe, on_map=True)
        plan_explore = partial(explore_forward.plan, robot=robot)
        return (
            Action("explore_forward", ExploreForward, plan_explore, observe),
            Action("turn", Turn, self._plan_turn, observe),
            Action("camera_sweep", CameraSweep, self._plan_sweep, observe, self._sweeping),
            Action(
                "navigate_to_pose",
                NavigateToPose,
                partial(plan_navigate_to_pose, robot=robot),
                on_map,
                self._navigating,
            ),
            Action(
                "follow_waypoints",
                FollowWaypoints,
                partial(plan_follow_waypoints, robot=robot),
                on_map,
                self._navigating,
            ),
        )

    def _plan_turn(self, goal: Any, now: Observation) -> turn.Turn | Refusal:
        default = self.get_parameter(DEFAULT_TURN_VELOCITY).value
        return turn.plan(goal, now, self._robot, default)

    def _plan_sweep(self, goal: Any, now: Observation) -> camera_sweep.CameraSweep | Refusal:
        store = ImageFolder(self._image_folder)
        planned = camera_sweep.plan(goal, now, self._robot, self._sensors.camera, store)
        if isinstance(planned, Refusal) or self._sensors.camera.is_sent:
            return planned
        return Refusal(f"nobody publishes {self._sensors.camera.topic}")

    @contextmanager
    def _sweeping(self, sweep: camera_sweep.CameraSweep, goal_id: str) -> Iterator[None]:
        time_s = seconds(self.get_clock().now().nanoseconds)
        sweep.store.name = f"sweep_{time_s:.3f}_{goal_id[:8]}"
        try:
            yield
        finally:
            self._sensors.camera.off()

    @contextmanager
    def _navigating(self, _maneuver: object, _goal_id: str) -> Iterator[None]:
        with self._sensors.localization():
            yield

    def _declare_parameters(self) -> None:
        for name, value, description in (
            ("robot", self._robot.name, "Model of the robot: limits, hull and sensors."),
            ("image_folder", str(self._image_folder), "Where camera sweeps make their folders."),
        ):
            self.declare_parameter(
                name, value, ParameterDescriptor(description=description, read_only=True)
            )
        fastest = self._robot.max_angular_velocity
        self.declare_parameter(
            DEFAULT_TURN_VELOCITY,
            min(turn.DEFAULT_SPEED, fastest),
            ParameterDescriptor(
                description="Speed of a turn whose goal asks for 0, rad/s.",
                floating_point_range=[
                    FloatingPointRange(from_value=turn.SLOWEST, to_value=fastest)
                ],
            ),
        )


def _log(node: Node) -> Any:
    return node.get_logger()


def main(
    *,
    robot: str,
    image_folder: Path,
    namespace: str = "",
    use_sim_time: bool = False,
    command_type: Choice = "stamped",
    parameters: Path | None = None,
) -> int:
    """Serve until SIGINT or SIGTERM, then stop the robot and end every goal.

    `robot` is a name or a path, `parameters` a ROS parameter file. Returns the exit code 0; raises
    BtMissionError for a robot or a file that cannot be used. A second signal leaves at once.
    """
    model = load_robot(robot)
    file = None if parameters is None else read_parameters(parameters, NODE_NAME)
    # rclpy's own handlers would take the publisher away before the robot is stopped.
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = made_with(
            file,
            lambda values: ServersNode(
                model,
                image_folder=image_folder,
                namespace=namespace,
                use_sim_time=use_sim_time,
                command_type=command_type,
                parameters=values,
            ),
        )
        try:
            _serve(node)
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return 0


def _serve(node: ServersNode) -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with Interrupts() as interrupts:
        while not interrupts.received:
            executor.spin_once(timeout_sec=0.1)
        _log(node).info(f"{interrupts.received}: stopping the robot and ending all goals")
        node.stop(f"the action servers were stopped by {interrupts.received}")
        for _ in range(LAST_CALLBACKS):
            executor.spin_once(timeout_sec=0.0)
        node.wait_until_stopped(LAST_WORDS_S)
    executor.shutdown()
