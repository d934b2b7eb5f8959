"""``bt-mission reproduce``: a recording as a scenario that repeats its run in the simulation."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from bt_mission.base.file_kinds import RECORDINGS
from bt_mission.base.text import escape_control
from bt_mission.cli.argument_types import count, input_file, whole
from bt_mission.cli.exits import MISSION_FAILED, SUCCESS
from bt_mission.cli.options import FORCE, JSON, REQUIRE, announce
from bt_mission.cli.outputs import refuse_used_folder
from bt_mission.cli.parser import Command, Option

EPILOG = """\
examples:
  bt-mission reproduce bad_day.mcap -o case/         world, mission, faults, scenario and test
  bt-mission reproduce drive_0.mcap drive_1.mcap --require site.yaml -o case/
  bt-mission reproduce rosbag2_folder/ --topic scan:=/front/scan --robot burger -o case/
  bt-mission run case/bad_day.scenario.yaml          repeats the run

exit codes: 0 the simulated run ends as the recorded one: the same outcome, and the same
requirements violated; 1 it ends in another way; 2 bad input
"""


def reproduce(options: argparse.Namespace) -> int:
    """Reproduce the run; gives the exit code."""
    refuse_used_folder(options.output, is_forced=options.force)
    announce(f"reading {options.recordings[0]}")
    from bt_mission.base.dds.middleware import prepare_middleware

    prepare_middleware()
    from bt_mission.commands.reproduce.session import ReproduceOptions, summary_lines
    from bt_mission.commands.reproduce.session import reproduce as reproduced
    from bt_mission.scenarios.runner import silence_logs

    silence_logs()
    result = reproduced(
        options.recordings,
        options.output,
        ReproduceOptions(
            options.topic,
            options.require,
            options.violated,
            options.robot,
            options.name,
            options.budget,
            options.search_seed,
        ),
        _say,
    )
    if options.json:
        print(json.dumps(result.as_dict()))
    else:
        print("\n".join(map(escape_control, summary_lines(result))))
    return SUCCESS if result.comparison.is_repeated else MISSION_FAILED


def _say(text: str) -> None:
    if sys.stderr.isatty():
        print(text, file=sys.stderr, flush=True)


COMMANDS = {
    "reproduce": Command(
        reproduce,
        "Turns a recording into a scenario that repeats its run in the simulation. It reads "
        "recordings of bt-mission, and rosbag2 files (MCAP) of any mobile robot with a lidar. The "
        "world follows from the map and the scans, the mission from its file or from the goals "
        "that were sent, and the faults from what topics, goals and motion show. The command runs "
        "the scenario, compares both runs, and searches for what it had to guess.",
        (
            Option(
                "recordings",
                "recordings (MCAP, also .gz and .zst), or folders of rosbag2; several are parts "
                "of one run",
                input_file,
                nargs="+",
                takes=(*RECORDINGS, "bag folder"),
            ),
            Option(
                "-o --output FOLDER",
                "the folder for the files of the case (default: case)",
                Path,
                Path("case"),
                completes="folders",
            ),
            Option(
                "--topic NAME:=TOPIC",
                "the recorded topic that takes the place of scan, odom, tf, map, cmd_vel, ...; "
                "may be repeated",
                repeats=True,
            ),
            REQUIRE.but(
                help="a YAML file with more requirements, whose verdicts both runs are compared "
                "by; may be repeated"
            ),
            Option(
                "--violated REQUIREMENT",
                "a requirement that is known to be violated, although the recording cannot show "
                "it; may be repeated",
                repeats=True,
            ),
            Option(
                "--robot ROBOT",
                "name or file of the robot's model (default: that of the recording, else waffle)",
                completes="robots",
                takes=("robot",),
            ),
            Option("--name NAME", "the name of the case (default: that of the recording)"),
            Option("--budget N", "the most simulated runs (default: 12)", count, 12),
            Option("--search-seed SEED", "the seed of the search (default: 0)", whole, 0),
            FORCE.but(help="write into a folder that is not empty"),
            JSON.but(help="print one JSON object"),
        ),
        EPILOG,
    )
}
