"""Programs of the campaign ``parity`` in real time, and on the stage."""

from __future__ import annotations

import os
import pty
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from threading import Thread  # noqa: TID251 - reads the lines of a process
from time import monotonic, sleep  # noqa: TID251 - processes run in real time

from parity_cases import PROGRAMS, Case

from bt_mission.base.stamps import NS
from bt_mission.programs.mains import WholeProgram
from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage
from bt_mission.testing.live_graph import LiveGraph, own_domain

LIMIT_S = 40.0
LOOK_S = 0.01
START_S = 1.0
"""The main program starts so long after the others."""
PAUSE_S = 0.5
"""From the end of the main program to the SIGINT for the others."""
AFTER_S = 3.0
"""They have this long to end."""

Lines = list[tuple[float, str]]
"""Lines of a program, each with its time s."""


@dataclass
class Ran:
    """What the programs of a case have printed, and how each ended; None for one that had not."""

    printed: list[Lines]
    codes: list[int | None]


def in_real_time(case: Case, folder: Path) -> Ran:
    """Run the programs of a case as processes."""
    with own_domain() as domain_id:
        graph = LiveGraph(folder, domain_id)
        if case.world:
            graph.robot(case.world, "waffle", "--no-camera")
        processes: list[_Process] = []
        try:
            for words in case.programs:
                if processes and words == case.programs[-1]:
                    sleep(START_S)
                processes.append(_Process(words, graph.environment, folder))
            main = processes[-1]
            main.run(case.interrupt_s, processes)
            codes = [main.end()]
            sleep(PAUSE_S)
            codes = [process.end() for process in processes[:-1]] + codes
        finally:
            for process in processes:
                process.end(signal.SIGKILL)
            graph.close()
    return Ran([process.printed for process in processes], codes)


class _Process:
    """A program as a process on a terminal, whose lines are read as they come."""

    def __init__(self, words: str, environment: dict[str, str], folder: Path) -> None:
        self.printed: Lines = []
        file, *options = words.split()
        self._terminal, inside = pty.openpty()
        self._process = subprocess.Popen(  # noqa: S603 - our own programs
            [sys.executable, PROGRAMS / file, *options],
            env={**os.environ, "PYTHON_COLORS": "0", **environment},  # 3.13 colours tracebacks
            cwd=folder,
            stdout=inside,
            stderr=inside,
        )
        os.close(inside)
        self._reader = Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        with suppress(OSError), os.fdopen(self._terminal, encoding="utf-8") as lines:
            for line in lines:
                self.printed.append((monotonic(), line.rstrip("\r\n")))

    def run(self, interrupt_s: float | None, processes: Sequence[_Process]) -> None:
        """Wait for its end, but not for ever; interrupt it so long after all have printed."""
        start = monotonic()
        while self._process.poll() is None and monotonic() - start < LIMIT_S:
            sleep(LOOK_S)
            if interrupt_s is not None and all(each.printed for each in processes):
                begun_s = max(each.printed[0][0] for each in processes)
                sleep(max(begun_s + interrupt_s - monotonic(), 0.0))
                self._process.send_signal(signal.SIGINT)
                interrupt_s = None

    def end(self, number: int = signal.SIGINT) -> int | None:
        """Interrupt it; return its exit code, None if it does not end."""
        if self._process.poll() is None:
            self._process.send_signal(number)
        try:
            return self._process.wait(AFTER_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return None
        finally:
            self._process.wait()
            self._reader.join()


def on_the_stage(case: Case, folder: Path) -> Ran:
    """Run the programs of a case on the virtual clock."""
    mission = load(f"mission: parity\nworld: {case.world or 'empty_arena'}\ntree: {{wait: 9999}}\n")
    with Stage(mission, image_folder=folder) as stage:
        if case.world:
            stage.offer_all()
            while stage.now_ns < stage.start_ns + NS:  # as a robot that is there
                stage.step()
        programs = [_Staged(stage, words) for words in case.programs]
        main = programs[-1]
        if case.interrupt_s is not None:
            while not all(program.printed for program in programs):
                stage.step()
            begun_s = max(program.printed[0][0] for program in programs)
            main.run(begun_s + case.interrupt_s)
            main.interrupt()
        main.run(LIMIT_S)
        main.interrupt()
        main.run(main.now_s + AFTER_S)
        end_ns = stage.now_ns + PAUSE_S * NS
        while stage.now_ns < end_ns:
            stage.step()
        for program in programs[:-1]:
            program.interrupt()
            program.run(program.now_s + AFTER_S)
    return Ran([program.printed for program in programs], [program.code for program in programs])


class _Staged:
    """A program on the stage."""

    def __init__(self, stage: Stage, words: str) -> None:
        self.printed: Lines = []
        self.code: int | None = None
        self._stage = stage
        file, *options = words.split()
        program = WholeProgram(PROGRAMS / file, options, self._take, self._end)
        self._program = stage.start_program(program)

    @property
    def now_s(self) -> float:
        """Virtual time, s."""
        return (self._stage.now_ns - self._stage.start_ns) / NS

    def _take(self, time_s: float, line: str) -> None:
        self.printed.append((time_s, line))

    def _end(self, code: int) -> None:
        self.code = code

    def run(self, until_s: float) -> None:
        """Wait for its end, at most until a time."""
        while self.code is None and self.now_s < until_s:
            self._stage.step()

    def interrupt(self) -> None:
        """Send SIGINT, if it runs."""
        if self.code is None:
            self._stage.interrupt_program(self._program)
