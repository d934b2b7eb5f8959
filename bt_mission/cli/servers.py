"""``bt-mission servers``: the action servers alone, as an ordinary ROS node."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.files import find


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "servers",
        help="run the action servers alone, as a ROS node",
        description="Offers driving, turning, pictures, colours, distances, exploration, and "
        "Nav2's navigation and recoveries as actions ('bt-mission actions list' names them), and "
        "the services /stop and /release, for a robot, simulated or real, that it knows by its "
        "topics alone.",
    )
    parser.add_argument("--robot", default="waffle", help="a robot's name or file")
    parser.add_argument("--namespace", default="", help="namespace of the robot's topics")
    parser.add_argument(
        "--images", type=Path, default=Path("images"), help="where pictures are written"
    )
    parser.add_argument(
        "--wall-clock",
        action="store_true",
        help="keep to this machine's clock instead of /clock, as with a real robot",
    )
    parser.add_argument(
        "--real",
        action="store_true",
        help="serve a real robot: this machine's clock, and commands of the type it listens for",
    )
    parser.add_argument(
        "--params",
        metavar="FILE",
        help="values of parameters: a ROS parameter file, or the name of a shipped one",
    )
    parser.set_defaults(command=servers)


def servers(options: argparse.Namespace) -> int:
    """Serve until interrupted."""
    prepare_middleware()
    from action_servers.server.node import main

    return main(
        robot=options.robot,
        namespace=options.namespace,
        image_folder=options.images,
        use_sim_time=not (options.wall_clock or options.real),
        command_type="auto" if options.real else "stamped",
        parameters=find("parameters", options.params) if options.params else None,
    )
