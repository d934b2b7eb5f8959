"""Benchmarks and campaigns: their scripts, and the targets of their figures."""

from __future__ import annotations

import shlex
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

ROUNDS, FOLDER = "{rounds}", "{folder}"
_FOLDER = Path(__file__).parent
FILES = (_FOLDER / "catalogue.toml", *sorted(_FOLDER.parent.glob("commands/*/catalogue.toml")))
"""The shared one, and that of each command which has benchmarks or campaigns."""


@dataclass(frozen=True)
class Target:
    """The bound of a figure: `at_least` or `at_most`; with `of_old`, its ratio to a commit."""

    at_least: float | None = None
    at_most: float | None = None
    of_old: bool = False
    aim: float | None = None

    def __str__(self) -> str:
        bound = (
            f"at most {self.at_most:g}" if self.at_least is None else f"at least {self.at_least:g}"
        )
        aim = "" if self.aim is None else f" (aim: {self.aim:g})"
        return f"{bound}{' x old' if self.of_old else ''}{aim}"

    def is_met(self, value: float) -> bool:
        """Return whether a value, or with `of_old` a ratio, reaches the bound."""
        if self.at_least is not None:
            return value >= self.at_least
        return self.at_most is None or value <= self.at_most


@dataclass(frozen=True)
class Benchmark:
    """A script, or a part of one; see catalogue.toml for its fields."""

    name: str
    line: str
    run: tuple[str, ...]
    smoke: tuple[str, ...]
    rounds: int = 1
    takes: str = "a minute"
    in_table: bool = False
    may_give_none: bool = False
    targets: Mapping[str, Target] = field(default_factory=dict)

    def commands(self, rounds: int, folder: Path, *, smoke: bool) -> list[list[str]]:
        """Return the processes that are started: a script with its arguments each."""
        repeats = any(ROUNDS in text for text in self.run)
        texts = self.smoke if smoke else self.run if repeats else self.run * rounds
        return [
            [
                word.replace(ROUNDS, str(rounds)).replace(FOLDER, str(folder))
                for word in shlex.split(text)
            ]
            for text in texts
        ]

    def target(self, figure: str) -> Target | None:
        """Return the target of a figure; the first if several patterns match its name."""
        return next(
            (target for name, target in self.targets.items() if fnmatchcase(figure, name)), None
        )


def _benchmark(name: str, entry: dict[str, Any]) -> Benchmark:
    targets = {key: Target(**value) for key, value in entry.pop("targets", {}).items()}
    run, smoke = (tuple(entry.pop(key)) for key in ("run", "smoke"))
    return Benchmark(name, run=run, smoke=smoke, targets=targets, **entry)


CATALOGUE: Sequence[Benchmark] = [
    _benchmark(name, entry)
    for file in FILES
    for name, entry in tomllib.loads(file.read_text("utf-8")).items()
]
