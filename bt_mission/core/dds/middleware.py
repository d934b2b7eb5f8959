"""The ROS middleware that the environment names."""

from __future__ import annotations

import ctypes
import os
from pathlib import Path

from bt_mission.core.errors import BtMissionError

FAST_DDS = Path(__file__).resolve().parent / "fast_dds.xml"

LAST_DOMAIN = 232
"""Beyond it the ports of DDS would be beyond 65535."""


PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Variables by which Fast DDS is told of settings."""


def prepare_middleware() -> None:
    """Make ready for rclpy, with settings of Fast DDS for processes that die without a word.

    The file says which, and why. Settings of the user's own stay. The middleware that the
    environment names is looked for: without it rclpy ends the process.

    Raises:
        BtMissionError: When it cannot be loaded, or the domain id is none.
    """
    if not any(os.environ.get(name) for name in PROFILES):
        os.environ[PROFILES[0]] = str(FAST_DDS)
    domain = os.environ.get("ROS_DOMAIN_ID", "0") or "0"
    if not domain.isdecimal() or int(domain) > LAST_DOMAIN:
        raise BtMissionError(f"ROS_DOMAIN_ID: expected 0 to {LAST_DOMAIN}, got '{domain}'")
    name = os.environ.get("RMW_IMPLEMENTATION")
    if not name:
        return
    try:
        ctypes.CDLL(f"lib{name}.so")
    except OSError as error:
        raise BtMissionError(
            f"RMW_IMPLEMENTATION={name} cannot be loaded ({error}); unset it, or install {name}"
        ) from error
