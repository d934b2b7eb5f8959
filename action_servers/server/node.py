"""The action servers as a ROS node: one base, one pilot, a table of actions, and parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rclpy.executors import Executor
from rclpy.logging import LoggingSeverity
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher

from action_servers.core.action import (
    Action,
    PublishedTopic,
    ServerContext,
    action,
    lacks_part,
)
from action_servers.core.governor import Governor
from action_servers.core.maneuver import Fields, missing
from action_servers.core.pilot import Interlock, Pilot
from action_servers.core.tuning import TUNING
from action_servers.robot_io.adapter import ActionAdapter, Before
from action_servers.robot_io.base import Choice, CommandPublisher, CommandWiring, JointCommander
from action_servers.robot_io.messages import MAP_FRAME, fill, generated_type
from action_servers.robot_io.sensors import LATCHED, SensorSubscriptions, SensorWiring
from action_servers.server.topics import (
    ExecutiveLimits,
    PublisherWatch,
    Switches,
    answer_as_navigator,
    watch_executives,
)
from bt_mission.base.action_requests import BURST
from bt_mission.base.actions import declared
from bt_mission.base.errors import BtMissionError
from bt_mission.base.parameters import ParameterSpec
from bt_mission.robots.model import RobotModel, load_robot
from bt_mission.ros.executors.action_endpoints import duplicate_servers, settled
from bt_mission.ros.executors.process import (
    LOOK_S,
    NO_ARGUMENTS,
    ProcessOptions,
    RobotNode,
    RobotNodeOptions,
    run,
)

SLOWEST_CONTROL_HZ, FASTEST_CONTROL_HZ = 5.0, 100.0
LOWEST_LINEAR, LOWEST_ANGULAR = 0.05, 0.1

ON_NEW_GOAL = ParameterSpec(
    "replace",
    "What a goal does that comes while another one drives: replace it, which ends aborted, or be "
    "refused itself.",
    choices=("replace", "refuse"),
)


def limited(node: RobotNode, robot: RobotModel) -> RobotModel:
    """Declare the rate of control and the highest speeds; return the robot within them.

    Raises:
        rclpy.exceptions.ParameterException: For a limit out of its range.
    """
    linear, angular = robot.max_linear_velocity, robot.max_angular_velocity
    limits = {
        "control_rate": ParameterSpec(
            robot.control_rate,
            "Control steps and commands a second, Hz.",
            SLOWEST_CONTROL_HZ,
            FASTEST_CONTROL_HZ,
        ),
        "max_linear_velocity": ParameterSpec(
            linear,
            "Fastest that is commanded, m/s; at most what the robot's model says.",
            min(LOWEST_LINEAR, linear),
            linear,
        ),
        "max_angular_velocity": ParameterSpec(
            angular,
            "Fastest turn that is commanded, rad/s; at most what the robot's model says.",
            min(LOWEST_ANGULAR, angular),
            angular,
        ),
    }
    return robot.model_copy(
        update={name: node.declare(name, spec) for name, spec in limits.items()}
    )


def declare_server_parameters(node: RobotNode, robot: RobotModel, image_folder: Path) -> None:
    """Declare what the node was started with, to be looked at."""
    node.declare(
        "robot", ParameterSpec(robot.name, "Model of the robot: limits, hull and sensors.")
    )
    node.declare(
        "image_folder",
        ParameterSpec(
            str(image_folder), "Where images are stored, those of each goal in a folder."
        ),
    )


NODE_NAME = "bt_mission_servers"

READY = "ready: scan and odometry have come"

LAST_CALLBACKS = 100
"""Callbacks that are served after the servers must stop: a result takes three."""

LAST_WORDS_S = 0.5
"""Seconds to wait for the robot's acknowledgement of the last command; the robot then stops alone.
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerOptions(RobotNodeOptions):
    """How the servers' node is made.

    Args:
        image_folder: The folder in which each camera sweep creates its folder.
        command_type: The type of `cmd_vel`; "auto" is what the robot subscribes to, and goals that
            drive are refused without a subscription.
        extra_actions: Actions of the user. One with the name of a known action replaces it.
        without: Names of actions that other nodes serve.
        allow_duplicates: Drive also while several nodes publish the same odometry or clock.
        at_first: Names of the actions that are offered before `ServersNode.offer_all`; None is
            all. Until then a lean node logs no rejected and no aborted goals.
    """

    image_folder: Path
    command_type: Choice = "stamped"
    extra_actions: Sequence[Action] = ()
    without: Collection[str] = ()
    allow_duplicates: bool = False
    at_first: Collection[str] | None = None


