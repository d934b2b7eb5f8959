"""The simulator in its own process, with the standard interfaces of simulators.

It is paced against the wall clock, and ended by a signal.
"""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.executors import Executor
from rclpy.parameter import Parameter

from bt_mission.base.commands import page
from bt_mission.base.dds.endpoints import UNNAMED, unheard
from bt_mission.base.errors import BtMissionError
from bt_mission.base.parameters import ParameterSpec
from bt_mission.base.ros_log import log_of
from bt_mission.base.stamps import set_ns
from bt_mission.base.wall_clock import Pacer, Stopwatch
from bt_mission.ros.executors.process import LOOK_S, ProcessOptions, run
from sim.entities import Entities
from sim.physics.spawn import RobotSpawn
from sim.ros.entity_services import EntityServices
from sim.ros.node import NODE_NAME, SimNode, SimOptions
from sim.ros.run_control import RunControl, RunState
from sim.ros.run_services import RunServices
from sim.ros.topics import COMMAND_TYPES
from sim.ros.world_services import WorldServices
from sim.views.window import Window, check_display
from sim.world.loader import load_world
from sim.world.world import World

ABOUT = f"bt-mission sim; {page('simulator')} says what each service does"


def offer_standard_services(node: SimNode, control: RunControl, source: str) -> None:
    """Offer the standard's services and actions that a simulation supports.

    `source` is the name or path of its world.
    """

    def fill_now(stamp: Any) -> Any:
        return set_ns(stamp, node.clock_ns)

    entities = Entities(node.physics, node.robots)
    run = RunServices(node, control)
    about = EntityServices(node, control, entities, fill_now).features
    about += WorldServices(node, control, node.physics.world, source).features
    run.offer_always([*run.features, *about], ABOUT)


SLOWEST, FASTEST = 0.01, 1000.0
"""Times real time."""

CLOCK_HZ = 100.0
_TICK_S = 0.01
_FRAME_S = 0.03
_WATCH_S = 1.0
_TICKS_A_CLOCK = 10
_FAREWELL_S = 0.3


class SpeedError(BtMissionError):
    """A speed at which nothing useful can be paced."""

    code = "BT-808"


def check_speed(speed: float) -> None:
    """Raise SpeedError for a speed that is not between SLOWEST and FASTEST."""
    if not SLOWEST <= speed <= FASTEST:
        raise SpeedError(f"expected a speed from {SLOWEST} to {FASTEST:g}, got {speed}")


def main(
    *,
    world: str,
    robots: Sequence[RobotSpawn],
    options: SimOptions,
    speed: float = 1.0,
    view: bool = False,
    ros_args: Sequence[str] = (),
) -> int:
    """Run the simulator until SIGINT or SIGTERM, `speed` times as fast as the wall clock.

    `world` is a name or a path. `view` opens MuJoCo's own viewer. `ros_args` is what follows
    `--ros-args`. Returns the exit code 0. Raises BtMissionError for a world, a speed or a parameter
    that cannot be used, for robots that do not fit, and without a display to view it on.
    """
    check_speed(speed)
    if view:
        check_display()
    scene = load_world(world)

    def make(chosen: SimOptions) -> LiveSimNode:
        return LiveSimNode(scene, robots, chosen, source=world, speed=speed, view=view)

    return run(NODE_NAME, ProcessOptions(ros_args=ros_args), options, make)


