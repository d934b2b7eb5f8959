"""Runs benchmarks one after another, with a line of progress each; or two commits in turns."""

from __future__ import annotations

import asyncio
import json
import os
import signal
import statistics
import sys
import tempfile
from collections.abc import Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from types import ModuleType

from benchmarks.harness.catalogue import Benchmark
from benchmarks.harness.tree import ROOT, Tree
from benchmarks.measuring import FIGURES_FILE, NOT_SOUND
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.testing.live_graph import own_domain

AGAINST_ROUNDS = 5
"""Rounds of a comparison: each is a process of both commits."""
SMOKE_LIMIT_S = 300.0
"""Wall time after which a process of the smoke has failed; in CI tests run beside it."""
LAST_LINES = 12
"""Lines of output that are shown of a failed process."""

FORKS = get_context("forkserver")
"""Scripts of the smoke are forks of a process that has imported what most of them need: a start of
Python with ROS, NumPy and MuJoCo costs more than what the smoke of a script does.
"""
IMPORTED = (
    "bt_mission.commands.run",
    "bt_mission.scenarios.run",
    "bt_mission.sessions.stage",
    __name__,
)


class FailedError(Exception):
    """A process has failed; the message has the end of its output."""


class NotSoundError(FailedError):
    """A campaign ran and has findings."""


@dataclass(frozen=True)
class Plan:
    """How benchmarks run: `old` is measured in turns with `new`; `rounds` None is their default."""

    new: Tree
    old: Tree | None = None
    rounds: int | None = None
    smoke: bool = False
    jobs: int = 1

    def rounds_of(self, benchmark: Benchmark) -> int:
        """Return the number of rounds of a benchmark."""
        if self.smoke:
            return 1
        return self.rounds or (AGAINST_ROUNDS if self.old else benchmark.rounds)


@dataclass
class Figure:
    """The values of one figure, round by round; `ratios` are new to old, of the same round."""

    unit: str
    new: list[float] = field(default_factory=list)
    old: list[float] = field(default_factory=list)
    ratios: list[float] = field(default_factory=list)


@dataclass
class Measurement:
    """The figures of a benchmark, its failures, and remarks on the other commit."""

    benchmark: Benchmark
    figures: dict[str, Figure] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    remark: str = ""

    def add(self, new: dict[str, Figure], old: dict[str, Figure] | None = None) -> None:
        """Add the figures of a round; `old` are those of the other commit, measured beside it."""
        for name, given in {**(old or {}), **new}.items():
            figure = self.figures.setdefault(name, Figure(given.unit))
            here = new[name].new if name in new else []
            there = old[name].new if old and name in old else []
            figure.new += here
            figure.old += there
            if here and there and statistics.median(there):
                figure.ratios.append(statistics.median(here) / statistics.median(there))


class Runner:
    """Runs benchmarks by a plan; progress goes to standard error."""

    def __init__(self, plan: Plan, benchmarks: Sequence[Benchmark]) -> None:
        self._plan = plan
        self._benchmarks = benchmarks
        self.done: list[Measurement] = []

    async def run(self) -> None:
        """Run all; a failure is noted in its measurement, and the others run."""
        free = asyncio.Semaphore(self._plan.jobs)
        FORKS.set_forkserver_preload(list(IMPORTED))

        async def run_in_slot(benchmark: Benchmark) -> None:
            async with free:
                with own_domain() if self._plan.jobs > 1 else nullcontext() as domain:
                    await self._run_benchmark(benchmark, domain)

        async with asyncio.TaskGroup() as group:
            for each in self._benchmarks:
                group.create_task(run_in_slot(each))

    async def _run_benchmark(self, benchmark: Benchmark, domain: int | None) -> None:
        measurement, watch = Measurement(benchmark), Stopwatch()
        if self._plan.jobs == 1:
            both = " of both commits" if self._plan.old else ""
            rounds = self._plan.rounds_of(benchmark)
            self._report(f"{benchmark.name}: rounds{both}: {rounds}; usually {benchmark.takes}")
        try:
            if self._plan.old is None:
                await self._measure(measurement, domain)
            else:
                await self._compare(measurement, self._plan.old)
        except FailedError as error:
            measurement.failures.append(str(error))
        except asyncio.CancelledError:
            if measurement.figures:  # of whole rounds
                measurement.failures.append("interrupted")
                self.done.append(measurement)
            raise
        self.done.append(measurement)
        failed = "".join(f"\n    {failure}" for failure in measurement.failures)
        state = "FAILED" if failed else "done"
        self._report(f"{benchmark.name}: {state} in {watch.elapsed_s:.1f} s{failed}")

    def _report(self, text: str) -> None:
        print(f"[{len(self.done)} of {len(self._benchmarks)}] {text}", file=sys.stderr, flush=True)

    async def _measure(self, into: Measurement, domain: int | None) -> None:
        plan, benchmark = self._plan, into.benchmark
        try:
            into.add(await self._round(benchmark, plan.new, domain=domain))
        except NotSoundError as error:
            if not plan.smoke:
                raise
            # A finding may come from the load of the machine; the smoke only shows that it works.
            self._report(f"{benchmark.name} works; its findings mean nothing here: {error}")
            return
        if not (into.figures or benchmark.may_give_none):
            into.failures.append("it has given no figure")

    async def _compare(self, into: Measurement, old: Tree) -> None:
        """Measure both commits in turns; which is first alternates."""
        rounds = self._plan.rounds_of(into.benchmark)
        for number in range(rounds):
            before = await self._old_round(into, old) if number % 2 else None
            new = await self._round(into.benchmark, self._plan.new, rounds=1)
            into.add(new, before if number % 2 else await self._old_round(into, old))
            self._report(f"{into.benchmark.name}: round {number + 1} of {rounds}")

    async def _old_round(self, into: Measurement, old: Tree) -> dict[str, Figure] | None:
        """Measure the other commit with the scripts of this one; if they fail, with its own."""
        scripts = [self._plan.new.root, old.root]
        own = f"the script of {old.commit} has measured it"
        if into.remark:
            scripts = [old.root] if into.remark == own else []
        for root in scripts:
            try:
                figures = await self._round(into.benchmark, old, rounds=1, scripts=root)
            except FailedError as error:
                reason = str(error).strip().splitlines()[-1].strip()
                continue
            into.remark = own if root == old.root else ""
            return figures
        if scripts:
            into.remark = f"{old.commit} lacks it: {reason}"
        return None

    async def _round(
        self,
        benchmark: Benchmark,
        tree: Tree,
        *,
        rounds: int = 0,
        scripts: Path | None = None,
        domain: int | None = None,
    ) -> dict[str, Figure]:
        """Start the processes of a benchmark one after another. Return their figures.

        Raises:
            FailedError: Where one ends with an error, takes too long or measures something else.
        """
        plan = self._plan
        with tempfile.TemporaryDirectory(prefix="benchmark_") as name:
            folder = Path(name)
            file, is_quiet = folder / "figures.jsonl", plan.smoke or plan.old is not None
            output = folder / "output" if is_quiet else None
            environment = _environment(tree, domain) | {FIGURES_FILE: str(file)}
            rounds = rounds or plan.rounds_of(benchmark)
            for script, *arguments in benchmark.commands(rounds, folder, smoke=plan.smoke):
                command = [str((scripts or plan.new.root) / script), *arguments]
                try:
                    async with asyncio.timeout(SMOKE_LIMIT_S if plan.smoke else None):
                        run = _run_fork if plan.smoke and tree.root == ROOT else _run
                        code = await run(command, tree.root, environment, output)
                except TimeoutError:
                    end = _end_of(output)
                    raise FailedError(f"{script}: not done in {SMOKE_LIMIT_S:g} s{end}") from None
                if code:
                    ended = f"exit code {code}" if code > 0 else f"signal {-code}"
                    kind = NotSoundError if code == NOT_SOUND else FailedError
                    raise kind(f"{script} ended with {ended}{_end_of(output)}")
            return read_figures(file, tree.root)


