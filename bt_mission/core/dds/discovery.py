"""Who may hear a simulated run: nobody outside its process, unless that is asked for."""

from __future__ import annotations

import os

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"


def isolate(*, visible: bool) -> None:
    """Keep the ROS contexts made from now on to this process, or to this machine where visible.

    A simulated run publishes the robot's own topics and commands: on the network it would drive
    any robot there, and two runs at once would hear each other.
    """
    os.environ[RANGE] = "LOCALHOST" if visible else "OFF"
