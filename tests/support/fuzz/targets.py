"""What can be fuzzed: each target makes cases and judges them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from tests.support.fuzz.finding import Case, Verdict

MODULES = {
    "missions": "cases",
    **{name: name for name in ("recordings", "trees", "goals", "controls", "servers", "models")},
}
"""The module of each target; they are imported late, since most take ROS."""

SUFFIXES = {
    ".yaml": "missions",
    ".xml": "missions",
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
    declared = import_module(f"tests.support.fuzz.{MODULES[name]}").TARGET
    assert isinstance(declared, Target)
    return declared


def target_of(path: Path) -> str:
    """Return the name of the target that a saved case belongs to."""
    return SUFFIXES.get(path.suffix, "missions")
