"""The action servers as a ROS node: one base, one pilot, a table of actions."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.executors import SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_msgs.msg import Float64

from action_servers.core.action import Action
from action_servers.core.interlock import Interlock
from action_servers.core.maneuver import Maneuver
from action_servers.core.pilot import Pilot
from action_servers.core.step_hooks import Before
from action_servers.core.tuning import Tuning
from action_servers.driving import turn
from action_servers.mapping.tuning import FrontierTuning
from action_servers.navigation.tuning import NavigationTuning
from action_servers.robot_io.base import CommandPublisher
from action_servers.robot_io.command_types import Choice
from action_servers.robot_io.executive_watch import watch_executives
from action_servers.robot_io.interrupts import SignalNote
from action_servers.robot_io.node_parameters import declare_wiring, made_with, overrides
from action_servers.robot_io.parameter_file import read_parameters
from action_servers.robot_io.sensors import SensorSubscriptions
from action_servers.robot_io.tuning_parameters import declare_on_new_goal, declare_tuning
from action_servers.server.actions import ServerContext, actions
from action_servers.server.adapter import ActionAdapter
from action_servers.server.plan_topic import PlanTopic
from action_servers.server.switches import Switches
from bt_mission.core.robot.model import RobotModel, load_robot

if TYPE_CHECKING:
    from rclpy.context import Context

NODE_NAME = "bt_mission_servers"
DEFAULT_TURN_VELOCITY = "default_turn_velocity"

LAST_CALLBACKS = 100
"""Callbacks that are served after the servers were told to stop: a result takes three."""

LAST_WORDS_S = 0.5
"""Seconds to wait until the robot has confirmed the last command; it stops by itself then."""


class ServersNode(Node):
    """Offers the actions of `actions.py`, and the services `stop` and `release`.

    It knows the robot only through its topics: `scan`, `odom`, `tf`, `map`, `camera/image_raw`,
    `motors_on` and `cmd_vel`, relative to `namespace`.

    :param robot: limits, hull and sensors of the robot.
    :param image_folder: where each camera sweep makes a folder of its own.
    :param lean: no parameter services, log topic or type description, and only warnings in the
        log, as on the stage.
    :param context: the rclpy context; None is the default one.
    :param use_sim_time: follow `/clock`.
    :param command_type: the type of `cmd_vel`; "auto" is what the robot listens for, and goals
        that drive are refused while it would not hear.
    :param parameters: values of parameters by name, instead of their defaults.
    :param without: names of actions that are left to others.
    :param at_first: names of the actions that are offered before :meth:`offer_all`; None is all.
    :raises rclpy.exceptions.ParameterException: for a parameter out of its range.
    """

    def __init__(  # noqa: PLR0913 - everything that a node is told once
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
        without: Collection[str] = (),
        at_first: Collection[str] | None = None,
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
        tuning = declare_tuning(self, Tuning)
        self._sensors = SensorSubscriptions(self, wiring, robot.lidar)
        self._base = CommandPublisher(self, wiring, self._lose_base)
        self._pilot = Pilot(
            self._sensors.observe,
            self._base.command,
            max_linear=robot.max_linear_velocity,
            max_angular=robot.max_angular_velocity,
            replaces=declare_on_new_goal(self) == "replace",
            side_goals=tuning.side_goals,
        )
        self._interlock = Interlock(self._pilot)
        self._switches = Switches(self, self._interlock)
        self._distance = self.create_publisher(Float64, "total_distance", 10)
        kit = ServerContext(
            robot=robot,
            tuning=tuning,
            navigation=declare_tuning(self, NavigationTuning, "navigation."),
            frontiers=declare_tuning(self, FrontierTuning, "frontiers."),
            sensors=self._sensors,
            image_folder=image_folder,
            turn_velocity=lambda: self.get_parameter(DEFAULT_TURN_VELOCITY).value,
            publish_distance=self._publish_distance,
            publish_path=PlanTopic(self, lean=lean).publish,
        )

        def refusal(maneuver: Maneuver) -> str | None:
            return self._interlock.refusal(needs_base=maneuver.needs_base)

        def offer(action: Action) -> ActionAdapter:
            return ActionAdapter(self, self._pilot, self._base.guarded(action), refusal)

        mine = [action for action in actions(kit) if action.name not in without]
        first = [one for one in mine if at_first is None or one.name in at_first]
        self._offer = offer
        self._adapters = [offer(action) for action in first]
        self._not_yet = [action for action in mine if action not in first]
        if not lean:
            watch_executives(self, self._lose_base)
        self._control_timer = self.create_timer(1.0 / robot.control_rate, self._pilot.step)

    @property
    def missing(self) -> tuple[str, ...]:
        """What goals that drive still wait for."""
        seen = self._sensors.observe()
        found = {"scan": seen.scan, "odometry": seen.odom}
        return tuple(name for name, value in found.items() if value is None)

    def why_rejected(self, action: str) -> str:
        """Why the last goal of an action, by its resolved name, was rejected; empty if unknown."""
        return next((one.refused for one in self._adapters if one.name == action), "")

    @property
    def actions(self) -> tuple[str, ...]:
        """Resolved names of the actions that are offered."""
        return tuple(adapter.name for adapter in self._adapters)

    def offer_all(self) -> None:
        """Offer what was not offered at first."""
        self._adapters += map(self._offer, self._not_yet)
        self._not_yet = []

    def interpose(self, action: str, before: Before) -> Callable[[], None]:
        """Ask before each step of an action's maneuvers; gives a function that ends it.

        `action` is one of `actions`.
        """
        return next(one for one in self._adapters if one.name == action).interpose(before)

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
        self.vanish()

    def vanish(self) -> None:
        """Leave the graph without a word, as a process does that is killed."""
        for adapter in self._adapters:
            adapter.destroy()
        self._adapters.clear()
        Node.destroy_node(self)

    def _lose_base(self, reason: str) -> None:
        if not self._pilot.idle:
            self._pilot.stop(reason)

    def _publish_distance(self, metres: float) -> None:
        self._distance.publish(Float64(data=metres))

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
    missing = node.missing
    _log(node).info(f"waiting for {' and '.join(missing)}: is the robot, or bt-mission sim, there?")
    with SignalNote() as interrupts:
        while not interrupts.received:
            executor.spin_once(timeout_sec=0.1)
            if missing and not (missing := node.missing):
                _log(node).info("ready: scan and odometry have come")
        _log(node).info(f"{interrupts.received}: stopping the robot and ending all goals")
        node.stop(f"the action servers were stopped by {interrupts.received}")
        for _ in range(LAST_CALLBACKS):
            executor.spin_once(timeout_sec=0.0)
        node.wait_until_stopped(LAST_WORDS_S)
    executor.shutdown()
