"""What a sweep costs besides its scenarios.

Run it as: python benchmarks/commands/sweep/sweeps.py --only rate|memory [--help]

- ``rate``: scenarios a second on N workers against N times a loop in one process, and the time of
  a worker that is not a scenario's own. Rounds of both take turns.
- ``memory``: of the client and of each worker, during thousands of scenarios.
"""

from __future__ import annotations

import asyncio
import os
import tempfile
from argparse import Namespace
from collections.abc import Iterable
from itertools import islice
from pathlib import Path

from benchmarks.measuring import arguments, figure, figures, process_usage, table
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.scenarios.concrete.base_scenario import BaseChanges, load_base
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.pool import PoolOptions, ScenarioPool
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.concrete.worker import ScenarioWorker
from bt_mission.scenarios.runner import ScenarioProcess, prepare_process

SHORT = "mission: turn\nworld: empty_arena\ntree: {turn: {angle: 'uniform(20, 60)'}}\n"
MOST = 10_000
"""Scenarios of a measurement of the rate."""


async def rate(options: Namespace) -> None:
    """Compare N workers with N times a loop in one process."""
    changes = BaseChanges(set={"legs": options.legs} if options.legs else {})
    plan = SweepPlan(load_base(options.mission, changes), seeds=range(MOST))
    more, workers = plan.scenarios(), options.workers
    shares, costs = [], []
    with ScenarioWorker(plan.base.bundle, ScenarioProcess().run) as alone:
        alone.carry_out(next(more))
        async with ScenarioPool(plan.base.bundle, PoolOptions(workers)) as pool:
            await _timed(pool, islice(more, 2 * workers))  # loads everything that is needed
            for _ in range(options.rounds):
                watch = Stopwatch()
                for scenario in islice(more, options.count):
                    alone.carry_out(scenario)
                serial_s = watch.elapsed_s / options.count
                rows, pool_s = await _timed(pool, islice(more, options.count * workers))
                each_s = pool_s * workers / len(rows)
                own_s = sum(row.wall_s for row in rows) / len(rows)
                shares.append(serial_s / each_s)
                costs.append((each_s - own_s) / each_s)
    figures(
        f"{workers} workers",
        {
            "rate to that of loops in one process": (shares, ""),
            "share of a worker's time that is not a scenario's own": (costs, ""),
        },
    )


async def _timed(
    pool: ScenarioPool, scenarios: Iterable[ConcreteScenario]
) -> tuple[list[ScenarioRow], float]:
    watch = Stopwatch()
    rows = [row async for row in pool.rows(scenarios)]
    return rows, watch.elapsed_s


async def memory(options: Namespace) -> None:
    """Follow the memory of the client and of each worker."""
    with tempfile.TemporaryDirectory() as folder:
        mission = Path(folder) / "turn.yaml"
        mission.write_text(SHORT, encoding="utf-8")
        plan = SweepPlan(load_base(mission, BaseChanges()), seeds=range(options.many))
        first: dict[str, float] = {}
        last: dict[str, float] = {}
        async with ScenarioPool(plan.base.bundle, PoolOptions(options.workers)) as pool:
            with ResultStore.create(Path(folder) / "results", plan.about) as store:
                done = 0
                async for row in pool.rows(plan.scenarios()):
                    store.add(row)
                    done += 1
                    for name, pid in (
                        (row.worker, row.worker.rpartition(":")[2]),
                        ("client", os.getpid()),
                    ):
                        last[name] = process_usage(int(pid))[1] / 1e6
                    if done == options.after:
                        first = dict(last)
    figure("growth of memory", (last[name] / before for name, before in first.items()))
    rows = [(name, f"{mb:.1f} MB", f"{last[name]:.1f} MB") for name, mb in first.items()]
    table(("process", f"after {options.after} scenarios", "at the end"), rows)


def main() -> None:
    """Run the measurement that is named."""
    options = arguments(
        __doc__,
        only={"rate": rate, "memory": memory},
        count=(30, "scenarios of `rate` in a round and a process"),
        many=(10_000, "scenarios of `memory`"),
        rounds=3,
        workers=os.cpu_count() or 1,
        legs=(4, "of the mission; 0 sets none"),
        mission=Path("missions/explore.yaml"),
        after=(500, "compare memory with that after N"),
    )
    prepare_process()
    for part in options.only:
        asyncio.run(part(options))


if __name__ == "__main__":
    main()
