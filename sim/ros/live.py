"""The simulator in a process of its own: paced against the wall, ended by a signal."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack, closing
from importlib.util import find_spec

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.exceptions import ParameterException
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from bt_mission.core.dds.endpoints import UNNAMED, unheard
from bt_mission.core.errors import BtMissionError
from bt_mission.core.interrupts import InterruptSignals
from bt_mission.core.ros_log import log_of
from bt_mission.core.wall_clock import Pacer, Stopwatch
from bt_mission.executors.live import LiveExecutor
from sim.physics.spawn import RobotSpawn
from sim.ros.node import SimNode, SimOptions
from sim.ros.run_control import RunControl, RunState
from sim.ros.topics import COMMAND_TYPES
from sim.views.window import Window, check_display
from sim.world.loader import load_world

SLOWEST, FASTEST = 0.01, 1000.0
"""Times real time."""

CLOCK_HZ = 100.0
_TICK_S = 0.01
_FRAME_S = 0.03
_WATCH_S = 1.0
_TICKS_A_CLOCK = 10
_FAREWELL_S = 0.3

LOOK_S = 0.1
"""How often at least a signal is looked for, s."""


class SpeedError(BtMissionError):
    """A speed at which nothing useful can be paced."""


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
    # With handlers of our own: rclpy's would pull the context from under the callback that runs.
    rclpy.init(args=["--ros-args", *ros_args], signal_handler_options=SignalHandlerOptions.NO)
    with ExitStack() as stack:
        interrupts = stack.enter_context(InterruptSignals())
        stack.callback(rclpy.shutdown)
        try:
            node = SimNode(scene, robots, options)
            control = RunControl(node)
            _declare_parameters(node, options.seed)
            _pace(node, control, speed)
        except ParameterException as error:
            raise BtMissionError(str(error)) from error
        node.publish_clock_at(CLOCK_HZ)
        wall = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(_WATCH_S, CommandWatch(node).look, clock=wall)
        _offer_services(node, control, world)
        if view:
            window = stack.enter_context(closing(Window(node.physics)))
            node.create_timer(_FRAME_S, window.look, clock=wall)
        speed = node.get_parameter("speed").value
        log_of(node).info(f"{_names(node)} in {scene.name}, seed {options.seed}, speed {speed:g}")
        executor = LiveExecutor()
        executor.add_node(node)
        while not interrupts.count and control.state is not RunState.QUITTING:
            executor.spin_once(timeout_sec=LOOK_S)
        said = Stopwatch()  # the answer to whoever has it quit needs a moment to get there
        while not interrupts.count and said.elapsed_s < _FAREWELL_S:
            executor.spin_once(timeout_sec=LOOK_S)
        node.destroy_node()
    return 0


class CommandWatch:
    """Warns once of each node whose velocity commands have a type that no robot takes."""

    def __init__(self, node: SimNode) -> None:
        self._node = node
        self._told: set[tuple[str, str, str]] = set()
        self._unnamed: set[tuple[str, str, str]] = set()

    def look(self) -> None:
        """Look who publishes `cmd_vel` of each robot, and as what.

        A node whose name is not known yet is told of if it has none at the next look either.
        """
        taken = COMMAND_TYPES[self._node.command_type]
        other = "plain" if self._node.command_type == "stamped" else "stamped"
        found: set[tuple[str, str, str]] = set()
        for robot in self._node.robots:
            topic = self._node.resolve_topic_name(f"{robot.prefix}cmd_vel")
            publishers = self._node.get_publishers_info_by_topic(topic)
            found |= {(topic, *one) for one in unheard(publishers, {taken}).items()}
        unnamed = {one for one in found if UNNAMED in one}
        lost = found - (unnamed - self._unnamed) - self._told
        for topic, who, sent in sorted(lost):
            log_of(self._node).warning(
                f"{topic}: {who} publishes {sent}, but the robot takes {taken}, so it does not "
                f"hear; have {who} publish that, or start with --cmd-vel-type {other}"
            )
        self._told |= lost
        self._unnamed = unnamed


def _names(node: SimNode) -> str:
    return ", ".join(
        f"{one.name} ({one.robot.name})" if one.name else one.robot.name for one in node.robots
    )


def _declare_parameters(node: SimNode, seed: int) -> None:
    """Show what cannot be changed while it runs."""
    for name, value, description in (
        ("world", node.physics.world.name, "Name of the world."),
        ("robot", _names(node), "Model of the robot, or names and models of several."),
        ("seed", seed, "Seed of all sensor noise."),
    ):
        descriptor = ParameterDescriptor(description=description, read_only=True)
        node.declare_parameter(name, value, descriptor, ignore_override=True)


def _offer_services(node: SimNode, control: RunControl, world: str) -> None:
    """Answer the standard interfaces of simulators, where their types are installed."""
    if find_spec("simulation_interfaces") is None:
        log_of(node).warning(
            "the standard services of simulators are not there: the package simulation_interfaces"
            " is not installed; install bt-mission anew, or ros-jazzy-simulation-interfaces"
        )
        return
    from sim.ros.standard_services import (  # noqa: PLC0415 - needs what may not be installed
        offer_standard_services,
    )

    offer_standard_services(node, control, world)


def _pace(node: SimNode, control: RunControl, speed: float) -> None:
    """Move the node from a timer on the wall clock; its parameter `speed` may be set any time.

    While it stands, the time is told all the same, for those who join.
    """
    wall = Clock(clock_type=ClockType.STEADY_TIME)
    allowed = FloatingPointRange(from_value=SLOWEST, to_value=FASTEST)
    description = "How many times faster than the wall clock virtual time runs."
    descriptor = ParameterDescriptor(description=description, floating_point_range=[allowed])
    speed = node.declare_parameter("speed", speed, descriptor).value
    pacer = Pacer(speed, node.next_due_ns)
    _be_patient(node, speed)

    stood = 0

    def tick() -> None:
        nonlocal stood
        if not control.is_running:
            pacer.set_speed(pacer.speed, node.time_ns)  # there is nothing to catch up with
            stood += 1
            if stood % _TICKS_A_CLOCK == 0:
                node.publish_clock()
            return
        control.advance_to(pacer.due_ns(node.time_ns))
        reached = pacer.shortfall()
        if reached is not None:
            log_of(node).warning(f"too slow for speed {pacer.speed:g}: reached {reached:.2g}")

    def on_parameters(parameters: list[Parameter]) -> None:
        for parameter in parameters:
            if parameter.name == "speed":
                pacer.set_speed(parameter.value, node.physics.time_ns)
                _be_patient(node, parameter.value)

    node.add_post_set_parameters_callback(on_parameters)

    node.create_timer(_TICK_S, tick, clock=wall)


def _be_patient(node: SimNode, speed: float) -> None:
    """Let commands hold as long on the wall as at real time: they do not come any sooner."""
    for robot in node.robots:
        robot.be_patient(max(1.0, speed))
