"""Settings as declared ROS parameters, and a node made with the values of a file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from action_servers.robot_io.command_types import Choice
from action_servers.robot_io.parameter_file import ParameterFile
from action_servers.robot_io.robot_settings import Setting, Wiring, applied, fault, settings
from bt_mission.core.diagnostics import InputError
from bt_mission.core.errors import BtMissionError
from bt_mission.core.robot.model import RobotModel

N = TypeVar("N", bound=Node)


def declare_wiring(
    node: Node, robot: RobotModel, command_type: Choice
) -> tuple[RobotModel, Wiring]:
    """Declare every setting on a node; return the robot within its limits, and its wiring.

    Settings are read once, when the node is made. Raises InvalidParameterValueException.
    """
    values = declare(node, settings(robot, command_type))
    return applied(robot, values, watched=command_type == "auto")


def declare(node: Node, wanted: Iterable[Setting]) -> dict[str, Any]:
    """Declare settings on a node; return their values. Raises InvalidParameterValueException."""
    return {one.name: _declared(node, one) for one in wanted}


def _declared(node: Node, setting: Setting) -> Any:
    descriptor = ParameterDescriptor(description=setting.description, read_only=True)
    if isinstance(setting.default, float):
        descriptor.floating_point_range = [
            FloatingPointRange(from_value=setting.low, to_value=setting.high)
        ]
    value = node.declare_parameter(setting.name, setting.default, descriptor).value
    wrong = fault(setting, value)
    if wrong is not None:
        raise InvalidParameterValueException(setting.name, value, wrong)
    return value


def overrides(values: Mapping[str, Any]) -> list[Parameter]:
    """Return values by name as overrides for a node that is being made."""
    return [Parameter(name, value=value) for name, value in values.items()]


def made_with(file: ParameterFile | None, make: Callable[[Mapping[str, Any]], N]) -> N:
    """Make a node with the values of a file, none of which may be unknown to it or out of range.

    Raises InputError with the place of the fault.
    """
    if file is None:
        return make({})
    try:
        node = make(file.values)
    except InvalidParameterTypeException as error:
        raise _refused(file, error) from error
    except InvalidParameterValueException as error:
        raise _refused(file, error) from error
    try:
        file.refuse_unknown(node.list_parameters([], 0).names)
    except InputError:
        node.destroy_node()  # type: ignore[no-untyped-call]
        raise
    return node


def _refused(file: ParameterFile, error: Any) -> BtMissionError:
    text = str(error)
    name = next((name for name in file.values if text.endswith(f": {name}")), None)
    if name is None:
        return BtMissionError(text)
    value = file.values[name]
    is_whole = isinstance(value, int) and "DOUBLE" in text
    hint = f"write {value}.0" if is_whole else None
    return InputError([file.fault(name, text.removesuffix(f": {name}"), hint)])
