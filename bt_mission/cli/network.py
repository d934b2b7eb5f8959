"""The part of a command in the ROS graph: with this machine's processes, or the network's."""

from __future__ import annotations

import argparse
import sys

from bt_mission.cli.parser import Option
from bt_mission.core.dds.discovery import isolate, restrict_discovery
from bt_mission.core.dds.middleware import prepare_middleware

NETWORK = Option(
    "--network",
    "find processes of other machines, and be found by them (default: what "
    "ROS_AUTOMATIC_DISCOVERY_RANGE says; where it is not set, this machine alone)",
)
ALLOW_DUPLICATES = Option(
    "--allow-duplicates",
    "go on although several nodes publish the same odometry or /clock",
)
NAMESPACE = Option(
    "--namespace NAMESPACE", "namespace of the robot's topics", default="", completes="namespaces"
)
WALL_CLOCK = Option(
    "--wall-clock", "keep to this machine's clock, without looking for /clock first"
)


def prepare_graph(options: argparse.Namespace) -> None:
    """Make ready for rclpy, and say who is found, unless the environment decides that.

    Raises:
        BtMissionError: For a middleware or a domain that is none.
    """
    said = restrict_discovery(network=options.network)
    if getattr(options, "visible", False):
        isolate(visible=True, network=options.network)
    prepare_middleware()
    if said is not None:
        print(said, file=sys.stderr, flush=True)
