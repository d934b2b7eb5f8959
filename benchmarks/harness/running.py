"""Benchmarks one after another, with a line of progress each; or two commits in turns."""

from __future__ import annotations

import asyncio
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness.benchmark import Benchmark
from benchmarks.harness.measurement import Given, Measurement
from benchmarks.harness.processes import FailedError, NotSoundError, Round, run_round
from benchmarks.harness.starting import ForkStarter, Starter
from benchmarks.harness.tree import Tree
from bt_mission.core.wall_clock import Stopwatch

SMOKE_LIMIT_S = 120.0
"""Wall time after which a process of the smoke has failed; a second or ten on a quiet machine."""

AGAINST_ROUNDS = 5
"""Rounds of a comparison: each is a process of both commits."""

BUSY = "while True: sum(range(10_000))"


@dataclass(frozen=True)
class Plan:
    """How the benchmarks are run.

    Args:
        new: The software of this checkout.
        old: Another commit, to be measured in turns with it.
        rounds: Of each benchmark; None leaves it to the benchmark.
        smoke: Only see whether they work.
        jobs: How many at a time; more than one spoils all figures.
    """

    new: Tree
    old: Tree | None = None
    rounds: int | None = None
    smoke: bool = False
    jobs: int = 1

    def rounds_of(self, benchmark: Benchmark) -> int:
        """Return how many rounds of a benchmark there are."""
        if self.smoke:
            return 1
        return self.rounds or (AGAINST_ROUNDS if self.old else benchmark.rounds)


class Runner:
    """Runs benchmarks by a plan, and tells of it on standard error."""

    def __init__(self, plan: Plan, benchmarks: Sequence[Benchmark]) -> None:
        self._plan = plan
        self._benchmarks = benchmarks
        self._scripts = plan.new.root / "benchmarks"
        self.done: list[Measurement] = []
        """What has been measured so far."""
        self._slots = list(range(plan.jobs))
        self._starter = _starter(plan)

    async def run(self) -> None:
        """Run all; what has failed is told in its measurement, and the others run."""
        free = asyncio.Semaphore(self._plan.jobs)

        async def one(benchmark: Benchmark) -> None:
            async with free:
                slot = self._slots.pop(0)
                try:
                    await self._run_one(benchmark, slot)
                finally:
                    self._slots.append(slot)

        try:
            async with asyncio.TaskGroup() as group:
                for each in self._benchmarks:
                    group.create_task(one(each))
        finally:
            await self._starter.close()

    async def _run_one(self, benchmark: Benchmark, slot: int) -> None:
        measurement, watch = Measurement(benchmark), Stopwatch()
        if self._plan.jobs == 1:
            self._tell(f"{benchmark.name}: {self._extent(benchmark)}")
        try:
            await self._measure(measurement, slot)
        except asyncio.CancelledError:
            if measurement.figures:  # rounds that are whole
                measurement.failures.append("interrupted")
                self.done.append(measurement)
            raise
        measurement.seconds = watch.elapsed_s
        self.done.append(measurement)
        failed = "".join(f"\n    {one}" for one in measurement.failures)
        state = "FAILED" if failed else "done"
        self._tell(f"{benchmark.name}: {state} in {measurement.seconds:.1f} s{failed}")

    def _extent(self, benchmark: Benchmark) -> str:
        if self._plan.smoke:
            return "a tiny run"
        rounds = self._plan.rounds_of(benchmark)
        times = f"{rounds} round{'s' * (rounds > 1)}"
        return f"{times} of both commits" if self._plan.old else f"{times}, {benchmark.takes}"

    def _tell(self, text: str) -> None:
        print(f"[{len(self.done)} of {len(self._benchmarks)}] {text}", file=sys.stderr, flush=True)

    async def _measure(self, into: Measurement, slot: int) -> None:
        if self._plan.old is not None:
            await self._compare(into, self._plan.old, slot)
            return
        how = Round(
            self._plan.rounds_of(into.benchmark),
            smoke=self._plan.smoke,
            quiet=self._plan.smoke,
            limit_s=SMOKE_LIMIT_S if self._plan.smoke else None,
            slot=slot,
        )
        try:
            found = await self._round(into, how, self._plan.new, self._scripts)
        except FailedError as error:
            if self._plan.smoke and isinstance(error, NotSoundError):
                self._tell(
                    f"{into.benchmark.name} works; what it found means nothing here: {error}"
                )
            else:
                into.failures.append(str(error))
            return
        into.add(found)
        into.failures += into.benchmark.complaints(found)

    async def _round(
        self, into: Measurement, how: Round, tree: Tree, scripts: Path
    ) -> dict[str, Given]:
        starter = self._starter
        return await run_round(into.benchmark, how, tree, scripts=scripts, starter=starter)

    async def _compare(self, into: Measurement, old: Tree, slot: int) -> None:
        """Measure both commits in turns; who comes first changes from round to round."""
        how = Round(
            smoke=self._plan.smoke,
            limit_s=SMOKE_LIMIT_S if self._plan.smoke else None,
            slot=slot,
        )
        rounds = self._plan.rounds_of(into.benchmark)
        for number in range(rounds):
            given: dict[str, Given] | None = None
            if number % 2:
                given = await self._old_round(into, how, old)
            try:
                found = await self._round(into, how, self._plan.new, self._scripts)
            except FailedError as error:
                into.failures.append(str(error))
                return
            if not number % 2:
                given = await self._old_round(into, how, old)
            into.add(found, given)
            self._tell(f"{into.benchmark.name}: round {number + 1} of {rounds}")
        given_here = [name for name, one in into.figures.items() if one.new]
        into.failures += into.benchmark.complaints(given_here)

    async def _old_round(self, into: Measurement, how: Round, old: Tree) -> dict[str, Given] | None:
        """Measure the other commit with the script of this one; where that fails, with its own."""
        if into.old_lacks:
            return None
        script = old.root / "benchmarks"
        if not into.old_script:
            try:
                return await self._round(into, how, old, self._scripts)
            except FailedError as error:
                reason = str(error).strip().splitlines()[-1].strip()
        try:
            found = await self._round(into, how, old, script)
        except FailedError as error:
            found, reason = {}, str(error).strip().splitlines()[-1].strip()
        if found:
            into.old_script = True
            return found
        into.old_lacks = f"{old.commit} lacks it: {reason}"
        self._tell(f"{into.benchmark.name}: {into.old_lacks}")
        return None


def _starter(plan: Plan) -> Starter | ForkStarter:
    """Figures are those of processes of their own; a smoke need not import everything each time."""
    if plan.smoke and plan.old is None:
        return ForkStarter(plan.new.environment())
    return Starter()


@contextmanager
def busy(count: int) -> Iterator[None]:
    """Keep so many processes computing beside the benchmarks."""
    started: list[subprocess.Popen[bytes]] = []
    try:
        started += [
            subprocess.Popen([sys.executable, "-S", "-c", BUSY])  # noqa: S603 - ourselves
            for _ in range(count)
        ]
        yield
    finally:
        for one in started:
            one.kill()
            one.wait()
