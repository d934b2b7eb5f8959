"""The processes of a hunt, and what they judge."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any


def work(folder: Path, name: str, cases: Any, pipe: Connection) -> None:
    """Judge one case after another; tell of each before, and what was found after."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    from tests.support.fuzz import limits  # noqa: PLC0415 - takes ROS
    from tests.support.fuzz.targets import target  # noqa: PLC0415 - as above

    chosen = target(name)
    os.chdir(folder)
    chosen.prepare(folder)
    corpus = chosen.corpus()
    for sample in chosen.samples(corpus):
        Path(sample.name).write_bytes(sample.contents)
        limits.judge_within(Path(sample.name), judge=chosen.judge)
    limits.limit_memory()
    most_mb = limits.resident_mb() + limits.MEMORY_MB
    for number, case in cases(chosen, corpus):
        path = Path(case.name)
        path.write_bytes(case.contents)
        pipe.send(("begun", number, case.name))
        limits.limit_processor()
        verdict = limits.judge_within(path, judge=chosen.judge)
        if verdict.finding is not None:
            pipe.send(("found", (verdict.finding.kind, verdict.finding.text), case.contents))
        pipe.send(("done", verdict.inputs, verdict.accepted))
        if limits.resident_mb() > most_mb:
            return  # what is left would not be enough for a case; a new process goes on
    pipe.send(("finished", 0, ""))


@dataclass(frozen=True)
class Mutants:
    """The cases of one process among several."""

    seed: int
    first: int
    step: int
    end: int

    def __call__(self, target: Any, corpus: Any) -> Iterator[tuple[int, Any]]:
        """Yield them, with their numbers; `found` is the corpus."""
        for number in range(self.first, self.end, self.step):
            yield number, target.case(corpus, self.seed, number)


@dataclass(frozen=True)
class Files:
    """Cases that were saved, or are the user's."""

    paths: tuple[Path, ...]
    first: int = 0
    step: int = 1

    def __call__(self, _target: Any, _corpus: Any) -> Iterator[tuple[int, Any]]:
        """Yield them as they are."""
        from tests.support.fuzz.finding import Case  # noqa: PLC0415 - as above

        for number in range(self.first, len(self.paths), self.step):
            path = self.paths[number]
            yield number, Case(f"m{path.suffix}", path.read_bytes())


@dataclass
class Worker:
    """One process, and the case that it is at.

    `began` is whether it got to its first case; `asleep` is for how many seconds it has done
    nothing and said nothing.
    """

    folder: Path
    target: str
    cases: Any
    number: int = -1
    name: str = ""
    starts: int = 0
    began: bool = False
    asleep: int = 0
    receiver: Connection = field(init=False)
    process: Any = field(init=False)

    @property
    def file(self) -> Path:
        """The file that holds the case."""
        return self.folder / str(self.starts) / self.name

    def start(self) -> None:
        """Start, behind the last case."""
        if self.starts:
            first = self.number + self.cases.step
            self.cases = type(self.cases)(**{**vars(self.cases), "first": first})
        self.starts += 1
        self.began = False
        self.asleep = 0
        home = self.folder / str(self.starts)
        home.mkdir(parents=True)
        context = multiprocessing.get_context("spawn")
        self.receiver, sender = context.Pipe(duplex=False)
        arguments = (home, self.target, self.cases, sender)
        self.process = context.Process(target=work, args=arguments, daemon=True)
        self.process.start()
        sender.close()

    def look(self, patience: int) -> None:
        """Look after it, each second: end it where it waits for what does not come."""
        self.asleep = self.asleep + 1 if self.began and _sleeps(self.process.pid) else 0
        if self.asleep == patience:
            self.process.kill()


def _sleeps(pid: int) -> bool:
    """Return whether a process waits, instead of using or wanting the processor."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8")
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] == "S"
