"""Options that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bt_mission.cli.argument_types import assignment, input_file, seed
from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.core.files import look_deeper, look_for, other_suffix
from bt_mission.core.nature import PROFILES, Nature
from bt_mission.core.output import write_file


def add_overrides(parser: argparse.ArgumentParser) -> None:
    """What may be overridden in a mission."""
    add_set_option(parser)
    parser.add_argument("--seed", type=seed, help="seed of everything random in the run")
    parser.add_argument("--world", help="a world's name or file instead of the mission's")
    parser.add_argument("--robot", help="a robot's name or file instead of the mission's")


def add_mission_file(parser: argparse.ArgumentParser) -> None:
    """The mission file."""
    parser.add_argument(
        "file",
        type=input_file,
        help="the mission: a YAML file, an XML file of Groot 2, or the name of a shipped one; or a "
        "scenario or a fleet",
    )


def add_set_option(parser: argparse.ArgumentParser) -> None:
    """Inputs of the mission."""
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        type=assignment,
        help="give an input of the mission another value; may be repeated",
    )


def add_nature_option(parser: argparse.ArgumentParser, default: str) -> None:
    """Add the choice of a profile of nature; `default` says what holds without it."""
    parser.add_argument(
        "--nature",
        choices=PROFILES,
        help="what differs from run to run: start, localization, wheels, lidar, latency, drawn "
        f"from the seed (docs/reference/nature.md; default: as mission, scenario or world say, "
        f"else {default})",
    )


def nature_of(options: argparse.Namespace) -> Nature | None:
    """Return the nature that the options name; None where they do not."""
    return None if options.nature is None else Nature(options.nature)


def add_require_option(
    parser: argparse.ArgumentParser,
    text: str = "a YAML file with further requirements of the mission; may be repeated",
) -> None:
    """Add the files of requirements to a parser; `text` is their help."""
    parser.add_argument(
        "--require",
        action="append",
        default=[],
        type=input_file,
        metavar="FILE",
        help=text,
    )


def add_fault_option(parser: argparse.ArgumentParser) -> None:
    """Add faults as text to a parser."""
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="FAULT",
        help="something that goes wrong in the simulation, such as 'at 5.0: drop scan lasting 2' "
        "(docs/reference/scenarios.md); may be repeated",
    )


def add_plain_option(parser: Any) -> None:
    """Add the choice of plain lines to a parser, or to a group of options."""
    parser.add_argument(
        "--plain", action="store_true", help="plain lines, also when the output is a terminal"
    )


def add_robot_option(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the choice of a robot of a recorded fleet; `what` says what comes without it."""
    parser.add_argument("--robot", metavar="NAME", help=f"of a recorded fleet: the robot ({what})")


def add_force_option(parser: argparse.ArgumentParser) -> None:
    """Add the leave to overwrite files."""
    parser.add_argument("--force", action="store_true", help="overwrite files that exist")


def add_python_option(parser: argparse.ArgumentParser) -> None:
    """Add the refusal of the code that a mission brings."""
    parser.add_argument(
        "--no-python",
        action="store_true",
        help="refuse a mission with Python leaves or nodes: code of its author that runs as you",
    )


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
        InputError: For a name that is no mission's, or that of a project from outside of it.
    """
    found = known_mission_file(options)
    if found is None:
        from bt_mission.core.file_index import find_listed

        found = find_listed("missions", str(options.file)).path
    return found


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
        found = look_for("missions", path)
        hint = None if found else other_suffix("missions", path)
        if hint is not None:
            raise InputError([Diagnostic("no such file", str(path), hint=hint)])
        return found or path
    if (path / "missions").is_dir():
        message = f"expected a mission, got a folder; commands are called in it: cd {path}"
        raise InputError([Diagnostic(message, str(path))])
    return look_for("missions", path) or look_deeper("missions", str(path))
