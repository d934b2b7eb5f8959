"""Types of arguments of the command line: each reads a word, or refuses it with what it expects."""

from __future__ import annotations

import argparse
import math
from pathlib import Path

LAST_PORT = 65535

LONGEST_SEED = 18
"""Digits of a seed where there are many: their count fits in 64 bits."""


def seconds(text: str, expected: str = "seconds, 0 or more") -> float:
    """Read a time, s."""
    value = _number(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"expected {expected}, got '{text}'")
    return value


def output_file(text: str) -> Path:
    """Read the path of a file to write, which :mod:`bt_mission.cli.outputs` checks."""
    return Path(text)


def unchecked_output_file(text: str) -> Path:
    """Read the path of a file to write, of which only the rule for equal files holds."""
    return Path(text)


def input_file(text: str) -> Path:
    """Read the path of a file to read, or a name that stands for one."""
    return Path(text)


def speed(text: str) -> float:
    """Read a speed, in virtual seconds per second of the wall clock."""
    value = _number(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"expected a number above 0, got '{text}'")
    return value


def count(text: str) -> int:
    """Read a number of things, 1 or more."""
    return _integer(text, 1)


def whole(text: str) -> int:
    """Read an integer, 0 or more."""
    return _integer(text, 0)


def port(text: str) -> int:
    """Read the number of a port; 0 is any that is free."""
    value = _integer(text, 0)
    if value > LAST_PORT:
        raise argparse.ArgumentTypeError(f"expected a port from 0 to {LAST_PORT}, got '{text}'")
    return value


def share(text: str) -> float:
    """Read a share, from 0 to 1."""
    value = _number(text)
    if not 0 <= value <= 1:
        raise argparse.ArgumentTypeError(f"expected a share from 0 to 1, got '{text}'")
    return value


def seed(text: str) -> int:
    """Read the seed of a mission's random numbers, 0 or more."""
    return _integer(text, 0)


def seeds(text: str) -> range | tuple[int, ...]:
    """Read seeds: how many, from where to where, or which."""
    low, dots, high = text.partition("..")
    parts = [low, high] if dots else text.split(",")
    if not all(one.strip().isdecimal() for one in parts):
        raise argparse.ArgumentTypeError(
            f"expected a number of seeds, A..B, or a list such as 3,5,8; got '{text}'"
        )
    if any(len(one.strip()) > LONGEST_SEED for one in parts):
        raise argparse.ArgumentTypeError(
            f"a seed has at most {LONGEST_SEED} digits here, got '{text}'"
        )
    values = [int(one) for one in parts]
    if dots:
        found: range | tuple[int, ...] = range(values[0], values[1] + 1)
    else:
        found = range(values[0]) if len(values) == 1 else tuple(values)
    if not found:
        raise argparse.ArgumentTypeError(f"'{text}' is no seed at all")
    if not dots and len(values) != len(set(values)):
        raise argparse.ArgumentTypeError(f"a seed stands twice in '{text}'")
    return found


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
