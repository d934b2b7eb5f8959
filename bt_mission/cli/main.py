"""The parser of the whole command line, and what becomes of errors."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from bt_mission.cli import arbiter, check, doctor, mapper, run, servers, sim
from bt_mission.cli.exits import BAD_INPUT, INTERRUPTED
from bt_mission.common.errors import BtMissionError

COMMANDS = (run, check, sim, servers, mapper, arbiter, doctor)

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
