"""A program under test: what it prints, its goals, and its end."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

from bt_mission.base.text import escape_lines
from bt_mission.language.plugins import called_program
from bt_mission.programs.goals import ObservedGoal
from bt_mission.programs.mains import MainProgram, WholeProgram
from bt_mission.scenarios.faults.errors import ScenarioError
from bt_mission.testing.run import LIMIT_S, Run


class PrintedLine(NamedTuple):
    """A line that a program has printed.

    Attributes:
        time_s: Virtual time since the start, s.
        text: Without its end.
    """

    time_s: float
    text: str


class ProgramRun:
    """A whole program on the stage of a run.

    Args:
        file: The program: a file, a module, or a console script of an installed package.
        arguments: After its name on the command line.
        run: The run beside which it runs.

    Raises:
        PythonError: The file does not exist, or is no program.
        BtMissionError: It computes for too long before it waits.
    """

    def __init__(self, file: str | Path, arguments: Sequence[str], run: Run) -> None:
        program = called_program([str(file), *map(str, arguments)])
        self.run = run
        self.exit_code: int | None = None
        """None while it runs."""
        self.output: list[PrintedLine] = []
        """The lines that it has printed."""
        whole = WholeProgram(
            program.file,
            program.arguments,
            self._take,
            self._end,
            program.module,
            program.function,
        )
        self._file_name = whole.name
        self._program: MainProgram = run.stage.start_program(whole)
        self.name = self._program.name
        """That of the file; a second copy is `NAME_2`."""

    def __repr__(self) -> str:
        state = "runs" if self.exit_code is None else f"exit code {self.exit_code}"
        return f"<{self.name}: {state}, {len(self.output)} lines, {len(self.goals)} goals>"

    @property
    def text(self) -> str:
        """The lines that it has printed, as one text."""
        return "".join(f"{line.text}\n" for line in self.output)

    @property
    def goals(self) -> tuple[ObservedGoal, ...]:
        """The goals of its clients and servers, as their servers saw them."""
        return tuple(
            goal for goal in self.run.stage.served_goals if self.name in (goal.client, goal.server)
        )

    def interrupt(self) -> None:
        """Send SIGINT, as Ctrl-C does: its handler runs where its main thread waits.

        Raises:
            ScenarioError: It has ended.
        """
        if self.exit_code is not None:
            raise ScenarioError(f"{self.name} has ended: exit code {self.exit_code}")
        self.run.stage.interrupt_program(self._program)

    def until_done(self, *, within: float = LIMIT_S) -> int:
        """Run to its end; return its exit code.

        Raises:
            NeverHeldError: It has not ended after `within` seconds, or at the mission's end.
        """
        if self.exit_code is None:
            ended: Callable[[object], bool] = lambda _: self.exit_code is not None  # noqa: E731
            self.run.until(ended, within=within)
        assert self.exit_code is not None, "the run has reached its end"
        self.run.was_moved = True  # it may have ended at its start
        return self.exit_code

    def _take(self, time_s: float, text: str) -> None:
        self.output.append(PrintedLine(time_s, text))
        # pytest shows it with a failure.
        sys.stdout.write(f"{time_s:9.2f} s  {self._file_name}: {escape_lines(text)}\n")

    def _end(self, exit_code: int) -> None:
        self.exit_code = exit_code
