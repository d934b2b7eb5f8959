"""The ROS middleware that the environment names."""

from __future__ import annotations

import os
from pathlib import Path

from bt_mission.base.dds.discovery import MACHINE, RANGE
from bt_mission.base.errors import BtMissionError

FAST_DDS = Path(__file__).resolve().parent / "fast_dds.xml"
LOOPBACK = FAST_DDS.with_name("fast_dds_loopback.xml")
ALONE = FAST_DDS.with_name("fast_dds_alone.xml")

LAST_DOMAIN = 232
"""Beyond it the ports of DDS would be beyond 65535."""


PROFILES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
"""Variables with the settings of Fast DDS."""


def prepare_middleware(*, alone: bool = False) -> None:
    """Make ready for rclpy, with settings of Fast DDS for processes that are killed.

    The file says which, and why. Where only this machine is to find the process, its sockets are
    bound to the loopback interface. Settings of the user's own stay.

    Args:
        alone: No other process is ever to find this one, so it listens on no port.

    Raises:
        BtMissionError: It cannot be loaded, or the domain id is invalid.
    """
    refuse_absent_middleware()
    ours = ("", str(FAST_DDS), str(LOOPBACK), str(ALONE))
    if all(os.environ.get(name, "") in ours for name in PROFILES):
        is_local = os.environ.get(RANGE) == MACHINE and not os.environ.get("ROS_STATIC_PEERS")
        file = ALONE if alone else LOOPBACK if is_local else FAST_DDS
        os.environ[PROFILES[0]] = str(file)


def refuse_absent_middleware() -> None:
    """Check the ROS middleware that the environment names; without it rclpy ends the process.

    Raises:
        BtMissionError: It cannot be loaded, or the domain id is invalid.
    """
    domain = os.environ.get("ROS_DOMAIN_ID", "0") or "0"
    if not domain.isdecimal() or int(domain) > LAST_DOMAIN:
        raise BtMissionError(
            f"ROS_DOMAIN_ID: expected 0 to {LAST_DOMAIN}, got '{domain}'", code="BT-911"
        )
    name = os.environ.get("RMW_IMPLEMENTATION")
    if not name:
        return
    import ctypes  # noqa: PLC0415 - rarely needed

    try:
        ctypes.CDLL(f"lib{name}.so")
    except OSError as error:
        raise BtMissionError(
            f"RMW_IMPLEMENTATION={name} cannot be loaded ({error}); unset it, or install {name}",
            code="BT-911",
        ) from error
