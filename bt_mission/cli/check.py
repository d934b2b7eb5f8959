"""``bt-mission check``: every fault of a mission file, before anything moves."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from bt_mission.cli.exits import BAD_INPUT, SUCCESS
from bt_mission.cli.options import add_mission_options, mission_file


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "check",
        help="find every fault of a mission file",
        description="Reads a mission, checks it against the real ROS types, worlds and robots, "
        "and prints every fault with its file, line and column. Nothing moves.",
    )
    add_mission_options(parser)
    parser.set_defaults(command=check_file)


def load_checked(options: argparse.Namespace) -> Any:
    """Load the mission that the options name and check it; warnings go to standard error.

    :raises InputError: with every fault.
    """
    from bt_mission.common.located import InputError
    from bt_mission.common.robot import load_robot
    from bt_mission.mission.check import examine
    from sim.world import load_world

    mission, faults = examine(
        mission_file(options),
        set=dict(options.set),
        seed=options.seed,
        world=options.world,
        robot=options.robot,
    )
    if mission is None:
        raise InputError(faults)
    for warning in faults:
        print(warning, file=sys.stderr)
    if mission.world:
        load_world(mission.world, near=mission.file)
    load_robot(mission.robot, near=mission.file)
    return mission


def check_file(options: argparse.Namespace) -> int:
    """Print every fault, or that there is none."""
    from bt_mission.common.located import InputError

    try:
        mission = load_checked(options)
    except InputError as error:
        print(error, file=sys.stderr)
        count = len(error.faults)
        print(f"{count} error{'s' if count > 1 else ''}", file=sys.stderr)
        return BAD_INPUT
    count = sum(1 for _ in mission.tree.walk())
    nodes = "1 node" if count == 1 else f"{count} nodes"
    print(f"{mission.file}: mission '{mission.name}' is sound ({nodes})")
    return SUCCESS
