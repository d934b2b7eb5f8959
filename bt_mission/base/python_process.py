"""Other processes of this Python: none imports from the working folder by accident.

``python -m`` and ``python -c`` put the working folder first on the path of imports, and an empty
entry of ``PYTHONPATH`` stands for it, too. A ``json.py`` beside a mission would then be executed.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

PATH = "PYTHONPATH"
SAFE = "PYTHONSAFEPATH"
"""If it is not empty, each Python behaves as with `-P`."""


def python_command(*words: str) -> list[str]:
    """Return the command line of a Python process with these arguments.

    Pass `python_environment` to the process, too.
    """
    return [sys.executable, "-P", *words]


def python_environment(environment: Mapping[str, str] | None = None) -> dict[str, str]:
    """Return an environment without empty entries of ``PYTHONPATH``.

    Args:
        environment: The one to change; None is that of this process.
    """
    changed = dict(os.environ if environment is None else environment)
    entries = [entry for entry in changed.pop(PATH, "").split(os.pathsep) if entry]
    return {**changed, PATH: os.pathsep.join(entries)} if entries else changed


@contextmanager
def safe_processes() -> Iterator[dict[str, str]]:
    """Have libraries that start Python themselves do it safely while this is open.

    Yields:
        The variables that those processes should set once they have started, so that processes of
        their own are as elsewhere.
    """
    before = {name: os.environ.get(name) for name in (PATH, SAFE)}
    os.environ[SAFE] = "1"
    if PATH in os.environ:
        os.environ[PATH] = python_environment().get(PATH, "")
    try:
        yield {SAFE: before[SAFE] or ""}
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
