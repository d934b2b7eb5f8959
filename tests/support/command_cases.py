"""What commands give to tests of all commands: the constants of ``tests/commands/NAME/cases.py``.

So a test of all commands names none that can be taken away.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from subprocess import Popen
from typing import Any

from tests.support.project import ROOT

MODULES = [
    f"tests.commands.{path.parent.name}.cases"
    for path in sorted((ROOT / "tests/commands").glob("*/cases.py"))
]


def cases(name: str) -> Iterator[Any]:
    """Yield the members of a constant of each command that has it."""
    for module in MODULES:
        yield from getattr(import_module(module), name, ())


def named_cases(name: str) -> Mapping[str, Any]:
    """Return the members of a mapping of each command that has it."""
    return dict(
        pair for module in MODULES for pair in getattr(import_module(module), name, {}).items()
    )


@dataclass(frozen=True)
class InFolder:
    """How a command gets far in a folder (``IN_FOLDER``, by its name).

    Attributes:
        line: Its arguments.
        serves: What it says when it serves; it ends by Ctrl-C then.
        prepare: Writes its files into the folder.
        act: Has it do what it serves, given the last line that it said.
        speak: Speaks with it over its standard input and output.
    """

    line: str
    serves: str = ""
    prepare: Callable[[Path], None] = lambda _: None
    act: Callable[[str], None] = lambda _: None
    speak: Callable[[Popen[str]], None] | None = None
