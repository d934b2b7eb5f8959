"""Part of the test session: it fails where it leaves files in the checkout that git shows.

Where there is no git, or the sources are no checkout, nothing is looked at. With pytest-xdist the
process that starts the workers looks, before the first and after the last of them.
"""

from __future__ import annotations

import subprocess
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from _pytest.terminal import TerminalReporter

BEFORE: pytest.StashKey[set[str] | None] = pytest.StashKey()
LEFT: pytest.StashKey[list[str]] = pytest.StashKey()


def untracked(folder: Path) -> set[str] | None:
    """The files that git neither tracks nor ignores; None where it cannot say."""
    command = ["git", "status", "--porcelain", "-z", "--untracked-files=all"]
    try:
        done = subprocess.run(command, cwd=folder, capture_output=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    entries = done.stdout.decode(errors="replace").split("\0")
    return {entry.removeprefix("?? ") for entry in entries if entry.startswith("?? ")}


def pytest_sessionstart(session: pytest.Session) -> None:
    """Know what is there already."""
    if not hasattr(session.config, "workerinput"):
        session.config.stash[BEFORE] = untracked(session.config.rootpath)


@pytest.hookimpl(wrapper=True)
def pytest_sessionfinish(session: pytest.Session) -> Generator[None, object, object]:
    """Fail where there is more."""
    result = yield
    before = session.config.stash.get(BEFORE, None)
    after = None if before is None else untracked(session.config.rootpath)
    if before is not None and after is not None and after - before:
        session.config.stash[LEFT] = sorted(after - before)
        if session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED
    return result


def pytest_terminal_summary(terminalreporter: TerminalReporter, config: pytest.Config) -> None:
    """Name them."""
    left = config.stash.get(LEFT, [])
    if left:
        terminalreporter.section("left in the checkout by this session", red=True)
        for name in left:
            terminalreporter.line(name)