def _environment(tree: Tree, domain: int | None) -> dict[str, str]:
    variables = tree.environment() | {"PYTHONUNBUFFERED": "1"}
    variables.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if domain is not None:  # of those that run at the same time, each has its own ROS domain
        variables["ROS_DOMAIN_ID"] = str(domain)
    return variables


async def _run(
    command: list[str], folder: Path, environment: dict[str, str], output: Path | None
) -> int:
    """Run a script to its end; in any case, kill its remaining processes."""
    with (output or Path(os.devnull)).open("wb") as file:
        process = await asyncio.create_subprocess_exec(
            sys.executable,
            *command,
            cwd=folder,
            env=environment,
            stdin=asyncio.subprocess.DEVNULL,
            stdout=file if output else None,
            stderr=file if output else None,
            start_new_session=True,
        )
    try:
        return await process.wait()
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        await process.wait()


async def _run_fork(
    command: list[str], folder: Path, environment: dict[str, str], output: Path | None
) -> int:
    """Run a script in a fork to its end; in any case, kill its remaining processes."""
    process = FORKS.Process(target=_become, args=(command, folder, environment, output))
    process.start()
    assert process.pid is not None
    ended, loop = asyncio.Event(), asyncio.get_running_loop()
    loop.add_reader(process.sentinel, ended.set)
    try:
        await ended.wait()
    finally:
        loop.remove_reader(process.sentinel)
        process.kill()
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.join()
    return process.exitcode or 0


def _become(command: list[str], folder: Path, environment: dict[str, str], output: Path) -> None:
    """Be the process of a script."""
    os.setsid()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    file = os.open(output, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for stream in (1, 2):
        os.dup2(file, stream)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = command
    sys.path[0] = str(Path(command[0]).parent)
    # As Python itself runs a file; a script's own processes find their functions in it.
    module = ModuleType("__main__")
    module.__file__ = command[0]
    sys.modules["__main__"] = sys.modules["__mp_main__"] = module
    exec(compile(Path(command[0]).read_bytes(), command[0], "exec"), module.__dict__)  # noqa: S102


def _end_of(output: Path | None) -> str:
    """Return the last lines that a process has printed, each indented."""
    if output is None:
        return ""
    lines = output.read_text(encoding="utf-8", errors="replace").splitlines()[-LAST_LINES:]
    return "".join(f"\n    {line}" for line in lines)


def read_figures(path: Path, code: Path) -> dict[str, Figure]:
    """Read the figures of processes.

    Args:
        path: The file that they wrote to.
        code: The tree whose software was to be measured.

    Raises:
        FailedError: Where they imported another one.
    """
    figures: dict[str, Figure] = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        record = json.loads(line)
        if Path(record["code"]) != code / "bt_mission":
            raise FailedError(
                f"expected to measure {code / 'bt_mission'}, got {record['code'] or 'none'}: "
                "this Python has another copy installed; use the environment of this checkout"
            )
        figures.setdefault(record["figure"], Figure(record["unit"])).new.extend(record["values"])
    return figures
