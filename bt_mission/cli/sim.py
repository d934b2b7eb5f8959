"""``bt-mission sim``: the simulated robot alone, as an ordinary ROS node."""

from __future__ import annotations

import argparse
import os
from typing import Any

from bt_mission.cli.view import add_view_option
from bt_mission.core.dds.discovery import RANGE
from bt_mission.core.dds.middleware import prepare_middleware


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "sim",
        help="run the simulated robot alone, as a ROS node",
        description="Simulates a TurtleBot3 in a world and speaks the robot's own topics "
        "(cmd_vel, scan, odom, imu, tf, camera, ...) and /clock. Start `bt-mission servers` and "
        "`bt-mission run FILE --attach` in other terminals.",
    )
    parser.add_argument("--world", default="empty_arena", help="a world's name or file")
    who = parser.add_mutually_exclusive_group()
    who.add_argument("--robot", default="waffle", help="a robot's name or file")
    who.add_argument(
        "--robots",
        nargs="+",
        metavar="NAME=ROBOT@X,Y,YAW",
        help="several robots, each in the namespace of its name (metres, degrees)",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the sensors' noise")
    parser.add_argument(
        "--speed", type=float, default=1.0, help="simulated seconds per second (default 1)"
    )
    parser.add_argument("--namespace", default="", help="namespace of the robot's topics")
    parser.add_argument("--no-camera", action="store_true", help="never render images")
    add_view_option(parser)
    parser.set_defaults(command=sim)


def sim(options: argparse.Namespace) -> int:
    """Simulate until interrupted."""
    prepare_middleware()
    # Who starts a simulation next to a robot does not mean to drive that robot with it.
    os.environ.setdefault(RANGE, "LOCALHOST")
    from sim.ros.live import main

    return main(
        world=options.world,
        robot=options.robots or options.robot,
        seed=options.seed,
        speed=options.speed,
        namespace=options.namespace,
        camera=not options.no_camera,
        view=options.view,
    )
