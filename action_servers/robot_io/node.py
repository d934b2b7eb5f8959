"""What our nodes beside a robot have in common: options, parameters, life as a process."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import rclpy
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from action_servers.core.parameters import ParameterSpec, specs
from action_servers.robot_io.parameter_file import ParameterFile, read_parameters
from bt_mission.core.diagnostics import InputError
from bt_mission.core.errors import BtMissionError
from bt_mission.core.interrupts import InterruptSignals

D = TypeVar("D", bound=Any)
N = TypeVar("N", bound="RobotNode")
Options = TypeVar("Options", bound="RobotNodeOptions")

LOOK_S = 0.1
"""How often at least a signal is looked for, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotNodeOptions:
    """How a node joins the graph.

    Args:
        context: The rclpy context; None is the default one.
        namespace: Of all its relative names.
        use_sim_time: Follow `/clock`.
        lean: No parameter services, log topic or type description, and only warnings in the log,
            as on the stage.
        parameters: Values of parameters by name, instead of their defaults.
    """

    context: Context | None = None
    namespace: str | None = None
    use_sim_time: bool = False
    lean: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)


class RobotNode(Node):
    """A node made with our options, whose parameters are declared by their specs."""

    def __init__(self, name: str, options: RobotNodeOptions) -> None:
        super().__init__(
            name,
            context=options.context,
            namespace=options.namespace,
            enable_rosout=not options.lean,
            start_parameter_services=not options.lean,
            parameter_overrides=[
                Parameter("use_sim_time", value=options.use_sim_time),
                Parameter("start_type_description_service", value=not options.lean),
                *(Parameter(name, value=value) for name, value in options.parameters.items()),
            ],
        )
        self._log: Any = Node.get_logger(self)
        if options.lean:
            self._log.set_level(LoggingSeverity.WARN)

    def declare(self, name: str, spec: ParameterSpec) -> Any:
        """Declare a parameter; return its value.

        Raises:
            rclpy.exceptions.ParameterException: For an override of another type, out of its range
                or not among its choices.
        """
        value = self.declare_parameter(name, spec.default, _descriptor(spec)).value
        fault = spec.fault_of_text(name, value) if isinstance(spec.default, str) else None
        if fault is not None:
            raise InvalidParameterValueException(name, value, fault)
        return value

    def declare_all(self, defaults: D, prefix: str = "") -> D:
        """Declare the parameters of a dataclass, with its values as defaults; return their values.

        `prefix` comes before each name, such as `navigation.`. Raises as `declare`.
        """
        values = {
            attribute: self.declare(
                prefix + name, replace(spec, default=getattr(defaults, attribute))
            )
            for attribute, (name, spec) in specs(defaults).items()
        }
        return replace(defaults, **values)

    def begin(self) -> None:
        """Begin as a process, before the first callback."""

    def look(self) -> None:
        """Look after the node, after each callback."""

    def destroy_node(self) -> None:
        """Leave the graph."""
        Node.destroy_node(self)

    def end(self, signal: str, executor: Executor) -> None:
        """Come to a good end after the signal of that name."""


def _descriptor(spec: ParameterSpec) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=spec.description,
        additional_constraints=spec.constraint,
        read_only=spec.is_fixed,
    )
    low, high = spec.low, spec.high
    if isinstance(spec.default, float):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=float(low), to_value=float(high))
        ]
    elif isinstance(spec.default, int) and not isinstance(spec.default, bool):
        descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high), step=1)]
    return descriptor


def made_with(file: ParameterFile | None, options: Options, make: Callable[[Options], N]) -> N:
    """Make a node with the values of a file, none of which may be unknown to it or out of range.

    Raises:
        InputError: With the place of the fault in the file.
    """
    if file is None:
        return make(options)
    try:
        node = make(replace(options, parameters=file.values))
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise _refused(file, error) from error
    try:
        file.refuse_unknown(node.list_parameters([], 0).names)
    except InputError:
        node.destroy_node()
        raise
    return node


def _refused(file: ParameterFile, error: Exception) -> BtMissionError:
    text = str(error)
    name = next((name for name in file.values if text.endswith(f": {name}")), None)
    if name is None:
        return BtMissionError(text)
    value = file.values[name]
    is_whole = isinstance(value, int) and "DOUBLE" in text
    hint = f"write {value}.0" if is_whole else None
    return InputError([file.fault(name, text.removesuffix(f": {name}"), hint)])


def run(
    name: str, parameters: Path | None, options: Options, make: Callable[[Options], RobotNode]
) -> int:
    """Make the node of that name and serve it until SIGINT or SIGTERM; the second leaves at once.

    Args:
        name: The node's name, by which a parameter file has a section for it.
        parameters: A ROS parameter file.
        options: What the node is made with, beside the values of the file.
        make: Makes the node.

    Returns:
        The exit code 0.

    Raises:
        BtMissionError: For a file that cannot be used.
    """
    file = None if parameters is None else read_parameters(parameters, name)
    # rclpy's own handlers would take the publishers away before the robot is stopped.
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    try:
        node = made_with(file, options, make)
        try:
            _serve(node)
        finally:
            node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return 0


def _serve(node: RobotNode) -> None:
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    node.begin()
    with InterruptSignals(most=1) as interrupts:
        while not interrupts.count:
            executor.spin_once(timeout_sec=LOOK_S)
            node.look()
        node.end(interrupts.signal, executor)
    executor.shutdown()
