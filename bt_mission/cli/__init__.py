"""The command line, ``bt-mission``. One module a command; heavy imports happen inside them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

import bt_mission.cli.check
import bt_mission.cli.doctor
import bt_mission.cli.run
import bt_mission.cli.servers
import bt_mission.cli.sim
from bt_mission.cli.exits import BAD_INPUT, INTERRUPTED
from bt_mission.common.errors import BtMissionError

COMMANDS = (
    bt_mission.cli.run,
    bt_mission.cli.check,
    bt_mission.cli.sim,
    bt_mission.cli.servers,
    bt_mission.cli.doctor,
)

EPILOG = """\
examples:
  bt-mission run missions/explore.yaml            run a mission in simulation, as fast as it goes
  bt-mission run missions/explore.yaml --speed 1  the same at the speed of the wall clock
  bt-mission check missions/explore.yaml          find every fault before anything moves
  bt-mission doctor                               is everything here that is needed?

exit codes: 0 success, 1 mission failed, 2 bad input, 130 interrupted
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; gives the exit code."""
    parser = argparse.ArgumentParser(
        prog="bt-mission",
        description="Missions in YAML, carried out as behaviour trees over ROS 2 actions.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(metavar="command", required=True)
    for command in COMMANDS:
        command.add_parser(commands)
    options = parser.parse_args(arguments)
    try:
        return int(options.command(options))
    except BtMissionError as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:
        sys.stderr.close()  # whoever read our output has left; there is nobody to tell
        return INTERRUPTED
