"""The virtual clock: real rclpy nodes, on a time that waits for them.

- ``executor``: :class:`LockstepExecutor`, order and time
- ``entities``: what a node can be woken by, and which of it is ready
- ``serving``: one callback of each kind
- ``matching``: are all endpoints of the process matched?
- ``proof``: :func:`self_test`, the proof that "nothing ready" is the truth on this machine
"""

from bt_mission.lockstep.executor import (
    LockstepExecutor,
    NothingDueError,
    TimeStuckError,
    World,
)
from bt_mission.lockstep.matching import DiscoveryError
from bt_mission.lockstep.proof import NotLockstepError, self_test

__all__ = [
    "DiscoveryError",
    "LockstepExecutor",
    "NotLockstepError",
    "NothingDueError",
    "TimeStuckError",
    "World",
    "self_test",
]
