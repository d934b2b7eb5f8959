"""``bt-mission doctor``: what is missing on this machine."""

from __future__ import annotations

import argparse
from typing import Any


def add_parser(commands: Any) -> None:
    """Add the command to the command line."""
    parser = commands.add_parser(
        "doctor",
        help="check this machine and say what to install",
        description="Checks Python, ROS 2, our message types, off-screen rendering, DDS on "
        "loopback and the virtual clock, and says what to install where something is missing.",
    )
    parser.set_defaults(command=doctor)


def doctor(_: argparse.Namespace) -> int:
    """Run all checks; 0 when everything needed is there."""
    from rich.console import Console

    from bt_mission.cli.doctor_report import run

    return run(Console())
