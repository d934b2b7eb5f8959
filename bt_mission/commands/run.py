"""``bt-mission run``: run a mission."""

from __future__ import annotations

import argparse
import sys

from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import kind_of
from bt_mission.cli import recording
from bt_mission.cli.additions import show_options
from bt_mission.cli.argument_types import seconds, unchecked_output_file
from bt_mission.cli.options import (
    ALLOW_DUPLICATES,
    CMD_VEL_TYPE,
    EDITABLE,
    FAULT,
    IMAGES,
    JSON,
    MISSION,
    NAMESPACE,
    NETWORK,
    NO_PYTHON,
    OVERRIDES,
    PLAIN,
    REQUIRE,
    SIMULATOR,
    SPEED,
    WALL_CLOCK,
    announce,
    known_mission_file,
    mission_file,
    nature_option,
    prepare_graph,
)
from bt_mission.cli.parser import Command, Option, each, refuse_for_kind
from bt_mission.cli.run_plan import load_plan
from bt_mission.cli.run_shown import carry_out
from bt_mission.cli.view import VIEW
from bt_mission.cli.web import web_options

EPILOG = """\
examples:
  bt-mission run explore                        a shipped mission, as fast as possible
  bt-mission run mine.yaml --web                your own mission, in real time, in a browser
  bt-mission run explore --set legs=2 --seed 3  other inputs, other noise
  bt-mission run explore --record explore.mcap  then: bt-mission replay explore.mcap
  bt-mission run two_wanderers                  a fleet; `bt-mission missions` lists all
  bt-mission run explore --attach               against running servers and a robot

exit codes: 0 success, or the expected result of a scenario; 1 mission failed, requirement
violated, unexpected result of a scenario, or a file that was asked for is incomplete, as on a
full disk: the summary names it; 2 bad input, 130 interrupted
"""


def _what_starts(options: argparse.Namespace) -> str:
    """What is about to run and where, by a first look at the file."""
    from bt_mission.base.files import plain_words

    try:
        file = known_mission_file(options)
    except BtMissionError:  # told when the file is read
        file = None
    words = {} if file is None else plain_words(file)
    name = words.get("fleet") or words.get("scenario") or words.get("mission") or options.file
    if options.attach:
        return f"{name}: joining the ROS graph"
    world = options.world or words.get("world")
    return f"{name} in {world}: starting" if world else f"{name}: starting"


def run(options: argparse.Namespace) -> int:
    """Run the mission; gives the exit code."""
    if sys.stderr.isatty():
        announce(_what_starts(options))
    kind = kind_of(mission_file(options))
    refuse_for_kind(options, kind)
    if options.attach or options.visible or options.editable:
        prepare_graph(options)
    else:
        prepare_middleware()
    plan = load_plan(options, kind)
    return carry_out(options, plan)


_ON_A_GRAPH = (
    Option(
        "--attach",
        "run only the executive; the servers run in other processes",
        not_for={
            "scenario": "a scenario has its own simulation",
            "fleet": "a fleet has its own simulation; attach each robot's mission, with "
            "--namespace",
        },
    ),
    WALL_CLOCK.but(needs=each("attach", why="a simulation has its own clock")),
    NAMESPACE.but(
        help="namespace of the robot whose servers run the mission",
        needs=each("attach", why="it names a robot of a running graph"),
    ),
    Option(
        "--journal FILE",
        "save the state of the running mission to this file",
        unchecked_output_file,
        needs=each("attach", why="a simulation ends with its process"),
    ),
    Option(
        "--resume",
        "continue a mission where its process died",
        needs=each("journal"),
    ),
)

COMMANDS = {
    "run": Command(
        run,
        "Checks a mission, then runs it in a simulation as fast as possible, or with --attach "
        "against the action servers of a running ROS graph. Ctrl-C halts the mission and waits "
        "until every goal has ended and the robot has stopped; a second Ctrl-C exits at once.",
        (
            MISSION,
            REQUIRE,
            FAULT.but(
                help="inject a fault into the simulation, such as 'at 5.0: drop scan lasting 2'; "
                "in a fleet, for every robot, or for one: 'ROBOT: at 5.0: ...'; may be repeated"
            ),
            *OVERRIDES,
            SIMULATOR.but(
                excludes=each("attach", why="the robot is that of the graph"),
                not_for=each("fleet", why="another simulator moves one robot"),
            ),
            nature_option("none"),
            CMD_VEL_TYPE.but(excludes=each("attach", why="the robot is that of the graph")),
            NO_PYTHON,
            SPEED.but(
                help="simulated seconds per second; 1 is real time (default: as fast as possible)",
                excludes=each("attach", why="an attached run runs at the speed of its graph"),
            ),
            Option(
                "--observe SECONDS",
                "continue the simulation after the mission has ended, and evaluate its "
                "requirements for this time (default: as the file says)",
                seconds,
            ),
            Option(
                "--visible",
                "let other processes on this machine communicate with the simulated run",
                excludes=each("attach", why="an attached run is always visible"),
            ),
            EDITABLE.but(
                help="take new versions of the mission from `bt-mission revise` while it runs; a "
                "simulated run is then visible to other processes on this machine"
            ),
            Option(
                "--pause-before NODE",
                "pause the mission before this node starts, given by its name or a path such as "
                "0.1.0; may be repeated",
                repeats=True,
                needs=each(
                    "web",
                    "tui",
                    "visible",
                    "editable",
                    "attach",
                    why="nothing else can resume the mission",
                ),
                not_for=each("fleet", why="its missions have their own nodes"),
            ),
            *(option.but(group="on a running ROS graph") for option in _ON_A_GRAPH),
            NETWORK.but(
                needs=each(
                    "attach",
                    "visible",
                    "editable",
                    why="no other process communicates with this run otherwise",
                )
            ),
            ALLOW_DUPLICATES.but(needs=each("attach", why="a simulation is the only publisher")),
            JSON,
            PLAIN,
            Option(
                "--tui",
                "show the full-screen view of `bt-mission watch`, in real time unless --speed is "
                "given",
                excludes=each("json", "plain"),
            ),
            IMAGES.but(help="folder for the images of camera sweeps (default: images)"),
            VIEW,
            *web_options("tui"),
            *show_options(),
            *recording.RECORDING_OPTIONS,
        ),
        EPILOG,
        leaves_at_once=True,
    )
}
