"""Workers that come, go, and cannot take part: a cluster of Dask within this process."""

from __future__ import annotations

import asyncio
import inspect
from collections.abc import AsyncIterator, Callable, Coroutine
from contextlib import asynccontextmanager
from typing import Any

import pytest
from distributed import Scheduler, Worker, get_worker

from bt_mission.base.errors import BtMissionError
from bt_mission.scenarios.concrete import pool as pool_module
from bt_mission.scenarios.concrete import worker as work
from bt_mission.scenarios.concrete.bundle import Bundle
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.pool import PoolOptions, ScenarioPool, why_unfit
from bt_mission.scenarios.concrete.row import ScenarioRow
from tests.support.rows import row

OTHER = "other"
"""What workers are called that have another version."""

EMPTY = Bundle({}, "missions/m.yaml", {}, {})
HERE = pool_module.about_worker()


class FakeScenarios:
    """Says which worker and which bundle a scenario has met."""

    def __init__(self, bundle: Bundle, _: Any) -> None:
        self.bundle = bundle

    def carry_out(self, scenario: ConcreteScenario) -> ScenarioRow:
        """Return a row without a run."""
        return row(scenario.number, worker=str(get_worker().name), plan=self.bundle.mission)

    def close(self) -> None:
        """It has no folder."""


def versions_there() -> dict[str, str]:
    """The versions of the worker that asks; of the client those that are here."""
    try:
        is_other = get_worker().name == OTHER
    except ValueError:
        return HERE
    return {**HERE, "mujoco": "1.0.0"} if is_other else HERE


def scenarios(count: int) -> list[ConcreteScenario]:
    """So many scenarios of nothing."""
    return [ConcreteScenario(number, {"seed": number}) for number in range(count)]


class FakeCluster:
    """A scheduler, to which workers can be added."""

    def __init__(self, scheduler: Scheduler) -> None:
        self.scheduler = scheduler
        self.options = PoolOptions(scheduler=scheduler.address)
        self.workers: list[Worker] = []

    async def add(self, name: str, threads: int = 1) -> Worker:
        """Start a worker."""
        worker = await Worker(
            self.options.scheduler, name=name, nthreads=threads, dashboard_address=None
        )
        self.workers.append(worker)
        return worker


@asynccontextmanager
async def cluster() -> AsyncIterator[FakeCluster]:
    """A scheduler without workers."""
    async with Scheduler(host="127.0.0.1", port=0, dashboard_address="127.0.0.1:0") as scheduler:
        made = FakeCluster(scheduler)
        try:
            yield made
        finally:
            for worker in made.workers:
                await worker.close()


