"""The common part of the nodes of a robot: options, parameters, and the process around a node."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

import rclpy
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.executors import Executor
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from bt_mission.base.diagnostics import InputError, did_you_mean
from bt_mission.base.errors import BtMissionError, cause_of
from bt_mission.base.interrupts import InterruptSignals
from bt_mission.base.parameters import ParameterSpec, specs
from bt_mission.base.ros_log import log_of
from bt_mission.ros.executors.clock_messages import ValidClock
from bt_mission.ros.executors.live import LiveExecutor
from bt_mission.ros.executors.parameter_file import ParameterFile, read_parameters

D = TypeVar("D", bound=Any)
N = TypeVar("N", bound="RobotNode")
Options = TypeVar("Options", bound="RobotNodeOptions")

SIM_TIME = "use_sim_time"

LOOK_S = 0.1
"""The longest time between two checks for a signal, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotNodeOptions:
    """How a node joins the graph.

    Args:
        context: The rclpy context; None is the default one.
        namespace: The namespace of all its relative names.
        use_sim_time: Follow `/clock`.
        lean: No parameter services, log topic or type description, and only warnings in the log,
            as on the stage.
        has_parameters: Parameter services even if `lean`, for viewers.
        parameters: Values of parameters by name that replace their defaults. The process's ROS
            arguments come first.
    """

    context: Context | None = None
    namespace: str | None = None
    use_sim_time: bool = False
    lean: bool = False
    has_parameters: bool = False
    parameters: Mapping[str, Any] = field(default_factory=dict)


class RobotNode(ValidClock, Node):
    """A node made with our options, whose parameters are declared by their specs."""

    def __init__(self, name: str, options: RobotNodeOptions) -> None:
        super().__init__(
            name,
            context=options.context,
            namespace=options.namespace,
            enable_rosout=not options.lean,
            start_parameter_services=not options.lean or options.has_parameters,
            parameter_overrides=[
                Parameter(name, value=value)
                for name, value, is_set in (
                    (SIM_TIME, True, options.use_sim_time),
                    ("start_type_description_service", False, options.lean),
                )
                if is_set
            ],
        )
        # The ROS arguments of the process override the options.
        for key, value in options.parameters.items():
            self._parameter_overrides.setdefault(key, Parameter(key, value=value))
        self._texts: dict[str, ParameterSpec] = {}
        self.add_on_set_parameters_callback(self._check_texts)
        self._log = log_of(self)
        if options.lean:
            self._log.set_level(LoggingSeverity.WARN)

    def declare(self, name: str, spec: ParameterSpec) -> Any:
        """Declare a parameter. Return its value.

        Raises:
            rclpy.exceptions.ParameterException: An override has another type, is out of range or is
                not among the choices.
        """
        value = self.declare_parameter(name, spec.default, _descriptor(spec)).value
        why = spec.why_invalid(name, value) if isinstance(spec.default, str) else None
        if why is not None:
            raise InvalidParameterValueException(name, value, why)
        if isinstance(spec.default, str):
            self._texts[name] = spec
        return value

    def declare_all(self, defaults: D) -> D:
        """Declare the parameters of a dataclass, with its values as defaults; return their values.

        Parameters that are declared keep their values. Raises as `declare`.
        """
        for attribute, (name, spec) in specs(defaults).items():
            if not self.has_parameter(name):
                self.declare(name, replace(spec, default=getattr(defaults, attribute)))
        return self.read_all(defaults)

    def read_all(self, defaults: D) -> D:
        """Return the present values of the parameters of a dataclass, which are declared."""
        values = {
            attribute: self.get_parameter(name).value
            for attribute, (name, _) in specs(defaults).items()
        }
        return replace(defaults, **values)

    def set_parameters(self, parameter_list: list[Parameter]) -> list[SetParametersResult]:
        """Set each parameter. The error of a fixed parameter names the way to change it."""
        results = Node.set_parameters(self, parameter_list)
        for parameter, result in zip(parameter_list, results, strict=True):
            self._explain([parameter], result)
        return results

    def set_parameters_atomically(self, parameter_list: list[Parameter]) -> SetParametersResult:
        """Set all parameters or none. The error of a fixed parameter names the way to change it."""
        result = Node.set_parameters_atomically(self, parameter_list)
        self._explain(parameter_list, result)
        return result

    def _explain(self, parameters: Sequence[Parameter], result: SetParametersResult) -> None:
        fixed = [parameter for parameter in parameters if self._is_fixed(parameter.name)]
        if not result.successful and fixed:
            result.reason = (
                f"{fixed[0].name} is read only when the node starts; restart it with "
                f"--ros-args -p {fixed[0].name}:={fixed[0].value}"
            )

    def _is_fixed(self, name: str) -> bool:
        return self.has_parameter(name) and self.describe_parameter(name).read_only

    def _check_texts(self, parameters: Sequence[Parameter]) -> SetParametersResult:
        """Refuse a text that is not among the choices. ROS checks only numbers."""
        reasons = (
            self._texts[parameter.name].why_invalid(parameter.name, parameter.value)
            for parameter in parameters
            if parameter.name in self._texts and isinstance(parameter.value, str)
        )
        why = next(filter(None, reasons), None)
        return SetParametersResult(successful=why is None, reason=why or "")

    def warn_of_unknown(self) -> None:
        """Warn of values for parameters that do not exist."""
        unknown = [name for name in self._parameter_overrides if not self.has_parameter(name)]
        for name in unknown:
            hint = did_you_mean(name, sorted(self.list_parameters([], 0).names))
            self._log.warning(f"no such parameter '{name}': ignored{f'; {hint}' if hint else ''}")

    @property
    def is_done(self) -> bool:
        """Whether the node has ended without a signal."""
        return False

    def refuse_conflicts(self, executor: Executor) -> None:
        """Look whether another process does the same.

        Raises:
            BtMissionError: One does, with its node.
        """

    def begin(self) -> None:
        """Begin as a process."""

    def look(self) -> None:
        """Look after the node, after each callback."""

    def destroy_node(self) -> None:
        """Leave the graph."""
        Node.destroy_node(self)

    def end(self, signal: str, executor: Executor) -> None:
        """End in an orderly way after the signal of that name; empty without a signal."""


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
    """Make a node with the values of a file. Each value must be known to it and in range.

    Raises:
        InputError: With the place of the error in the file.
        BtMissionError: Another value is invalid, such as a ROS argument.
    """
    values = {} if file is None else file.values
    try:
        node = make(replace(options, parameters=values))
    except (InvalidParameterTypeException, InvalidParameterValueException) as error:
        raise _refused(file, error) from error
    try:
        if file is not None:
            file.refuse_unknown(node.list_parameters([], 0).names)
    except InputError:
        node.destroy_node()
        raise
    return node


