"""``bt-mission mapper``: a map of what the lidar sees, as an ordinary ROS node."""

from __future__ import annotations

import argparse
from typing import Any

from bt_mission.core.dds.middleware import prepare_middleware


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "mapper",
        help="map what the lidar sees, as a ROS node",
        description="Publishes map and coverage while the robot moves, out of scan, odom and the "
        "transform from map to odom, which something else has to know. The service save_map "
        "writes the map as Nav2's map server reads it.",
    )
    parser.add_argument("--robot", default="waffle", help="a robot's name or file")
    parser.add_argument("--namespace", default="", help="namespace of the robot's topics")
    parser.add_argument(
        "--save-as", default="map", metavar="PREFIX", help="where save_map writes (default: map)"
    )
    parser.add_argument(
        "--params", metavar="FILE", help="values of parameters: a ROS parameter file"
    )
    parser.add_argument(
        "--wall-clock",
        action="store_true",
        help="keep to this machine's clock instead of /clock, as with a real robot",
    )
    parser.set_defaults(command=mapper)


def mapper(options: argparse.Namespace) -> int:
    """Map until interrupted."""
    prepare_middleware()
    from action_servers.mapping.node import main
    from bt_mission.core.files import find

    return main(
        robot=options.robot,
        namespace=options.namespace,
        use_sim_time=not options.wall_clock,
        map_prefix=options.save_as,
        parameters=find("parameters", options.params) if options.params else None,
    )
