"""Mutates mission files, and looks for one that does not get what it deserves.

Never a traceback, a hang, more than 200 MB, or a mission that passes the check and then fails on
what the check could have seen. Each case is checked as `bt-mission check` does it; what is sound
is run for some hundred ticks against servers that answer by luck. The cases follow from the seed
and the corpus, which begins in tests/fuzz/corpus. Each finding is saved, with its reason.

Run it as: python tools/fuzz_missions.py --seconds 60
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import signal
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

ENDLESS = 2**62
CASE_FILE = "m.yaml"

Case = tuple[int, bytes]


def work(folder: Path, cases: Any, told: Connection) -> None:
    """Judge one case after another; tell of each before, and what was found after."""
    from tests.support.fuzz import limits  # noqa: PLC0415 - `--help` does not wait for ROS
    from tests.support.fuzz.cases import corpus, prepare  # noqa: PLC0415 - as above

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.chdir(folder)
    prepare(folder)
    found = corpus()
    path = Path(CASE_FILE)
    for text in found.texts:  # what is loaded once counts for no case
        path.write_text(text, encoding="utf-8")
        limits.judge_within(path)
    limits.limit_memory()
    most_mb = limits.resident_mb() + limits.MEMORY_MB
    for number, contents in cases(found):
        told.send(("begun", number, ""))
        path.write_bytes(contents)
        limits.limit_processor()
        verdict = limits.judge_within(path)
        if verdict.finding is not None:
            told.send(("found", (verdict.finding.kind, verdict.finding.text), contents))
        told.send(("done", number, verdict.accepted))
        if limits.resident_mb() > most_mb:
            return  # what is left would not be enough for a case; a new process goes on
    told.send(("finished", 0, ""))


@dataclass(frozen=True)
class Mutants:
    """The cases of one process among several."""

    seed: int
    first: int
    step: int
    end: int

    def __call__(self, found: Any) -> Iterator[Case]:
        """Yield them, with their numbers; `found` is the corpus."""
        from tests.support.fuzz.cases import case  # noqa: PLC0415 - as above

        for number in range(self.first, self.end, self.step):
            yield number, case(found, self.seed, number)


@dataclass(frozen=True)
class Files:
    """Cases that were saved, or are the user's."""

    paths: tuple[Path, ...]
    first: int = 0
    step: int = 1

    def __call__(self, _found: Any) -> Iterator[Case]:
        """Yield them as they are."""
        for number in range(self.first, len(self.paths), self.step):
            yield number, self.paths[number].read_bytes()


@dataclass
class Worker:
    """One process, and the case that it is at."""

    folder: Path
    cases: Any
    number: int = -1
    starts: int = 0
    heard: Connection = field(init=False)
    process: Any = field(init=False)

    def start(self) -> None:
        """Start, behind the last case."""
        if self.starts:
            first = self.number + self.cases.step
            self.cases = type(self.cases)(**{**vars(self.cases), "first": first})
        self.starts += 1
        home = self.folder / str(self.starts)
        home.mkdir(parents=True)
        context = multiprocessing.get_context("spawn")
        self.heard, told = context.Pipe(duplex=False)
        self.process = context.Process(target=work, args=(home, self.cases, told), daemon=True)
        self.process.start()
        told.close()