def _refused(file: ParameterFile | None, error: Exception) -> BtMissionError:
    text = str(error)
    names = () if file is None else file.values
    name = next((name for name in names if text.endswith(f": {name}")), None)
    if file is None or name is None:
        return BtMissionError(text, code="BT-806")
    value = file.values[name]
    is_whole = isinstance(value, int) and "DOUBLE" in text
    hint = f"write {value}.0" if is_whole else None
    return InputError([file.diagnostic(name, text.removesuffix(f": {name}"), hint)])


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessOptions:
    """The options of a node's process.

    Args:
        parameters: A ROS parameter file, read with its places.
        ros_args: The arguments after `--ros-args`: remappings, parameters, the level of the log.
    """

    parameters: Path | None = None
    ros_args: Sequence[str] = ()


NAMESPACE = "__ns:="
"""The remapping of a node's namespace in ROS arguments."""

NO_ARGUMENTS = ProcessOptions()


def run(
    name: str, process: ProcessOptions, options: Options, make: Callable[[Options], RobotNode]
) -> int:
    """Make a node and serve it until SIGINT or SIGTERM. The second signal ends it at once.

    Args:
        name: The node's name, which is also its section in a parameter file.
        process: Its parameter file and ROS arguments.
        options: The options of the node, besides the values of the file.
        make: Makes the node.

    Returns:
        The exit code 0.

    Raises:
        BtMissionError: A file cannot be used.
    """
    namespace = next(
        (arg.partition(NAMESPACE)[2] for arg in process.ros_args if NAMESPACE in arg), ""
    )
    path = process.parameters
    file = None if path is None else read_parameters(path, name, namespace)
    has_sim_time = file.values.get(SIM_TIME) if file else None
    simulated = options.use_sim_time if has_sim_time is None else has_sim_time
    # First, so that the user's arguments, which follow, take precedence.
    args = ["--ros-args", "-p", f"{SIM_TIME}:={str(simulated).lower()}", *process.ros_args]
    options = replace(options, use_sim_time=False)
    # rclpy's handlers would destroy the publishers before the robot is stopped.
    rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    try:
        # From before the node is made: a signal while it begins ends it in order, too.
        with InterruptSignals(most=1) as interrupts:
            node = made_with(file, options, make)
            node.warn_of_unknown()
            try:
                _serve(node, interrupts)
            finally:
                node.destroy_node()
    finally:
        rclpy.try_shutdown()
    return 0


def _serve(node: RobotNode, interrupts: InterruptSignals) -> None:
    executor = LiveExecutor()
    executor.add_node(node)
    node.refuse_conflicts(executor)
    node.begin()
    try:
        while not (interrupts.count or node.is_done):
            executor.spin_once(timeout_sec=LOOK_S)
            node.look()
    except Exception as error:
        node.end(cause_of(error), executor)
        raise
    node.end(interrupts.signal, executor)
    executor.shutdown()
