"""The ROS middleware that the environment names."""

from __future__ import annotations

import ctypes
import os

from bt_mission.common.errors import BtMissionError


def refuse_absent_middleware() -> None:
    """Look for the ROS middleware that the environment names; without it rclpy ends the process.

    :raises BtMissionError: when it cannot be loaded.
    """
    name = os.environ.get("RMW_IMPLEMENTATION")
    if not name:
        return
    try:
        ctypes.CDLL(f"lib{name}.so")
    except OSError as error:
        raise BtMissionError(
            f"RMW_IMPLEMENTATION={name} cannot be loaded ({error}); unset it, or install {name}"
        ) from error
