"""Mutates what comes from outside, and looks for what does not get what it deserves.

Never a traceback, a hang, more than 200 MB, or an answer that is wrong without a word. The targets:

- missions: mission files, checked; what is sound is run against servers that answer by luck.
- recordings: recordings and traces, read by `replay`, `report` and `diff`.
- trees: BehaviorTree.CPP's and Nav2's XML, converted there and back.
- goals: what action servers, services and foreign peers answer to a running mission.
- controls: services and parameters by which people hold a mission, and goals of execute_mission.
- servers: goals and sensor messages that the action servers get.
- models: MuJoCo models of robots, checked; a valid one drives.

The cases follow from the seed and the corpus, which begins in tests/fuzz/corpus. Each finding is
saved, with its reason. With --state a hunt goes on where it ended.

It ends with 0 where nothing was found, with 1 where something was, with 2 where it cannot judge.

Run it as: python tools/fuzz.py --seconds 60
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

from tests.support.fuzz.targets import MODULES, target_of  # noqa: E402 - as below
from tests.support.fuzz.workers import Files, Mutants, Worker  # noqa: E402 - from the root

ENDLESS = 2**62


class CannotJudgeError(Exception):
    """The hunt itself does not work: nothing can be said of the missions, good or bad."""


@dataclass
class Hunt:
    """What was done, and what was found: by kind, each once."""

    options: argparse.Namespace
    before: int = 0
    """Cases of earlier times, where one goes on."""
    tried: int = 0
    inputs: int = 0
    """Files and messages in these cases."""
    accepted: int = 0
    findings: dict[str, int] = field(default_factory=dict)

    def hear(self, worker: Worker) -> bool:
        """Take in what a process says; false once it has no more cases."""
        try:
            what, kind, two = worker.receiver.recv()
        except (EOFError, OSError):
            self.mourn(worker)
            worker.start()
            return True
        worker.asleep = 0
        if what == "begun":
            worker.number, worker.name, worker.began = kind, two, True
        elif what == "found":
            self.note(worker, *kind, two)
        elif what == "done":
            self.tried += 1
            self.inputs += kind
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
        self.findings[kind] = self.findings.get(kind, 0) + 1
        if self.findings[kind] > 1 and not self.options.replay:
            return
        print(f"\nFOUND: {kind}\n{text}", flush=True)
        if self.options.replay:
            return
        self.options.save.mkdir(parents=True, exist_ok=True)
        suffix = Path(worker.name).suffix
        name = f"{self.options.target}_{self.options.seed}_{worker.number}{suffix}"
        path = self.options.save / name
        path.write_bytes(contents)
        path.with_suffix(".txt").write_text(f"{kind}\n{text}\n", encoding="utf-8")
        print(f"repeat it: python tools/fuzz.py --replay {path}", flush=True)

    def line(self, seconds: int) -> str:
        """Return how far it is."""
        share = 100 * self.accepted / max(self.tried, 1)
        rate = (self.tried - self.before) / max(seconds, 1)
        kinds = f"{_counted(len(self.findings), 'kind')} of findings"
        many = "" if self.inputs == self.tried else f" of {self.inputs} inputs"
        what = f"{self.options.target}, {seconds} s: {self.tried} cases{many}, {rate:.0f}/s"
        return f"{what}, {share:.0f} % sound, {kinds}"

    def keep(self, workers: list[Worker]) -> None:
        """Write down how far it is, to go on from there another time."""
        if self.options.state is None:
            return
        # The last numbers of all processes but the slowest are judged again.
        numbers = [worker.number for worker in workers if worker.number >= 0]
        first = min(numbers) + 1 if numbers else self.options.first
        state = {
            "target": self.options.target,
            "seed": self.options.seed,
            "first": first,
            "cases": self.tried,
            "inputs": self.inputs,
            "sound": self.accepted,
            "findings": self.findings,
        }
        temporary = self.options.state.with_suffix(".new")
        temporary.write_text(json.dumps(state), encoding="utf-8")
        temporary.replace(self.options.state)

    def go_on(self) -> None:
        """Take up what was written down."""
        options = self.options
        if options.state is None or not options.state.exists():
            return
        state = json.loads(options.state.read_text(encoding="utf-8"))
        if (state["target"], state["seed"]) != (options.target, options.seed):
            raise CannotJudgeError(f"{options.state} is of another target or another seed")
        options.first, self.findings = state["first"], state["findings"]
        options.end = options.first + options.count
        self.tried = self.before = state["cases"]
        self.inputs, self.accepted = state["inputs"], state["sound"]


def hunt(options: argparse.Namespace, folder: Path) -> Hunt:
    """Run the processes until the time is over or no case is left."""
    search = Hunt(options)
    search.go_on()
    workers = []
    for index in range(options.processes):
        cases: Any = Mutants(options.seed, options.first + index, options.processes, options.end)
        if options.replay:
            cases = Files(tuple(options.replay), index, options.processes)
        workers.append(Worker(folder / str(index), options.target, cases))
    for worker in workers:
        worker.start()
    everyone, seconds = tuple(workers), 0
    ticker, tick = _every_second()
    try:
        while workers and (options.seconds is None or seconds < options.seconds):
            there = wait([ticker, *(worker.receiver for worker in workers)])
            if ticker in there:
                ticker.recv()
                is_judging = any(worker.began or worker.starts > 1 for worker in everyone)
                seconds += is_judging
                if is_judging and seconds % options.every == 0:
                    print(search.line(seconds), flush=True)
                    search.keep(workers)
                for worker in workers:
                    worker.look(options.patience)
            workers = [kept for kept in workers if kept.receiver not in there or search.hear(kept)]
    except KeyboardInterrupt:
        print("interrupted", flush=True)
    finally:
        tick.terminate()
        for worker in workers:
            worker.process.kill()  # it may be in a case that hears nothing
            worker.process.join()
    search.keep(list(everyone))
    print(search.line(seconds), flush=True)
    return search


def _every_second() -> tuple[Connection, Any]:
    """Return what says something each second, and its process."""
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_tick, args=(sender,), daemon=True)
    process.start()
    sender.close()
    return receiver, process


def _tick(sender: Connection) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGALRM, lambda *_: sender.send(1))
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
        description="Mutates what comes from outside and looks for what crashes, takes too long "
        "or too much, or is answered wrongly without a word.",
        epilog="Ends with 0 where nothing was found, with 1 where something was, and with 2 where "
        "it cannot judge. Ctrl-C ends it early.",
    )
    add = parser.add_argument
    add(
        "--target",
        choices=(*MODULES, "all"),
        help="what is fuzzed (default: missions; of --replay, what the files are); all: one after "
        "the other, missions for half of the time",
    )
    add("--seconds", type=_positive, help="stop after this time (default: never)")
    add("--count", type=_positive, default=ENDLESS, help="stop after so many cases")
    add("--seed", type=int, default=1, help="the cases follow from it (default: 1)")
    add("--first", type=int, default=0, help="the number of the first case")
    add("--processes", type=_positive, default=os.cpu_count() or 1)
    add("--every", type=_positive, default=10, help="seconds between lines of progress")
    add("--patience", type=_positive, default=20, help="seconds for which a case may sleep")
    add("--save", type=Path, default=Path("fuzz_findings"), help="folder for what is found")
    add("--replay", type=_file, nargs="+", help="judge these files instead of mutated ones")
    add("--state", type=Path, metavar="FILE", help="go on from this file, and keep it up to date")
    options = parser.parse_args(arguments)
    options.target = options.target or (target_of(options.replay[0]) if options.replay else None)
    options.target = options.target or next(iter(MODULES))
    if options.target == "all" and (options.replay or options.state or not options.seconds):
        parser.error("--target all: takes --seconds, and neither --replay nor --state")
    options.end = options.first + options.count
    return options


def _says_what_it_does(options: argparse.Namespace) -> str:
    """Return what is begun, in a line."""
    if options.replay:
        return f"Judging {_counted(len(options.replay), 'file')}"
    many = "" if options.count == ENDLESS else f"{options.count:,} "
    until = f" for {options.seconds} s" if options.seconds else ""
    by = f"seed {options.seed}, processes: {options.processes}"
    return f"Judging {many}mutated {options.target}{until} ({by})"


def main(arguments: Sequence[str] | None = None) -> int:
    """Hunt; gives the exit code."""
    options = _options(arguments)
    if options.target != "all":
        return _judge(options)
    shares = {
        name: options.seconds // (2 if name == next(iter(MODULES)) else 2 * len(MODULES) - 2)
        for name in MODULES
    }
    chosen = (
        {**vars(options), "target": name, "seconds": max(seconds, 1)}
        for name, seconds in shares.items()
    )
    return max([_judge(argparse.Namespace(**choice)) for choice in chosen])


def _judge(options: argparse.Namespace) -> int:
    """Hunt in one target; gives the exit code."""
    print(_says_what_it_does(options), flush=True)
    try:
        with tempfile.TemporaryDirectory(prefix="fuzz_") as name:
            search = hunt(options, Path(name))
    except CannotJudgeError as error:
        print(f"fuzz.py: {error}", file=sys.stderr)
        return 2
    if not search.tried and not search.findings:
        print("fuzz.py: no case was judged in this time; give it more", file=sys.stderr)
        return 2
    kinds = _counted(len(search.findings), "kind")
    print(f"Found {kinds} of faults in the project." if search.findings else "Found nothing.")
    came = {"cases": search.tried, "inputs": search.inputs, "sound": search.accepted}
    print(json.dumps({**came, "findings": search.findings}))
    return 1 if search.findings else 0


if __name__ == "__main__":
    sys.exit(main())
