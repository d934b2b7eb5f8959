"""Mutates mission files, and looks for one that does not get what it deserves.

Never a traceback, a hang, more than 200 MB, or a mission that passes the check and then fails on
what the check could have seen. Each case is checked as `bt-mission check` does it; what is sound
is run for some hundred ticks against servers that answer by luck. The cases follow from the seed
and the corpus, which begins in tests/fuzz/corpus. Each finding is saved, with its reason.

It ends with 0 where nothing was found, with 1 where something was, with 2 where it cannot judge.

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
from collections.abc import Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.support.fuzz.workers import Files, Mutants, Worker  # noqa: E402 - from the root

ENDLESS = 2**62


class CannotJudgeError(Exception):
    """The hunt itself does not work: nothing can be said of the missions, good or bad."""


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
            self.mourn(worker)
            worker.start()
            return True
        worker.asleep = 0
        if what == "begun":
            worker.number, worker.name, worker.began = one, two, True
        elif what == "found":
            self.note(worker, *one, two)
        elif what == "done":
            self.tried += 1
            self.accepted += two
        return bool(what != "finished")

    def mourn(self, worker: Worker) -> None:
        """Note why a process ended, where it was not to have more memory."""
        worker.process.join()
        code = worker.process.exitcode
        if not worker.began:
            raise CannotJudgeError(f"a process ended with {code} before its first case")
        contents = worker.file.read_bytes()
        if worker.asleep >= self.options.patience:
            self.note(worker, "a hang", f"asleep for {worker.asleep} s", contents)
        elif code:
            self.note(worker, f"the process ended with {code}", "killed, or crashed", contents)

    def note(self, worker: Worker, kind: str, text: str, contents: bytes) -> None:
        """Count a finding, and save the first of its kind."""
        self.found[kind] = self.found.get(kind, 0) + 1
        if self.found[kind] > 1 and not self.options.replay:
            return
        print(f"\nFOUND: {kind}\n{text}", flush=True)
        if self.options.replay:
            return
        self.options.save.mkdir(parents=True, exist_ok=True)
        suffix = Path(worker.name).suffix
        path = self.options.save / f"{self.options.seed}_{worker.number}{suffix}"
        path.write_bytes(contents)
        path.with_suffix(".txt").write_text(f"{kind}\n{text}\n", encoding="utf-8")
        print(f"repeat it: python tools/fuzz_missions.py --replay {path}", flush=True)

    def line(self, seconds: int) -> str:
        """Return how far it is."""
        share = 100 * self.accepted / max(self.tried, 1)
        rate = self.tried / max(seconds, 1)
        kinds = f"{_counted(len(self.found), 'kind')} of findings"
        return f"{seconds} s: {self.tried} cases, {rate:.0f}/s, {share:.0f} % sound, {kinds}"


def hunt(options: argparse.Namespace, folder: Path) -> Hunt:
    """Run the processes until the time is over or no case is left."""
    found = Hunt(options)
    workers = []
    for index in range(options.processes):
        cases: Any = Mutants(options.seed, options.first + index, options.processes, options.end)
        if options.replay:
            cases = Files(tuple(options.replay), index, options.processes)
        workers.append(Worker(folder / str(index), cases))
    for worker in workers:
        worker.start()
    seconds = 0
    ticker, tick = _every_second()
    try:
        while workers and (options.seconds is None or seconds < options.seconds):
            there = wait([ticker, *(worker.heard for worker in workers)])
            if ticker in there:
                ticker.recv()
                seconds += 1
                if seconds % options.every == 0:
                    print(found.line(seconds), flush=True)
                for worker in workers:
                    worker.look(options.patience)
            workers = [one for one in workers if one.heard not in there or found.hear(one)]
    except KeyboardInterrupt:
        print("interrupted", flush=True)
    finally:
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


def _counted(number: int, what: str) -> str:
    return f"{number:,} {what}{'' if number == 1 else 's'}"


def _positive(text: str) -> int:
    number = int(text)
    if number < 1:
        raise ValueError
    return number


_positive.__name__ = "whole number from 1"  # what argparse calls it


def _file(text: str) -> Path:
    path = Path(text)
    if not path.is_file():
        raise argparse.ArgumentTypeError(f"no file {text!r}")
    return path.resolve()


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description="Mutates mission files and looks for one that crashes the check, takes too "
        "long or too much, or passes it and then fails on what it could have seen.",
        epilog="Ends with 0 where nothing was found, with 1 where something was, and with 2 where "
        "it cannot judge. Ctrl-C ends it early.",
    )
    add = parser.add_argument
    add("--seconds", type=_positive, help="stop after this time (default: never)")
    add("--count", type=_positive, default=ENDLESS, help="stop after so many cases")
    add("--seed", type=int, default=1, help="the cases follow from it (default: 1)")
    add("--first", type=int, default=0, help="the number of the first case")
    add("--processes", type=_positive, default=os.cpu_count() or 1)
    add("--every", type=_positive, default=10, help="seconds between lines of progress")
    add("--patience", type=_positive, default=20, help="seconds for which a case may sleep")
    add("--save", type=Path, default=Path("fuzz_findings"), help="folder for what is found")
    add("--replay", type=_file, nargs="+", help="judge these files instead of mutated ones")
    options = parser.parse_args(arguments)
    options.end = options.first + options.count
    return options


def _says_what_it_does(options: argparse.Namespace) -> str:
    """Return what is begun, in a line."""
    if options.replay:
        return f"Judging {_counted(len(options.replay), 'file')}"
    many = "" if options.count == ENDLESS else f"{options.count:,} "
    until = f" for {options.seconds} s" if options.seconds else ""
    by = f"seed {options.seed}, processes: {options.processes}"
    return f"Judging {many}mutated missions{until} ({by}); what is sound is run"


def main(arguments: Sequence[str] | None = None) -> int:
    """Hunt; gives the exit code."""
    options = _options(arguments)
    print(_says_what_it_does(options), flush=True)
    try:
        with tempfile.TemporaryDirectory(prefix="fuzz_missions_") as name:
            found = hunt(options, Path(name))
    except CannotJudgeError as error:
        print(f"fuzz_missions.py: {error}", file=sys.stderr)
        return 2
    if not found.tried and not found.found:
        print("fuzz_missions.py: no case was judged in this time; give it more", file=sys.stderr)
        return 2
    kinds = _counted(len(found.found), "kind")
    print(f"Found {kinds} of faults in the project." if found.found else "Found nothing.")
    print(json.dumps({"cases": found.tried, "sound": found.accepted, "findings": found.found}))
    return 1 if found.found else 0


if __name__ == "__main__":
    sys.exit(main())
