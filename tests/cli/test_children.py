"""Commands in other processes end when told to, and so do the processes that they started."""

from __future__ import annotations

import asyncio
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TypeAlias

import pytest

from bt_mission.cli import children
from bt_mission.cli.children import ChildCommand, Spare

DEAF = """trap "" INT
sleep 600 &
echo "in a browser: http://127.0.0.1:1/here/" >&2
wait
"""
LINES = """echo "    - log: x  # in a browser: http://127.0.0.1:1/wrong/" >&2
head -c 200000 /dev/zero | tr "\\\\0" x >&2
echo >&2
echo "in a browser: http://127.0.0.1:1/right/" >&2
echo "in a browser: http://127.0.0.1:1/late/" >&2
echo 12345
kill -KILL $$
"""

Program: TypeAlias = Callable[[str], None]


@pytest.fixture
def program(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Program:
    """Have a script run in the place of this program."""

    def place(text: str) -> None:
        file = tmp_path / "program"
        file.write_text(f"#!/bin/sh\n{text}")
        file.chmod(0o700)
        monkeypatch.setattr(sys, "executable", str(file))

    return place


@pytest.mark.process
def test_a_child_that_does_not_listen_ends_with_what_holds_its_output(
    monkeypatch: pytest.MonkeyPatch, program: Program
) -> None:
    """Two interrupts, then force."""
    program(DEAF)
    monkeypatch.setattr(children, "PATIENCE_S", 0.2)

    async def stopped() -> ChildCommand:
        child = ChildCommand(None, ["run"])
        while not child.link:  # noqa: ASYNC110 - another process says it
            await asyncio.sleep(0)  # noqa: TID251 - lets the loop read
        await child.stop()
        await child.wait()
        return child

    assert asyncio.run(stopped()).code == -9


async def ended(trial: Path | None, words: list[str], spare: Spare | None = None) -> ChildCommand:
    """A command that has ended."""
    child = ChildCommand(trial, words, spare)
    await child.wait()
    return child


@pytest.mark.process(always=True)
def test_the_link_of_a_child_is_a_line_of_its_own_and_its_death_is_told(
    monkeypatch: pytest.MonkeyPatch, program: Program
) -> None:
    """Neither a link within a line, nor a line that is too long, nor endless output counts."""
    program(LINES)
    monkeypatch.setattr(children, "MOST_OUTPUT", 3)
    child = asyncio.run(ended(None, ["run"]))
    assert (child.link, child.code, child.output) == ("http://127.0.0.1:1/right/", -9, "123")
    assert child.lines[-1] == "the process was ended by signal 9 (Killed)"


@pytest.mark.parametrize(
    ("word", "reason"), [("a\0b", "embedded null byte"), ("x" * 300_000, "Argument list too long")]
)
@pytest.mark.process
def test_a_command_that_cannot_start_says_why_and_leaves_no_text(
    tmp_path: Path, word: str, reason: str
) -> None:
    """It is over, as any other."""
    trial = tmp_path / "trial.yaml"
    trial.write_text("mission: m\n")
    child = asyncio.run(ended(trial, ["run", word]))
    assert (child.is_over, child.code) == (True, None)
    assert child.lines == [f"cannot start the command: {reason}"]
    assert not trial.exists()


@pytest.mark.process
def test_a_command_runs_although_the_process_that_was_ready_for_it_has_ended(
    program: Program,
) -> None:
    """A new one runs it."""
    program('case "$*" in *cli.preloaded*) exit 1;; *) echo done;; esac\n')

    async def run() -> ChildCommand:
        spare = Spare()
        await (await spare._started).wait()
        return await ended(None, ["run"], spare)

    assert asyncio.run(run()).output == "done\n"
