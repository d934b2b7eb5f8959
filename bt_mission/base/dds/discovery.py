"""The processes that discover each other: those of this machine by default."""

from __future__ import annotations

import os

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
NETWORK, MACHINE, PROCESS = "SUBNET", "LOCALHOST", "OFF"
"""Values of the variable: any machine of the network, this machine, this process."""


def isolate(*, visible: bool, network: bool = False) -> None:
    """Keep the ROS contexts made from now on to this process.

    A simulated run publishes the robot's own topics and commands: on the network it would drive
    any robot there, and two runs at once would hear each other.

    Args:
        visible: Let this machine's processes find them.
        network: With `visible`, let other machines find them, too.
    """
    os.environ[RANGE] = (NETWORK if network else MACHINE) if visible else PROCESS


def is_isolated() -> bool:
    """Return whether no other process discovers the ROS contexts of this one."""
    return os.environ.get(RANGE) == PROCESS


def restrict_discovery(*, network: bool) -> str | None:
    """Limit the ROS contexts made from now on to this machine, unless the variable is set.

    Args:
        network: Let all machines of the network discover them, whatever the variable.

    Returns:
        The range from now on, as text; None if only the variable decides.
    """
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    if network:
        os.environ[RANGE] = NETWORK
        return f"ROS domain {domain}, all machines of the network (--network)"
    if os.environ.get(RANGE):
        return None
    os.environ[RANGE] = MACHINE
    return f"ROS domain {domain}, this machine only; --network includes other machines"
