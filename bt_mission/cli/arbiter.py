"""``bt-mission arbiter``: several sources of commands in front of one base, in order of rank."""

from __future__ import annotations

import argparse
from typing import Any

from bt_mission.core.dds.middleware import prepare_middleware
from bt_mission.core.files import find


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "arbiter",
        help="let stop, joystick and missions drive one base, in this order",
        description="Stands between several topics of commands and cmd_vel: cmd_vel_stop over "
        "cmd_vel_joy over cmd_vel_mission (all TwistStamped). A source that falls silent counts "
        "no longer, and the base is told to stand while nobody speaks. Have the servers send to "
        "cmd_vel_mission: a parameter file with topics.cmd_vel.",
    )
    parser.add_argument("--namespace", default="", help="namespace of the robot's topics")
    parser.add_argument(
        "--wall-clock",
        action="store_true",
        help="keep to this machine's clock instead of /clock",
    )
    parser.add_argument(
        "--real",
        action="store_true",
        help="drive a real robot: this machine's clock, and the type of command it listens for",
    )
    parser.add_argument(
        "--params", metavar="FILE", help="values of parameters: a ROS parameter file"
    )
    parser.set_defaults(command=arbiter)


def arbiter(options: argparse.Namespace) -> int:
    """Arbitrate until interrupted."""
    prepare_middleware()
    from action_servers.arbiter.node import main

    return main(
        namespace=options.namespace,
        use_sim_time=not (options.wall_clock or options.real),
        command_type="auto" if options.real else "stamped",
        parameters=find("parameters", options.params) if options.params else None,
    )
