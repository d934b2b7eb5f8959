"""The virtual clock: real rclpy nodes under a time that moves only when they are quiet.

- ``executor``: :class:`VirtualTimeExecutor`, order and time
- ``spin``: rclpy's ways to spin, and what keeps time from moving
- ``node_clocks``: the ROS clocks of the nodes, right or wrong
- ``discovery``: are all endpoints of the process matched?
- ``self_test``: :func:`self_test`, the proof that "nothing ready" is the truth on this machine
"""

from bt_mission.ros.executors.taps import (
    ACTION_PARTS,
    Delivery,
    Gate,
    Passing,
    ServiceResponse,
    Side,
    Tap,
    Taps,
)
from bt_mission.ros.virtual_time.discovery import DiscoveryError
from bt_mission.ros.virtual_time.executor import SteppedWorld, VirtualTimeExecutor
from bt_mission.ros.virtual_time.self_test import NoVirtualTimeError, self_test
from bt_mission.ros.virtual_time.spin import NestedStepError, NothingDueError, TimeStuckError

__all__ = [
    "ACTION_PARTS",
    "Delivery",
    "DiscoveryError",
    "Gate",
    "NestedStepError",
    "NoVirtualTimeError",
    "NothingDueError",
    "Passing",
    "ServiceResponse",
    "Side",
    "SteppedWorld",
    "Tap",
    "Taps",
    "TimeStuckError",
    "VirtualTimeExecutor",
    "self_test",
]
