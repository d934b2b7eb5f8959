"""Options that several commands share, and the files that they name."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bt_mission.base.dds.discovery import isolate, restrict_discovery
from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.file_kinds import RECORDINGS, RUNS
from bt_mission.base.files import look_deeper, look_for, other_suffix
from bt_mission.base.nature import PROFILES, Nature
from bt_mission.base.output import write_file
from bt_mission.cli.argument_types import above_zero, assignment, input_file, seconds, whole
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.language.mission import NodeFactory
    from bt_mission.language.permissions import PythonUse

_OF_ITS_GRAPH = "an attached run uses that of its graph"

MISSION = Option(
    "file",
    "a mission, scenario or fleet: a YAML file, an XML file of Groot 2, or the name of a shipped "
    "one",
    input_file,
    completes="runs",
    takes=RUNS,
)
SET = Option(
    "--set NAME=VALUE",
    "set an input of the mission; may be repeated",
    assignment,
    repeats=True,
    completes="inputs",
)
SEED = Option("--seed SEED", "seed of all random numbers in the run", whole)
WORLD = Option(
    "--world WORLD",
    "name or file of a world; replaces the mission's",
    completes="worlds",
    takes=("world",),
    excludes=each("attach", why=_OF_ITS_GRAPH),
)
ROBOT = Option(
    "--robot ROBOT",
    "name or file of a robot; replaces the mission's",
    completes="robots",
    takes=("robot",),
    excludes=each("attach", why=_OF_ITS_GRAPH),
    not_for=each("fleet", why="write it into the fleet's file"),
)
OVERRIDES = (
    SET.but(
        help="set an input of the mission; in a fleet, of every mission that has the input, or "
        "of one robot: ROBOT.NAME=VALUE; may be repeated"
    ),
    SEED,
    WORLD,
    ROBOT,
)
SIMULATOR = Option(
    "--simulator PACKAGE:CLASS",
    "what moves the robot in place of MuJoCo: a Python class, such as sim.ir_sim:IrSim, or "
    "FILE.py:CLASS",
    page="another-simulator",
)
REQUIRE = Option(
    "--require FILE",
    "a YAML file with more requirements, or a mission with some; may be repeated",
    input_file,
    repeats=True,
    takes=("requirements", "mission"),
)
FAULT = Option(
    "--fault FAULT",
    "inject a fault into the simulation, such as 'at 5.0: drop scan lasting 2'; may be repeated",
    repeats=True,
    page="scenarios",
    excludes=each("attach", why="faults are injected into a simulation, not into a running graph"),
)
NO_PYTHON = Option(
    "--no-python",
    "refuse a mission with Python leaves or nodes, which run its author's code with your "
    "permissions",
)
SPEED = Option("--speed SPEED", "simulated seconds per second", above_zero)
AT = Option("--at S", "", seconds)
PLAIN = Option("--plain", "print plain lines, even to a terminal")
JSON = Option("--json", "print one JSON object at the end")
FORCE = Option("--force", "overwrite existing files")
RECORDING = Option("file", "a recording of `bt-mission run --record`", input_file, takes=RECORDINGS)
IMAGES = Option("--images IMAGES", "", Path, Path("images"), completes="folders")

NETWORK = Option(
    "--network",
    "discover processes on other machines, and be discovered by them (default: as "
    "ROS_AUTOMATIC_DISCOVERY_RANGE says; if it is not set, this machine only)",
)
ALLOW_DUPLICATES = Option(
    "--allow-duplicates",
    "continue even if several nodes publish the same odometry or /clock, or serve the same action",
)
EDITABLE = Option(
    "--editable",
    "take new versions of the running mission from `bt-mission revise`",
    page="change-while-it-drives",
)
NAMESPACE = Option(
    "--namespace NAMESPACE", "namespace of the robot's topics", default="", completes="namespaces"
)
WALL_CLOCK = Option("--wall-clock", "use this machine's clock without waiting for /clock")


CMD_VEL_TYPE = Option(
    "--cmd-vel-type",
    "type of cmd_vel: TwistStamped (default) or Twist",
    choices=("stamped", "plain"),
    default="stamped",
)


def nature_option(default: str) -> Option:
    """Return the choice of a profile of nature; `default` is the one without it."""
    return Option(
        "--nature",
        "random differences between runs, drawn from the seed: start, localization, wheels, "
        f"lidar, latency (default: as the mission, scenario or world says, else {default})",
        choices=PROFILES,
        page="nature",
        excludes=each("attach", why=_OF_ITS_GRAPH),
    )


def nature_of(options: argparse.Namespace) -> Nature | None:
    """Return the nature that the options name; None where they do not."""
    return None if options.nature is None else Nature(options.nature)


def simulator_of(options: argparse.Namespace) -> NodeFactory | None:
    """Return the simulator that the options name; None where they do not.

    Raises:
        InputError: It does not exist, or Python code is refused.
    """
    target = getattr(options, "simulator", None)
    if target is None:
        return None
    import json

    from bt_mission.base.yaml.document import read_text
    from bt_mission.language.checks.python_code import factory_diagnostics
    from bt_mission.language.mission import NodeFactory
    from bt_mission.language.permissions import Permissions

    factory = NodeFactory(target, read_text(json.dumps(target), "--simulator"), ())
    python: PythonUse = "refuse" if options.no_python else "import"
    mistakes = [*factory_diagnostics([factory], Permissions(python=python))]
    if mistakes:
        raise InputError(mistakes)
    return factory


def recorded_robot(default: str) -> Option:
    """Return the choice of a robot of a recorded fleet; `default` describes what it is without."""
    return Option(
        "--robot NAME",
        f"the robot, if a fleet was recorded (default: {default})",
        completes="robots",
    )


def prepare_graph(options: argparse.Namespace) -> None:
    """Make ready for rclpy, and say who is found, unless the environment decides that.

    Raises:
        BtMissionError: For an invalid middleware or domain.
    """
    notice = restrict_discovery(network=options.network)
    if getattr(options, "visible", False):
        isolate(visible=True, network=options.network)
    prepare_middleware()
    if notice is not None:
        print(notice, file=sys.stderr, flush=True)


def announce(what: str) -> None:
    """Say to people at a terminal what begins, before the imports and ROS take their seconds."""
    if sys.stderr.isatty():
        print(f"{what} ...", file=sys.stderr, flush=True)


def confirm(what: str, question: str, *, otherwise: str, refused: str) -> None:
    """Ask the person at the terminal; anything but a yes is a no.

    Args:
        what: The reason to ask.
        question: Follows it.
        otherwise: What to do where there is no terminal.
        refused: What has not happened after a no.

    Raises:
        BtMissionError: After a no, or without a terminal.
    """
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        raise BtMissionError(f"{what}{otherwise}", code="BT-1104")
    print(f"{what}{question} [y/N] ", end="", file=sys.stderr, flush=True)
    if sys.stdin.readline().strip().lower() not in ("y", "yes"):
        raise BtMissionError(refused, code="BT-1104")


def write_output(path: Path, content: bytes) -> None:
    """Write a file that the options name, and say so.

    Raises:
        BtMissionError: When it cannot be written.
    """
    write_file(path, content)
    print(f"{path}: written")


def mission_file(options: argparse.Namespace) -> Path:
    """The file that the options name, by its path or by the name of a mission.

    The name of a scenario or a fleet will do, as the list of missions has them.

    Raises:
        InputError: For an unknown mission, or the name of a project from outside of it.
    """
    path = known_mission_file(options)
    if path is None:
        from bt_mission.base.file_index import find_listed

        path = find_listed("missions", str(options.file)).path
    return path


def known_mission_file(options: argparse.Namespace) -> Path | None:
    """The file that :func:`mission_file` gives, without reading any to say what was meant.

    Raises:
        InputError: For the name of a project from outside of it.
    """
    path: Path = options.file
    is_name = not path.suffix and len(path.parts) == 1
    if path.exists() and not (is_name and path.is_dir()):
        return path
    if not is_name:
        existing = look_for("missions", path)
        hint = None if existing else other_suffix("missions", path)
        if hint is not None:
            raise InputError([Diagnostic("BT-101", "no such file", str(path), hint=hint)])
        return existing or path
    if (path / "missions").is_dir():
        message = f"expected a mission, got a folder; run the command in it: cd {path}"
        raise InputError([Diagnostic("BT-111", message, str(path))])
    return look_for("missions", path) or look_deeper("missions", str(path))