@pytest.fixture(autouse=True)
def _without_simulation(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(work, "ScenarioWorker", FakeScenarios)
    monkeypatch.setattr(pool_module, "_scenario_process", lambda: FakeProcess)
    monkeypatch.setattr(pool_module, "about_worker", versions_there)


class FakeProcess:
    """Runs nothing."""

    run = None


def in_cluster(test: Callable[..., Coroutine[Any, Any, None]]) -> Callable[..., None]:
    """Have a test run on a cluster of its own, its argument ``made``."""
    signature = inspect.signature(test)
    fixtures = [its for name, its in signature.parameters.items() if name != "made"]

    def run(**values: Any) -> None:
        async def main() -> None:
            async with cluster() as made:
                await test(made=made, **values)

        asyncio.run(asyncio.wait_for(main(), 60))

    run.__name__, run.__doc__ = test.__name__, test.__doc__
    run.__signature__ = signature.replace(parameters=fixtures)  # type: ignore[attr-defined]
    return run


@in_cluster
async def test_a_worker_of_another_version_that_joins_late_is_sent_away(made: FakeCluster) -> None:
    """What it was given is carried out elsewhere."""
    await made.add("first")
    async with ScenarioPool(EMPTY, made.options) as pool:
        other = await made.add(OTHER)
        rows = [done async for done in pool.rows(scenarios(12))]
        assert sorted(done.number for done in rows) == list(range(12))
        assert {done.worker for done in rows} == {"first"}
        await other.finished()


@in_cluster
async def test_the_last_worker_is_of_another_version(made: FakeCluster) -> None:
    """It ends with what that worker has, and does not ask it for ever."""
    first = await made.add("first")
    async with ScenarioPool(EMPTY, made.options) as pool:
        await first.close()
        await made.add(OTHER)
        with pytest.raises(BtMissionError, match=r"mujoco 1\.0\.0 \(here \d"):
            [done async for done in pool.rows(scenarios(3))]


@in_cluster
async def test_without_workers_it_waits_for_others(made: FakeCluster) -> None:
    """It looks on while it waits."""
    first = await made.add("first")
    async with ScenarioPool(EMPTY, made.options) as pool:
        await first.close()
        waits: list[int] = []
        started: list[asyncio.Task[Worker]] = []

        def on_wait() -> None:
            waits.append(pool.workers)
            if pool.workers == 0 and not started:
                started.append(asyncio.ensure_future(made.add("second")))

        pool.on_wait = on_wait
        rows = [done async for done in pool.rows(scenarios(3))]
        assert {done.worker for done in rows} == {"second"}
        assert 0 in waits


@in_cluster
async def test_two_sweeps_share_workers(made: FakeCluster) -> None:
    """Each has files and tasks of its own, also for scenarios that are called the same."""
    await made.add("first")
    other = Bundle({}, "missions/other.yaml", {}, {})
    async with ScenarioPool(EMPTY, made.options) as first:
        async with ScenarioPool(other, made.options) as second:
            rows = await asyncio.gather(*(_all(pool) for pool in (first, second)))
        assert [{each.plan for each in part} for part in rows] == [{EMPTY.mission}, {other.mission}]
        assert [each.plan for each in await _all(first)] == [EMPTY.mission] * 4, (
            "the second has taken the files of the first away"
        )


async def _all(pool: ScenarioPool) -> list[ScenarioRow]:
    return [done async for done in pool.rows(scenarios(4))]


@pytest.mark.parametrize(
    ("name", "threads", "message"),
    [
        (None, 1, "the scheduler has no workers; start some with `dask worker tcp://"),
        ("first", 2, r"1 of 1 workers cannot take part, .* has 2 threads, .* with --nthreads 1"),
    ],
)
@in_cluster
async def test_who_is_refused_at_the_start(
    made: FakeCluster, name: str | None, threads: int, message: str
) -> None:
    """In words that say what to do."""
    if name:
        await made.add(name, threads)
    with pytest.raises(BtMissionError, match=message):
        async with ScenarioPool(EMPTY, made.options):
            pass


def test_a_scheduler_of_another_version(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is refused before Dask has a chance to misunderstand it."""
    there = {"packages": {"dask": HERE["dask"], "distributed": "2020.1.0"}}
    monkeypatch.setattr(Scheduler, "versions", lambda _: there)

    @in_cluster
    async def test(made: FakeCluster) -> None:
        with pytest.raises(BtMissionError, match=r"has distributed 2020\.1\.0 \(here 20"):
            async with ScenarioPool(EMPTY, made.options):
                pass

    test()


@pytest.mark.parametrize(
    ("result", "why"),
    [
        (HERE, ""),
        (OSError("gone"), ""),
        (ModuleNotFoundError("No module named 'bt_mission'"), "has no bt-mission"),
        (
            Exception("ModuleNotFoundError(\"No module named 'bt_mission.commands.sweep'\")"),
            "has another bt-mission, or a broken one (",
        ),
        ("0123456789ab", "has another bt-mission"),
        ({**HERE, "python": "3.9.1"}, "has python 3.9.1 (here 3."),
        (
            {**HERE, pool_module.SOURCES: "0"},
            "has a bt-mission with other sources or shipped missions",
        ),
    ],
)
def test_what_is_said_of_a_worker(result: Any, why: str) -> None:
    """Nothing where it can take part, or is gone."""
    reported = why_unfit(result, 1)
    assert reported.startswith(why)
    assert bool(reported) == bool(why)


@in_cluster
async def test_workers_keep_no_profile_while_they_take_part(made: FakeCluster) -> None:
    """Dask's would grow for an hour; afterwards it goes on."""
    worker = await made.add("first")
    profilers = [worker.periodic_callbacks[name] for name in pool_module.PROFILERS]
    assert [profiler.is_running() for profiler in profilers] == [True, True]
    async with ScenarioPool(EMPTY, made.options):
        assert [profiler.is_running() for profiler in profilers] == [False, False]
    assert [profiler.is_running() for profiler in profilers] == [True, True]


@in_cluster
async def test_a_row_tells_how_often_its_worker_died(
    made: FakeCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was begun again elsewhere; rows of workers that live were begun once."""
    loop = asyncio.get_running_loop()
    carry_out = FakeScenarios.carry_out

    def dying(self: FakeScenarios, scenario: ConcreteScenario) -> ScenarioRow:
        worker = get_worker()
        if worker.name == "doomed":
            removal = made.scheduler.remove_worker(worker.address, stimulus_id="it died")
            asyncio.run_coroutine_threadsafe(removal, loop).result()
        return carry_out(self, scenario)

    monkeypatch.setattr(FakeScenarios, "carry_out", dying)
    await made.add("doomed")
    async with ScenarioPool(EMPTY, made.options) as pool:
        await made.add("lasting")
        rows = [done async for done in pool.rows(scenarios(12))]
    assert sorted(done.number for done in rows) == list(range(12))
    assert {done.worker for done in rows} == {"lasting"}
    assert sorted({done.attempts for done in rows}) == [1, 2]