@dataclass
class Hunt:
    """What was done, and what was found: by kind, each once."""

    options: argparse.Namespace
    tried: int = 0
    accepted: int = 0
    found: dict[str, int] = field(default_factory=dict)

    def hear(self, worker: Worker) -> bool:
        """Take in what a process says; false once it has no more cases."""
        try:
            what, one, two = worker.heard.recv()
        except (EOFError, OSError):
            worker.process.join()
            code = worker.process.exitcode
            if worker.number < 0 or (code and self.options.replay):
                raise SystemExit(f"a process ended with {code} before its first case") from None
            if code:
                contents = (worker.folder / str(worker.starts) / CASE_FILE).read_bytes()
                self.note(worker, f"the process ended with {code}", "killed, or crashed", contents)
            worker.start()
            return True
        if what == "begun":
            worker.number = one
        elif what == "found":
            self.note(worker, *one, two)
        elif what == "done":
            self.tried += 1
            self.accepted += two
        return bool(what != "finished")

    def note(self, worker: Worker, kind: str, text: str, contents: bytes) -> None:
        """Count a finding, and save the first of its kind."""
        self.found[kind] = self.found.get(kind, 0) + 1
        if self.found[kind] > 1 and not self.options.replay:
            return
        print(f"\nFOUND: {kind}\n{text}", flush=True)
        if self.options.replay:
            return
        self.options.save.mkdir(parents=True, exist_ok=True)
        path = self.options.save / f"{self.options.seed}_{worker.number}.yaml"
        path.write_bytes(contents)
        path.with_suffix(".txt").write_text(f"{kind}\n{text}\n", encoding="utf-8")
        print(f"repeat it: python tools/fuzz_missions.py --replay {path}", flush=True)

    def line(self, seconds: int) -> str:
        """Return how far it is."""
        share = 100 * self.accepted / max(self.tried, 1)
        rate = self.tried / max(seconds, 1)
        kinds = f"{len(self.found)} kinds of findings"
        return f"{seconds} s: {self.tried} cases, {rate:.0f}/s, {share:.0f} % sound, {kinds}"


def hunt(options: argparse.Namespace, folder: Path) -> Hunt:
    """Run the processes until the time is over or no case is left."""
    found = Hunt(options)
    workers = []
    for index in range(options.processes):
        cases: Any = Mutants(options.seed, options.first + index, options.processes, options.end)
        if options.replay:
            cases = Files(
                tuple(path.resolve() for path in options.replay), index, options.processes
            )
        workers.append(Worker(folder / str(index), cases))
    for worker in workers:
        worker.start()
    seconds = 0
    ticker, tick = _every_second()
    while workers and (options.seconds is None or seconds < options.seconds):
        there = wait([ticker, *(worker.heard for worker in workers)])
        if ticker in there:
            ticker.recv()
            seconds += 1
            if seconds % options.every == 0:
                print(found.line(seconds), flush=True)
        workers = [one for one in workers if one.heard not in there or found.hear(one)]
    tick.terminate()
    for worker in workers:
        worker.process.terminate()
        worker.process.join()
    print(found.line(seconds), flush=True)
    return found


def _every_second() -> tuple[Connection, Any]:
    """Return what says something each second, and its process."""
    context = multiprocessing.get_context("spawn")
    heard, told = context.Pipe(duplex=False)
    process = context.Process(target=_tick, args=(told,), daemon=True)
    process.start()
    told.close()
    return heard, process


def _tick(told: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, lambda *_: told.send(1))
    signal.setitimer(signal.ITIMER_REAL, 1, 1)
    while True:
        signal.pause()


def main(arguments: Sequence[str] | None = None) -> int:
    """Hunt; gives the exit code, 1 where something was found."""
    parser = argparse.ArgumentParser(
        description="Mutates mission files and looks for one that crashes the check, takes too "
        "long or too much, or passes it and then fails on what it could have seen."
    )
    parser.add_argument("--seconds", type=int, help="stop after this time (default: never)")
    parser.add_argument("--count", type=int, default=ENDLESS, help="stop after so many cases")
    parser.add_argument("--seed", type=int, default=1, help="the cases follow from it (default: 1)")
    parser.add_argument("--first", type=int, default=0, help="the number of the first case")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--every", type=int, default=10, help="seconds between lines of progress")
    parser.add_argument(
        "--save", type=Path, default=Path("fuzz_findings"), help="folder for what is found"
    )
    parser.add_argument(
        "--replay", type=Path, nargs="+", help="judge these files instead of mutated ones"
    )
    options = parser.parse_args(arguments)
    options.end = options.first + options.count
    with tempfile.TemporaryDirectory(prefix="fuzz_missions_") as name:
        found = hunt(options, Path(name))
    print(json.dumps({"cases": found.tried, "sound": found.accepted, "findings": found.found}))
    return 1 if found.found else 0


if __name__ == "__main__":
    sys.exit(main())
