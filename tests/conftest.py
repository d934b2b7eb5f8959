"""Isolation of the test session: its own DDS domain, no discovery, no logs in the home folder."""

import os
import tempfile
from pathlib import Path

# Domain ids above 101 reach into Linux' range of ephemeral ports.
_DOMAINS = 101


def _domain_id(environ: dict[str, str], pid: int, parent: int) -> int:
    """A DDS domain id of this process alone: a base of the session, plus the xdist worker's number.

    The base is ROS_DOMAIN_ID where it is set, and else the id of the session's first process, so
    that two sessions on one machine are likely to be apart.
    """
    worker = environ.get("PYTEST_XDIST_WORKER", "")
    number = int(worker.removeprefix("gw")) if worker else 0
    base = int(environ.get("BT_MISSION_TEST_DOMAIN") or environ.get("ROS_DOMAIN_ID") or 0)
    if not base:
        base = parent if worker else pid
    return 1 + (base + number) % _DOMAINS


# Before any test module imports rclpy. Within a process DDS works with discovery off; a test with
# processes of its own hands them ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST.
os.environ["ROS_DOMAIN_ID"] = str(_domain_id(dict(os.environ), os.getpid(), os.getppid()))
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "OFF"
os.environ["ROS_LOG_DIR"] = str(Path(tempfile.gettempdir()) / "bt_mission_test_logs")