class LiveSimNode(SimNode):
    """The simulator's node, paced against the wall clock.

    Its parameter `speed` may be set any time. `source` is what the world was loaded from.
    """

    def __init__(
        self,
        world: World,
        robots: Sequence[RobotSpawn],
        options: SimOptions,
        *,
        source: str,
        speed: float,
        view: bool,
    ) -> None:
        super().__init__(world, robots, options)
        self._source, self._seed, self._view = source, options.seed, view
        self._control = RunControl(self)
        self._window: Window | None = None
        self._wall = Clock(clock_type=ClockType.STEADY_TIME)
        self._show_what_is_fixed()
        description = "How many times faster than the wall clock virtual time runs."
        speed = self.declare(
            "speed", ParameterSpec(speed, description, SLOWEST, FASTEST, is_fixed=False)
        )
        self._pacer = Pacer(speed, self.next_due_ns)
        self._stood = 0
        self._scale_command_timeout(speed)
        self.add_post_set_parameters_callback(self._change_speed)
        self.create_timer(_TICK_S, self._tick, clock=self._wall)

    @property
    def is_done(self) -> bool:
        """Whether it has to quit."""
        return self._control.state is RunState.QUITTING

    def begin(self) -> None:
        """Offer the services of a process, and log what is simulated."""
        self.publish_clock_at(CLOCK_HZ)
        self.create_timer(_WATCH_S, CommandWatch(self).look, clock=self._wall)
        self._offer_services()
        if self._view:
            self._window = Window(self.physics)
            self.create_timer(_FRAME_S, self._window.look, clock=self._wall)
        world, speed = self.physics.world.name, self._pacer.speed
        self._log.info(f"{self._names} in {world}, seed {self._seed}, speed {speed:g}")

    def end(self, signal: str, executor: Executor) -> None:
        """Answer the request that ended it, which needs a moment to arrive."""
        since = Stopwatch()
        while not signal and since.elapsed_s < _FAREWELL_S:
            executor.spin_once(timeout_sec=LOOK_S)

    def destroy_node(self) -> None:
        """Close the window with the node."""
        if self._window is not None:
            self._window.close()
        super().destroy_node()

    @property
    def _names(self) -> str:
        return ", ".join(
            f"{robot.name} ({robot.robot.name})" if robot.name else robot.robot.name
            for robot in self.robots
        )

    def _show_what_is_fixed(self) -> None:
        """Declare parameters that show what cannot be changed while it runs."""
        for name, value, description in (
            ("world", self.physics.world.name, "Name of the world."),
            ("robot", self._names, "Model of the robot, or names and models of several."),
            ("seed", self._seed, "Seed of all sensor noise."),
        ):
            descriptor = ParameterDescriptor(description=description, read_only=True)
            self.declare_parameter(name, value, descriptor, ignore_override=True)

    def _tick(self) -> None:
        pacer, control = self._pacer, self._control
        if not control.is_running:
            pacer.set_speed(pacer.speed, self.time_ns)  # there is nothing to catch up with
            self._stood += 1
            if self._stood % _TICKS_A_CLOCK == 0:  # for late subscribers
                self.publish_clock()
            return
        control.advance_to(pacer.due_ns(self.time_ns))
        reached = pacer.shortfall()
        if reached is not None:
            self._log.warning(f"too slow for speed {pacer.speed:g}: reached {reached:.2g}")

    def _change_speed(self, parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "speed":
                self._pacer.set_speed(parameter.value, self.physics.time_ns)
                self._scale_command_timeout(parameter.value)

    def _scale_command_timeout(self, speed: float) -> None:
        """Let commands hold as long on the wall clock as at real time."""
        for robot in self.robots:
            robot.scale_command_timeout(max(1.0, speed))

    def _offer_services(self) -> None:
        """Offer the standard interfaces of simulators, if their types are installed."""
        if find_spec("simulation_interfaces") is None:
            self._log.warning(
                "the standard services of simulators are not available: the package "
                "simulation_interfaces is not installed; reinstall bt-mission, or "
                "ros-jazzy-simulation-interfaces"
            )
            return
        from sim.ros.live import (  # noqa: PLC0415 - needs what may not be installed
            offer_standard_services,
        )

        offer_standard_services(self, self._control, self._source)


class CommandWatch:
    """Warns once of each node whose velocity commands have a type that no robot takes."""

    def __init__(self, node: SimNode) -> None:
        self._node = node
        self._reported: set[tuple[str, str, str]] = set()
        self._unnamed: set[tuple[str, str, str]] = set()

    def look(self) -> None:
        """Check the publishers of each robot's `cmd_vel`, and their types.

        A node without a known name is reported if it still has none at the next check.
        """
        taken = COMMAND_TYPES[self._node.command_type]
        other = "plain" if self._node.command_type == "stamped" else "stamped"
        misfits: set[tuple[str, str, str]] = set()
        for robot in self._node.robots:
            topic = self._node.resolve_topic_name(f"{robot.prefix}cmd_vel")
            publishers = self._node.get_publishers_info_by_topic(topic)
            misfits |= {(topic, *misfit) for misfit in unheard(publishers, {taken}).items()}
        unnamed = {misfit for misfit in misfits if UNNAMED in misfit}
        lost = misfits - (unnamed - self._unnamed) - self._reported
        for topic, who, sent in sorted(lost):
            log_of(self._node).warning(
                f"{topic}: {who} publishes {sent}, but the robot takes {taken}, so it does not "
                f"hear; have {who} publish that, or start with --cmd-vel-type {other}"
            )
        self._reported |= lost
        self._unnamed = unnamed
