"""What is said of a benchmark: how it is started, and which figures it gives."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from fnmatch import fnmatchcase
from pathlib import Path

ROUNDS = "{rounds}"
FOLDER = "{folder}"


class Aim(Enum):
    """How a figure is held against the number of a target."""

    AT_LEAST = "at least"
    AT_MOST = "at most"
    OF_OLD = "at most, of the old one"


@dataclass(frozen=True)
class Target:
    """What a figure must come to, and what it should.

    Args:
        kind: How it is compared. `OF_OLD` is about the ratio to another commit.
        must: What counts as done; None where only an aim is set.
        aim: What is hoped for; None where nothing more is.
    """

    kind: Aim
    must: float | None = None
    aim: float | None = None

    def is_met(self, value: float) -> bool | None:
        """Whether a value, or with `OF_OLD` a ratio, reaches what it must; None without a must."""
        if self.must is None:
            return None
        return value >= self.must if self.kind is Aim.AT_LEAST else value <= self.must


@dataclass(frozen=True)
class Figure:
    """A figure that a benchmark gives.

    Args:
        name: As the benchmark gives it; ``*`` stands for sizes and names of missions.
        target: What it must come to.
        row: What the table of targets calls it; empty where it is not in it.
        optional: Whether a run without it, such as a small one, is complete.
    """

    name: str
    target: Target | None = None
    row: str = ""
    optional: bool = False

    def covers(self, name: str) -> bool:
        """Whether a figure of this name is meant."""
        return fnmatchcase(name, self.name)


@dataclass(frozen=True)
class Benchmark:
    """A script of this folder, or a part of one, and how it is started.

    In a command ``{rounds}`` is the number of rounds, ``{folder}`` a temporary folder.

    Args:
        name: As it is called on the command line.
        line: What it measures, in one line.
        commands: Started one after another: a script of this folder with its arguments.
        smoke: The same, as small as it can be: whether it works, not what it costs.
        figures: What it gives.
        rounds: How many rounds unless others are asked for.
        takes: About how long that is.
    """

    name: str
    line: str
    commands: tuple[str, ...]
    smoke: tuple[str, ...]
    figures: tuple[Figure, ...]
    rounds: int = 1
    takes: str = "a minute"

    @property
    def has_rounds(self) -> bool:
        """Whether the script itself repeats what it measures."""
        return any(ROUNDS in one for one in self.commands)

    def processes(self, rounds: int, folder: Path, *, smoke: bool) -> list[list[str]]:
        """Return the arguments of each process that is started: a script, then its own arguments.

        Args:
            rounds: Of what is measured. A script without rounds is started so many times.
            folder: For what scripts write.
            smoke: Start the small ones, once.
        """
        if smoke:
            texts = self.smoke
        else:
            texts = self.commands if self.has_rounds else self.commands * rounds
        return [
            [
                word.replace(ROUNDS, str(rounds)).replace(FOLDER, str(folder))
                for word in shlex.split(text)
            ]
            for text in texts
        ]

    def complaints(self, names: Iterable[str]) -> list[str]:
        """Compare what came with what is declared; gives what is wrong, in words."""
        came = set(names)
        missing = [
            f"it has not given '{one.name}'"
            for one in self.figures
            if not (one.optional or any(one.covers(name) for name in came))
        ]
        unknown = [
            f"it has given '{name}', which benchmarks/harness/catalogue.py does not declare"
            for name in sorted(came)
            if self.figure(name) is None
        ]
        return missing + unknown

    def figure(self, name: str) -> Figure | None:
        """Return the declared figure that covers a name; the first where several do."""
        return next((one for one in self.figures if one.covers(name)), None)
