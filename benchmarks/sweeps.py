"""What a sweep costs besides its scenarios, and what becomes of it when parts are killed.

Run it as: python benchmarks/sweeps.py rate|memory|kills|resume [--help]

- ``rate``: scenarios a second on N workers against N times a loop in one process, and the time of
  a worker that is not a scenario's own. Rounds of both take turns.
- ``memory``: of the client and of each worker, while thousands of scenarios go by.
- ``kills``: workers, scheduler and client of a cluster are killed at random, round after round;
  all rows are compared with those of a loop in one process.
- ``resume``: how long it takes to tell what is left of 100,000 scenarios.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import random
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import replace
from itertools import islice
from pathlib import Path

from measuring import figure, spread

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.scenarios.runner import ScenarioProcess, prepare_process
from bt_mission.sweeps.base import BaseChanges, load_base
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.plan import SweepPlan
from bt_mission.sweeps.pool import PoolOptions, ScenarioPool
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.store import ResultStore
from bt_mission.sweeps.sweep import left
from bt_mission.sweeps.work import ScenarioWorker
from tests.support.killed_sweep import KilledSweep

SHORT = """\
mission: turn
world: empty_arena
tree:
  turn: {angle: "uniform(20, 60)"}
"""
VICTIMS = ("worker", "worker", "nanny", "scheduler", "client")


def plan_of(mission: Path, count: int, legs: int | None = None) -> SweepPlan:
    """Seeds of a mission."""
    changes = BaseChanges(set={} if legs is None else {"legs": legs})
    return SweepPlan(load_base(mission, changes), seeds=range(count))


# ---- rate ------------------------------------------------------------------------------------


async def rate(options: argparse.Namespace) -> None:
    """Compare N workers with N times a loop in one process."""
    plan = plan_of(options.mission, 10_000, options.legs or None)
    more = plan.scenarios()
    process = ScenarioProcess()
    shares, costs, virtual = [], [], []
    with ScenarioWorker(plan.base.bundle, process.run) as alone:
        alone.carry_out(next(more))
        async with ScenarioPool(plan.base.bundle, PoolOptions(options.workers)) as pool:
            await _timed(pool, islice(more, 2 * options.workers))  # loads what there is to load
            for number in range(options.rounds):
                watch = Stopwatch()
                serial = [alone.carry_out(one) for one in islice(more, options.count)]
                serial_s = watch.elapsed_s / options.count
                rows, pool_s = await _timed(pool, islice(more, options.count * options.workers))
                each_s = pool_s * options.workers / len(rows)
                own_s = sum(one.wall_s for one in rows) / len(rows)
                shares.append(serial_s / each_s)
                costs.append((each_s - own_s) / each_s)
                virtual += [one.virtual_s for one in (*serial, *rows)]
                print(
                    f"round {number}: in one process {1 / serial_s:.2f}/s; {options.workers} "
                    f"workers {options.workers / each_s:.2f}/s, {1e3 * (each_s - own_s):.1f} ms of "
                    f"{1e3 * each_s:.0f} ms are not the scenario's own",
                    flush=True,
                )
    figure("rate to that of loops in one process", shares)
    figure("share of a worker's time that is not a scenario's own", costs)
    print(f"scenarios of {spread(virtual, 1)} s of virtual time")
    print(
        f"rate on {options.workers} workers / {options.workers} x one process: {spread(shares, 3)}"
    )
    print(f"share of a worker's time that is not the scenario's own: {spread(costs, 4)}")


async def _timed(
    pool: ScenarioPool, scenarios: Iterable[ConcreteScenario]
) -> tuple[list[ScenarioRow], float]:
    watch = Stopwatch()
    rows = [row async for row in pool.rows(scenarios)]
    return rows, watch.elapsed_s


# ---- memory ----------------------------------------------------------------------------------


async def memory(options: argparse.Namespace) -> None:
    """Follow the memory of the client and of each worker."""
    with tempfile.TemporaryDirectory() as folder:
        mission = Path(folder) / "turn.yaml"
        mission.write_text(SHORT)
        plan = plan_of(mission, options.count)
        first: dict[str, float] = {}
        last: dict[str, float] = {}
        done = 0
        watch = Stopwatch()
        async with ScenarioPool(plan.base.bundle, PoolOptions(options.workers)) as pool:
            with ResultStore.create(Path(folder) / "results", plan.about) as store:
                async for row in pool.rows(plan.scenarios()):
                    store.add(row)
                    done += 1
                    last[row.worker] = _memory_mb(int(row.worker.rpartition(":")[2]))
                    last["client"] = _memory_mb(os.getpid())
                    if done == options.after:
                        first = dict(last)
                    if done % 500 == 0:
                        shown = ", ".join(f"{name} {mb:.0f} MB" for name, mb in last.items())
                        print(f"{done}: {shown}, {done / watch.elapsed_s:.1f}/s", flush=True)
    figure("growth of memory", (last[name] / before for name, before in first.items()))
    for name, before in first.items():
        print(f"{name}: {before:.1f} -> {last[name]:.1f} MB ({last[name] / before - 1:+.1%})")


def _memory_mb(pid: int) -> float:
    """The resident memory of a process, MB."""
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except OSError:
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


# ---- kills -----------------------------------------------------------------------------------


async def kills(options: argparse.Namespace) -> None:
    """Kill at random, and compare with a loop in one process."""
    wrong = 0
    for number in range(options.rounds):
        draws = random.Random(f"kills/{number}")
        with tempfile.TemporaryDirectory() as folder:
            mission = Path(folder) / "turn.yaml"
            mission.write_text(SHORT)
            sweep = KilledSweep(Path(folder), mission, ("--seeds", str(options.count)), draws)
            rows = sweep.run([draws.choice(VICTIMS) for _ in range(kills_of(options, draws))])
            plan = plan_of(mission, options.count)
            with ScenarioWorker(plan.base.bundle, ScenarioProcess().run) as alone:
                serial = [alone.carry_out(one) for one in plan.scenarios()]
        same = [(one.id, one.trace_sha256) for one in rows] == [
            (one.id, one.trace_sha256) for one in serial
        ]
        wrong += not same
        print(
            f"round {number}: killed {', '.join(sweep.killed)}: {'equal' if same else 'WRONG'}",
            flush=True,
        )
    figure("rounds with lost, doubled or different rows", wrong)
    print(f"{options.rounds} rounds, {wrong} with rows that were lost, doubled or different")


def kills_of(options: argparse.Namespace, draws: random.Random) -> int:
    """How often something is killed in a round."""
    return draws.randint(min(1, options.most_kills), options.most_kills)


# ---- resume ----------------------------------------------------------------------------------


async def resume(options: argparse.Namespace) -> None:
    """Tell what is left of a sweep of which half is done."""
    with tempfile.TemporaryDirectory() as folder:
        plan = plan_of(Path("missions/explore.yaml"), options.count, 1)
        with ScenarioWorker(plan.base.bundle, ScenarioProcess().run) as alone:
            row = alone.carry_out(plan.scenario(0))
        with ResultStore.create(Path(folder), plan.about) as store:
            watch = Stopwatch()
            for one in islice(plan.scenarios(), options.count // 2):
                store.add(replace(row, id=one.id, number=one.number))
            print(f"{options.count // 2:,} rows written one by one: {watch.elapsed_s:.1f} s")
            seconds = []
            for _ in range(options.rounds):
                watch = Stopwatch()
                missing = sum(1 for _ in left(plan, store))
                seconds.append(watch.elapsed_s)
    figure("what is left of a sweep is known after", seconds, "s")
    print(f"what is left of {options.count:,} ({missing:,}) is known after {spread(seconds, 2)} s")


def main() -> None:
    """Measure what is named."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    whats: dict[str, Callable[[argparse.Namespace], object]] = {
        "rate": rate,
        "memory": memory,
        "kills": kills,
        "resume": resume,
    }
    counts = {"rate": 30, "memory": 10_000, "kills": 16, "resume": 100_000}
    rounds = {"rate": 3, "memory": 1, "kills": 20, "resume": 3}
    parser.add_argument("what", choices=whats)
    parser.add_argument("--count", type=int, help="scenarios; of `rate` in a round and a process")
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument(
        "--legs", type=int, default=4, help="of the mission, with `rate`; 0 sets none"
    )
    parser.add_argument("--mission", type=Path, default=Path("missions/explore.yaml"))
    parser.add_argument("--most-kills", type=int, default=4, help="in a round of `kills`")
    parser.add_argument("--after", type=int, default=500, help="compare memory with that after N")
    options = parser.parse_args()
    options.count = options.count or counts[options.what]
    options.rounds = options.rounds or rounds[options.what]
    prepare_process()
    asyncio.run(whats[options.what](options))  # type: ignore[arg-type]


if __name__ == "__main__":
    main()
