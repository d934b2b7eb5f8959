"""The rule for files that a command reads: each is of a kind that its option takes."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bt_mission.base.file_kinds import RECORDINGS, format_of, recording_of, refuse_other_formats
from bt_mission.cli.parser import Option


def settle_inputs(options: argparse.Namespace) -> None:
    """Refuse files of other kinds before anything runs; a bag's folder stands for its recording.

    The command itself judges names that are not those of files in the working folder.

    Raises:
        InputError: With what the file is, and the command that takes it.
    """
    for option in options.parser.options:
        given = getattr(options, option.attribute, None) if option.takes else None
        if isinstance(given, list):
            settled: Any = [_settled(option, each) for each in given]
        elif given:
            settled = _settled(option, given)
        else:
            continue
        setattr(options, option.attribute, settled)


def _settled(option: Option, given: str | Path) -> str | Path:
    path = Path(given)
    if not path.exists():
        return given
    if format_of(path) == "bag folder" and not set(RECORDINGS).isdisjoint(option.takes):
        return path if "bag folder" in option.takes else recording_of(path)
    refuse_other_formats(path, option.takes)
    return given
