"""Workers of Dask distributed, on this machine or in a cluster, that carry scenarios out."""

from __future__ import annotations

import asyncio
from collections import Counter, deque
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Iterable, Iterator
from contextlib import AsyncExitStack, suppress
from dataclasses import replace
from itertools import count
from types import TracebackType
from typing import Any, Self, TypeAlias

from distributed import Client, KilledWorker, as_completed

from bt_mission.sweeps.bundle import Bundle
from bt_mission.sweeps.cluster import (
    CLOSE_S,
    PoolError,
    PoolOptions,
    connected,
    line_of,
    refusal,
    unfit_workers,
    why_unfit,
    workers_of,
)
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.row import ScenarioRow, row_of_error
from bt_mission.sweeps.tasks import BundlePlugin, UnfitWorkerError, about_worker, carry_out, record

AHEAD = 2
"""Scenarios that wait or run at each worker: one runs, the next is there when it has ended."""

MOST_TRIES = 2
"""A scenario is begun again so often where Dask itself fails with it."""

LOOK_S = 1.0
"""While no scenario ends, it looks so often whether the scheduler lives, s."""

Killed: TypeAlias = list[tuple[ConcreteScenario, int]]
"""Scenarios whose workers have died, and how many of them."""


class ScenarioPool:
    """Carries scenarios out on workers of Dask; use it as an asynchronous context manager.

    Results come back as they are made, and nothing is kept in the memory of a worker: a scenario
    whose worker dies is begun again on another one.

    Args:
        bundle: The files of all scenarios, which every worker is given.
        options: Where the workers are.
        on_wait: Called each second in which no scenario ends. It may be set later, too.
    """

    def __init__(
        self,
        bundle: Bundle,
        options: PoolOptions | None = None,
        on_wait: Callable[[], None] = lambda: None,
    ) -> None:
        self.on_wait = on_wait
        self._bundle = bundle
        self._options = options or PoolOptions()
        self._client: Client
        self._name: str
        self._has_dashboard = False
        self._stack = AsyncExitStack()
        self._tries = count()

    async def __aenter__(self) -> Self:
        async with self._stack:
            self._client = await self._stack.enter_async_context(connected(self._options))
            # Several sweeps may share workers: each has files and tasks of its own.
            self._name = f"bt-mission-{self._client.id}"
            await self._refuse_unfit_workers()
            await self._give_bundle()
            self._stack.push_async_callback(self._take_bundle_back)
            self._stack = self._stack.pop_all()
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self._stack.__aexit__(kind, error, trace)

    # ---- what it offers ------------------------------------------------------------------

    @property
    def workers(self) -> int:
        """How many workers there are now."""
        return int(self._client.scheduler_info(n_workers=0).get("n_workers", 0))

    @property
    def dashboard(self) -> str:
        """Link to Dask's dashboard; empty where there is none."""
        return str(self._client.dashboard_link) if self._has_dashboard else ""

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Carry scenarios out, and give what each came to, in the order in which they end.

        They are made as workers get free, so there may be any number of them. One that dies with
        its worker again and again is tried alone at the end; if it kills its worker there, too, it
        is told as an error. Where all workers are gone, it waits for others.

        Raises:
            PoolError: Where the scheduler is gone, or the last worker cannot take part.
        """
        suspects: Killed = []
        async for row in self._rows(iter(scenarios), self._room, suspects):
            yield row
        for scenario, before in suspects:
            alone: Killed = []
            async for row in self._rows(iter([scenario]), lambda: 1, alone):
                yield replace(row, attempts=row.attempts + before)
            for _, kills in alone:
                reason = f"it has killed its worker {kills} times, alone there"
                yield row_of_error(scenario, reason, attempts=2 * kills)

    async def recordings(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncIterator[tuple[ConcreteScenario, bytes, bytes]]:
        """Carry scenarios out once more, and give the recording of each with its page.

        Those that cannot be recorded are left out.
        """
        under_way = {self._submit(record, one, self._name): one for one in scenarios}
        ended = self._ended(list(under_way))
        for _ in range(len(under_way)):
            future, result = await self._next(ended)
            if future.status == "finished":
                yield under_way[future], *result
            future.release()

    # ---- scenarios -----------------------------------------------------------------------

    def _room(self) -> int:
        return AHEAD * max(self.workers, 1)

    async def _rows(
        self,
        scenarios: Iterator[ConcreteScenario],
        room: Callable[[], int],
        killed: Killed,
    ) -> AsyncIterator[ScenarioRow]:
        """Carry scenarios out.

        Args:
            room: How many may be under way.
            killed: Gets those that have killed their workers.
        """
        ended = self._ended([])
        under_way: dict[Any, ConcreteScenario] = {}
        again: deque[ConcreteScenario] = deque()
        errors: Counter[str] = Counter()
        wanted = about_worker()

        def fill() -> None:
            while len(under_way) < room():
                one = again.popleft() if again else next(scenarios, None)
                if one is None:
                    return
                future = self._submit(carry_out, one, self._name, wanted)
                under_way[future] = one
                ended.add(future)

        fill()
        while under_way:
            future, result = await self._next(ended)
            scenario = under_way.pop(future)
            if future.status == "finished":
                more = errors[scenario.id] + await self._deaths(future.key)
                yield replace(result, attempts=result.attempts + more)
            elif future.status == "error":
                error = await future.exception()
                if isinstance(error, KilledWorker):
                    killed.append((scenario, error.allowed_failures + 1))
                elif isinstance(error, UnfitWorkerError):
                    await self._retire(error)
                    again.append(scenario)
                elif errors[scenario.id] < MOST_TRIES:
                    errors[scenario.id] += 1
                    again.append(scenario)
                else:
                    yield row_of_error(scenario, f"{type(error).__name__}: {line_of(error)}")
            else:  # cancelled or lost: the scheduler has forgotten it
                self._refuse_lost()
                again.append(scenario)
            future.release()
            fill()

    def _submit(self, what: Callable[..., Any], scenario: ConcreteScenario, *more: Any) -> Any:
        # A key of its own for each try: Dask takes a key that it has for the same task.
        key = f"{self._name}-{scenario.id}-{next(self._tries)}"
        return self._client.submit(what, scenario, *more, key=key, pure=False)

    async def _deaths(self, key: str) -> int:
        """Return how many workers have died that a task had been given to.

        The function goes to the scheduler by value, since it need not have this package.
        """
        asked = self._client.run_on_scheduler(
            lambda dask_scheduler, key: getattr(dask_scheduler.tasks.get(key), "suspicious", 0),
            key=key,
        )
        with suppress(Exception):  # a scheduler that is gone knows of none
            return int(await asyncio.wait_for(asked, LOOK_S))
        return 0

    def _ended(self, futures: list[Any]) -> Any:
        return as_completed(futures, self._client.loop, with_results=True, raise_errors=False)

    async def _next(self, ended: Any) -> Any:
        """Wait for the next scenario to end, and look at times whether the scheduler lives."""
        waiting = asyncio.ensure_future(anext(ended))
        try:
            while True:
                done, _ = await asyncio.wait([waiting], timeout=LOOK_S)
                if done:
                    return waiting.result()
                self._refuse_lost()
                self.on_wait()
        finally:
            waiting.cancel()

    def _refuse_lost(self) -> None:
        status = self._client.status
        if status != "running":
            raise PoolError(
                f"the scheduler is gone (the connection is {status}); what has ended is kept"
            )

    # ---- workers -------------------------------------------------------------------------

    async def _refuse_unfit_workers(self) -> None:
        info = await self._client.scheduler.identity()
        is_wanted = self._options.scheduler is not None or self._options.dashboard is not None
        self._has_dashboard = is_wanted and "dashboard" in info["services"]
        if not info["workers"]:
            address = self._options.scheduler
            raise PoolError(
                f"{address}: the scheduler has no workers; start some with "
                f"`dask worker {address} --nthreads 1`"
            )
        unfit = await unfit_workers(self._client)
        if unfit:
            raise refusal(unfit, len(info["workers"]))

    async def _retire(self, unfit: UnfitWorkerError) -> None:
        """Send a worker away that has joined later and cannot take part.

        Raises:
            PoolError: Where no other is left.
        """
        await self._client.retire_workers([unfit.address])
        if not set(await workers_of(self._client)) - {unfit.address}:
            why = why_unfit(unfit.versions, unfit.threads) or "could not be set up"
            raise refusal({unfit.address: why}, 1)

    async def _give_bundle(self) -> None:
        plugin = BundlePlugin(self._bundle, self._options.scheduler is None)
        try:
            await self._client.register_plugin(plugin, self._name)
        except Exception as error:
            raise PoolError(f"a worker cannot be set up: {line_of(error)}") from error

    async def _take_bundle_back(self) -> None:
        if self._options.scheduler is None or self._client.status != "running":
            return
        with suppress(Exception):  # a scheduler that is gone has no plugins
            await asyncio.wait_for(self._client.unregister_worker_plugin(self._name), CLOSE_S)
