"""What can be fuzzed: each target makes cases and judges them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.support.fuzz.finding import Case, Verdict
from tests.support.project import ROOT

OF_COMMANDS = {
    path.stem.removeprefix("fuzz_"): f"tests.commands.{path.parent.name}.{path.stem}"
    for path in sorted((ROOT / "tests/commands").glob("*/fuzz_*.py"))
}
"""The modules of the targets of commands."""

_OWN = ("recordings", "goals", "controls", "servers", "models")
MODULES = {
    "missions": "tests.support.fuzz.cases",
    **{name: f"tests.support.fuzz.{name}" for name in _OWN},
    **OF_COMMANDS,
}
"""The module of each target; they are imported late, since most take ROS."""

SUFFIXES = {
    ".yaml": "missions",
    ".xml": "trees",
    ".mcap": "recordings",
    ".jsonl": "recordings",
    ".goals": "goals",
    ".controls": "controls",
    ".servers": "servers",
    ".model": "models",
}
"""To which target a saved case belongs where nothing else is said."""


@dataclass(frozen=True)
class Target:
    """Something of the product that takes input from outside.

    Attributes:
        corpus: Reads what mutations begin with.
        samples: Sound cases of the corpus, which are judged first: what is loaded once counts
            for no case.
        case: Gives the case of a corpus, a seed and a number; always the same.
        judge: Judges a case in a file; raises what the product raises.
        prepare: Puts what the cases need beside them into a folder.
    """

    corpus: Callable[[], Any]
    samples: Callable[[Any], Iterable[Case]]
    case: Callable[[Any, int, int], Case]
    judge: Callable[[Path], Verdict]
    prepare: Callable[[Path], None] = lambda _: None


def target(name: str) -> Target:
    """Return a target by its name."""
    declared = import_module(MODULES[name]).TARGET
    assert isinstance(declared, Target)
    return declared


def target_of(path: Path) -> str:
    """Return the name of the target that a saved case belongs to."""
    name = SUFFIXES.get(path.suffix, "missions")
    return name if name in MODULES else "missions"
