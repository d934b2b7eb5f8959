"""ROS arguments, as launch files append them: `--ros-args -r a:=b -p name:=value ... [--]`."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import open_file

BEGIN, END = "--ros-args", "--"
PARAMETERS = "--params-file"

EPILOG = (
    "ROS arguments can follow, as launch files append them: --ros-args -r NAME:=NAME "
    "-r __ns:=/NS -r __node:=NAME -p PARAMETER:=VALUE --params-file FILE --log-level LEVEL"
)


class RosArgumentsError(BtMissionError):
    """ROS arguments that ROS cannot read."""

    code = "BT-1101"


def split(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments of the program, and those that ROS reads, without their marks."""
    mine: list[str] = []
    for_ros: list[str] = []
    is_ros = False
    for argument in arguments:
        if argument == BEGIN:
            is_ros = True
        elif is_ros and argument == END:
            is_ros = False
        else:
            (for_ros if is_ros else mine).append(argument)
    return mine, for_ros


def checked(arguments: Sequence[str]) -> tuple[str, ...]:
    """Return ROS arguments that rclpy can read.

    Raises:
        RosArgumentsError: With rclpy's reason, or that of a file of parameters.
    """
    import rclpy

    for option, file in pairwise(arguments):
        if option == PARAMETERS:
            try:
                open_file(file).close()
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                raise RosArgumentsError(f"{PARAMETERS} {file}: {reason}") from error
    if arguments:
        context = rclpy.Context()
        try:
            rclpy.init(context=context, args=[BEGIN, *arguments])
        except Exception as error:  # rclpy's own have no common class that it makes public
            reason = str(error).partition(", at ")[0]
            raise RosArgumentsError(f"{BEGIN} {' '.join(arguments)}: {reason}") from error
        context.shutdown()
    return tuple(arguments)


def of_node(arguments: Sequence[str], name: str) -> tuple[str, ...]:
    """Return the arguments with `__node` and `__name` meant for the node of that name alone.

    A process with several nodes would give all of them one name.
    """
    return tuple(
        f"{name}:{argument}" if argument.startswith(("__node:=", "__name:=")) else argument
        for argument in arguments
    )
