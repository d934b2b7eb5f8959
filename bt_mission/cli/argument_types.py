"""Types of arguments of the command line: each reads a word, or refuses it with what it expects."""

from __future__ import annotations

import argparse
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from bt_mission.base.stamps import MOST_SECONDS

LAST_PORT = 65535

LONGEST_SEED = 18
"""Digits of a seed where there are many: their count fits in 64 bits."""


@dataclass(frozen=True)
class FileType:
    """The path of a file that a command reads or writes.

    Attributes:
        role: What is done with it; :mod:`bt_mission.cli.outputs` has the rules. Of an "unchecked
            output" only the rule for equal files holds.
        suffixes: Those that its name may have; empty where any will do.
        what: The reason for them, such as ``recordings are MCAP files``.
        takes_devices: May it be a device or a pipe, whatever its name is?
    """

    role: Literal["input", "output", "unchecked output"]
    suffixes: tuple[str, ...] = ()
    what: str = ""
    takes_devices: bool = True

    def __call__(self, text: str) -> Path:
        """Read the path."""
        return Path(text)


input_file = FileType("input")
"""Or a name that stands for one."""
output_file = FileType("output")
unchecked_output_file = FileType("unchecked output")


def seconds(text: str) -> float:
    """Read a time, s."""
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"expected seconds from 0, such as 12.5, got '{text}'")
    if value > MOST_SECONDS:
        raise argparse.ArgumentTypeError(f"expected at most {MOST_SECONDS:,} s, got '{text}'")
    return value


def above_zero(text: str) -> float:
    """Read a number above 0, such as virtual seconds per second of the wall clock."""
    value = _number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got '{text}'")
    return value


def count(text: str) -> int:
    """Read a number of things, 1 or more."""
    return _integer(text, 1)


def whole(text: str) -> int:
    """Read an integer, 0 or more, such as a seed."""
    return _integer(text, 0)


def port(text: str) -> int:
    """Read the number of a port; 0 is any that is free."""
    value = int(text) if text.isdecimal() else -1
    if not 0 <= value <= LAST_PORT:
        raise argparse.ArgumentTypeError(f"expected a port from 0 to {LAST_PORT}, got '{text}'")
    return value


def share(text: str) -> float:
    """Read a share, from 0 to 1."""
    value = _number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"expected a share from 0 to 1, got '{text}'")
    return value


def seeds(text: str) -> range | tuple[int, ...]:
    """Read seeds: how many, from where to where, or which."""
    low, dots, high = text.partition("..")
    parts = [low, high] if dots else text.split(",")
    if not all(part.strip().isdecimal() for part in parts):
        raise argparse.ArgumentTypeError(
            f"expected a number of seeds, A..B, or a list such as 3,5,8; got '{text}'"
        )
    if any(len(part.strip()) > LONGEST_SEED for part in parts):
        raise argparse.ArgumentTypeError(
            f"a seed has at most {LONGEST_SEED} digits here, got '{text}'"
        )
    values = [int(value) for value in parts]
    if dots:
        seeds: range | tuple[int, ...] = range(values[0], values[1] + 1)
    else:
        seeds = range(values[0]) if len(values) == 1 else tuple(values)
    if not seeds:
        raise argparse.ArgumentTypeError(f"'{text}' contains no seed")
    if not dots and len(values) != len(set(values)):
        raise argparse.ArgumentTypeError(f"a seed appears twice in '{text}'")
    return seeds


def assignment(text: str) -> tuple[str, str]:
    """Read an input of a mission and its value."""
    name, equals, value = text.partition("=")
    if not equals or not name:
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE, got '{text}'")
    return name, value


def _integer(text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"expected an integer from {least}, got '{text}'")
    return int(text)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