class ServersNode(RobotNode):
    """Offers the declared actions, those of the options, and the services `stop`, `release`.

    It knows the robot only through its topics: `scan`, `odom`, `tf`, `map`, `camera/image_raw`,
    `motors_on` and `cmd_vel`, relative to the namespace.

    Args:
        robot: Limits, hull and sensors of the robot.
        options: Everything else.

    Raises:
        rclpy.exceptions.ParameterException: For a parameter out of its range.
    """

    def __init__(self, robot: RobotModel, options: ServerOptions) -> None:
        super().__init__(NODE_NAME, options)
        sensors = self.declare_all(SensorWiring())
        commands = self.declare_all(CommandWiring.of_type(options.command_type))
        robot = limited(self, robot)
        declare_server_parameters(self, robot, options.image_folder)
        tuning = self.declare_all(TUNING)
        self._sensors = SensorSubscriptions(self, sensors, robot)
        self._base = CommandPublisher(self, commands, self._lose_base)
        self._governor = Governor(robot, tuning)
        self._pilot = Pilot(
            self._sensors.observe,
            self._base.command,
            self._governor,
            replaces=self.declare("on_new_goal", ON_NEW_GOAL) == "replace",
            side_goals=tuning.side_goals,
        )
        self._publisher_watch = self._watch_publishers(sensors.odom, options)
        looks = [self._base.watch]
        if self._publisher_watch is not None:
            looks.append(self._publisher_watch.look)
        self._interlock = Interlock(self._pilot, looks)
        self._switches = Switches(self, self._interlock)
        self._tunings: dict[type, Any] = {}
        self._is_lean = options.lean
        self._topics: dict[PublishedTopic, Publisher] = {}
        self._context_of_plans = ServerContext(
            robot=robot,
            tuning=self._tuned,
            camera=self._sensors.camera,
            image_folder=options.image_folder,
            joints=JointCommander(self, robot),
            publish=self._publish,
        )
        self._extra = {extra_action.name: extra_action for extra_action in options.extra_actions}
        # On a stage, requests pass by the taps of tests one by one.
        self._burst = 1 if options.lean else BURST
        names = dict.fromkeys((*declared(), *self._extra))
        absent = {name for name, each in declared().items() if lacks_part(each.known, robot)}
        mine = [name for name in names if name not in options.without and name not in absent]
        first = set(names) if options.at_first is None else set(options.at_first)
        if options.at_first is None:
            for name in names:  # a file of parameters may be that of several robots
                self.declare_all(self._action(name).tuning)
        self._adapters = [self._offered(name) for name in mine if name in first]
        self._not_yet = [name for name in mine if name not in first]
        self.add_post_set_parameters_callback(self._retune)
        # The only client tells people what became of its goals.
        is_private = options.lean and options.at_first is not None
        for adapter in self._adapters:
            adapter.log_from(LoggingSeverity.ERROR if is_private else LoggingSeverity.UNSET)
        if not options.lean:
            watch_executives(self, self.declare_all(ExecutiveLimits()), self._pilot)
            answer_as_navigator(self, lambda: missing(self._sensors.observe(on_map=True)) is None)
        self._control_timer = self.create_timer(1.0 / robot.control_rate, self._pilot.step)
        self._missing: tuple[str, ...] = ()

    @property
    def missing(self) -> tuple[str, ...]:
        """The messages for which goals that drive still wait."""
        seen = self._sensors.observe()
        messages = {"scan": seen.scan, "odometry": seen.odom}
        return tuple(name for name, value in messages.items() if value is None)

    def why_rejected(self, action: str) -> str:
        """Why the last goal of an action, by its resolved name, was rejected; empty if unknown."""
        return next((adapter.refused for adapter in self._adapters if adapter.name == action), "")

    @property
    def actions(self) -> tuple[str, ...]:
        """Resolved names of the actions that are offered."""
        return tuple(adapter.name for adapter in self._adapters)

    def offer_all(self) -> None:
        """Offer what was not offered at first."""
        self._adapters += [self._offered(name) for name in self._not_yet]
        self._not_yet = []
        for adapter in self._adapters:
            adapter.log_from(LoggingSeverity.UNSET)

    def interpose(self, action: str, before: Before) -> Callable[[], None]:
        """Ask before each step of an action's maneuvers; gives a function that ends it.

        `action` is one of `actions`.
        """
        return next(adapter for adapter in self._adapters if adapter.name == action).interpose(
            before
        )

    def stop(self, reason: str) -> None:
        """Command zero velocity, end every goal as aborted with `reason`, and accept no more.

        The results go out as soon as the executor serves this node again.
        """
        for adapter in self._adapters:
            adapter.close(reason)
        self._pilot.stop(reason)

    def destroy_node(self) -> None:
        """Stop the robot, then leave the graph."""
        self.stop("the action servers have been shut down")
        self.vanish()

    def vanish(self) -> None:
        """Leave the graph silently, as a killed process does."""
        for adapter in self._adapters:
            adapter.destroy()
        self._adapters.clear()
        super().destroy_node()

    def refuse_conflicts(self, executor: Executor) -> None:
        """Look whether another node serves one of these actions.

        Raises:
            BtMissionError: One does; each goal would run in both.
        """
        if self._publisher_watch is None:
            return
        why = settled(
            self,
            lambda: duplicate_servers(self, self.actions),
            lambda: executor.spin_once(timeout_sec=LOOK_S),
        )
        if why is not None:
            raise BtMissionError(why, code="BT-914")

    def begin(self) -> None:
        """Say what is waited for."""
        self._missing = self.missing
        if self._missing:
            names = " and ".join(self._missing)
            self._log.info(f"waiting for {names}: is the robot, or bt-mission sim, there?")
        else:
            self._log.info(READY)

    def look(self) -> None:
        """Say once that the robot's sensors have come."""
        if self._missing:
            self._missing = self.missing
            if not self._missing:
                self._log.info(READY)

    def end(self, signal: str, executor: Executor) -> None:
        """Stop the robot, and wait until every goal has ended."""
        self._log.info(f"{signal}: stopping the robot and ending all goals")
        self.stop(f"the action servers were stopped by {signal}")
        for _ in range(LAST_CALLBACKS):
            executor.spin_once(timeout_sec=0.0)
        self._base.wait_until_stopped(LAST_WORDS_S)

    def _action(self, name: str) -> Action:
        """Return an action; one of the user's own takes the place of ours."""
        return self._extra[name] if name in self._extra else action(name)

    def _tuned(self, defaults: Any) -> Any:
        """Return parameters with their present values."""
        kind = type(defaults)
        if kind not in self._tunings:
            self._tunings[kind] = self.read_all(defaults)
        return self._tunings[kind]

    def _retune(self, _parameters: Sequence[Parameter]) -> None:
        """Have the goals that come from now on planned with the present parameters."""
        self._tunings.clear()
        self._governor.tuning = self._tuned(TUNING)

    def _publish(self, topic: PublishedTopic, fields: Fields) -> None:
        """Publish for a goal; on a stage, what is latched only while somebody subscribes to it."""
        publisher = self._topics[topic]
        if self._is_lean and topic.is_latched and not publisher.get_subscription_count():
            return
        clock = self.get_clock()
        message = fill(generated_type(topic.type)(), fields, lambda: clock.now().to_msg())
        if hasattr(message, "header"):
            message.header.frame_id, message.header.stamp = MAP_FRAME, clock.now().to_msg()
        publisher.publish(message)

    def _lose_base(self, reason: str) -> None:
        if not self._pilot.idle:
            self._pilot.stop(reason)

    def _offered(self, name: str) -> ActionAdapter:
        offered = self._action(name)
        offered.offered()
        self.declare_all(offered.tuning)
        topic = offered.topic
        if topic is not None and topic not in self._topics:
            qos = LATCHED if topic.is_latched else 10
            self._topics[topic] = self.create_publisher(generated_type(topic.type), topic.name, qos)
        return ActionAdapter(
            self,
            self._pilot,
            offered,
            self._context_of_plans,
            self._sensors,
            self._interlock,
            self._burst,
        )

    def _watch_publishers(self, odometry: str, options: ServerOptions) -> PublisherWatch | None:
        """Look out for a second robot; on a stage, which is lean, there is no other."""
        if options.lean or options.allow_duplicates:
            return None
        return PublisherWatch(self, odometry, self._lose_base)


def main(
    *,
    robot: str,
    image_folder: Path,
    namespace: str = "",
    use_sim_time: bool = False,
    command_type: Choice = "stamped",
    process: ProcessOptions = NO_ARGUMENTS,
    allow_duplicates: bool = False,
) -> int:
    """Serve until SIGINT or SIGTERM, then stop the robot and end every goal.

    `robot` is a name or a path. Returns the exit code 0; raises
    BtMissionError for a robot or a file that cannot be used. A second signal leaves at once.
    """
    model = load_robot(robot)
    options = ServerOptions(
        image_folder=image_folder,
        namespace=namespace,
        use_sim_time=use_sim_time,
        command_type=command_type,
        allow_duplicates=allow_duplicates,
    )
    return run(NODE_NAME, process, options, lambda options: ServersNode(model, options))
