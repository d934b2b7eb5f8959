"""Workers of Dask distributed, on this machine or in a cluster, that carry scenarios out."""

from __future__ import annotations

import asyncio
import logging
import os
import signal
from collections import deque
from collections.abc import AsyncGenerator, AsyncIterator, Iterable, Iterator
from contextlib import AsyncExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, Self

from dask.utils import parse_bytes
from distributed import (
    Client,
    Future,
    KilledWorker,
    LocalCluster,
    WorkerPlugin,
    as_completed,
    get_worker,
)
from distributed.comm import parse_address
from distributed.comm.registry import get_backend

from bt_mission.core.errors import BtMissionError
from bt_mission.sweeps.bundle import Bundle
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.row import ScenarioRow, row_of_error
from bt_mission.sweeps.versions import fingerprint, told

MOST_KILLS = 3
"""A scenario that has killed so many workers is marked, and not tried again."""

WORKER_MEMORY = "2GiB"
"""What a worker on this machine may take; one that takes 95 % of it is ended, and its scenario
begun again elsewhere. A simulation takes 0.3 to 0.4 GB, with its camera 0.2 GB more."""

LEAST_MEMORY = 100_000_000

AHEAD = 2
"""Scenarios that wait or run at each worker: one runs, the next is there when it has ended."""

PLUGIN = "bt-mission"
CONNECT_S = "10s"
LOST_S = 15.0
"""So long a scheduler may be silent before it counts as lost, s."""


class PoolError(BtMissionError):
    """Workers that are not there, or cannot be used; it says what to do."""


def memory(text: str) -> str:
    """Return an amount of memory, such as ``2GiB``, as it is written.

    Raises:
        PoolError: Where it is none.
    """
    try:
        amount = parse_bytes(text)
    except ValueError:
        amount = 0
    if amount < LEAST_MEMORY:
        raise PoolError(f"--worker-memory: expected an amount such as 2GiB or 800MB, got '{text}'")
    return text


@dataclass(frozen=True)
class PoolOptions:
    """Where scenarios are carried out.

    Attributes:
        workers: Processes on this machine; None is one for each processor.
        scheduler: Address of a scheduler of Dask instead, such as ``tcp://10.0.0.1:8786``.
        memory: Of each worker on this machine, such as ``2GiB``.
        dashboard: Port of Dask's dashboard on this machine's loopback address; None is none.
    """

    workers: int | None = None
    scheduler: str | None = None
    memory: str = WORKER_MEMORY
    dashboard: int | None = None


class ScenarioPool:
    """Carries scenarios out on workers of Dask; use it as an asynchronous context manager.

    Results come back as they are made, and nothing is kept in the memory of a worker: a scenario
    whose worker dies is begun again on another one.

    Args:
        bundle: The files of all scenarios, which every worker is given.
        options: Where the workers are.
    """

    def __init__(self, bundle: Bundle, options: PoolOptions | None = None) -> None:
        self._bundle = bundle
        self._options = options or PoolOptions()
        self._client: Client
        self._has_dashboard = False
        self._stack = AsyncExitStack()

    async def __aenter__(self) -> Self:
        try:
            self._client = await self._stack.enter_async_context(self._connected())
            await self._refuse_other_versions()
            await self._client.register_plugin(_BundlePlugin(self._bundle, self._is_local), PLUGIN)
        except BaseException:
            await self._close()
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        await self._close()

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
        is told as an error.

        Raises:
            PoolError: Where the scheduler, or all workers, are gone.
        """
        suspects: list[ConcreteScenario] = []
        async for row in self._rows(iter(scenarios), self._room, suspects):
            yield row
        for scenario in suspects:
            again: list[ConcreteScenario] = []
            async for row in self._rows(iter([scenario]), lambda: 1, again):
                yield row
            if again:
                reason = f"it has killed its worker {MOST_KILLS} times, alone there"
                yield row_of_error(scenario, reason, attempts=2 * MOST_KILLS)

    async def recordings(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncIterator[tuple[ConcreteScenario, bytes, bytes]]:
        """Carry scenarios out once more, and give the recording of each with its page.

        Those that cannot be recorded are left out.
        """
        futures = {
            self._client.submit(_record, one, key=f"record-{one.id}", pure=False): one
            for one in scenarios
        }
        ended = as_completed(
            list(futures), self._client.loop, with_results=True, raise_errors=False
        )
        for _ in range(len(futures)):
            future, result = await self._next(ended)
            if future.status == "finished":
                yield futures[future], *result
            future.release()

    # ---- scenarios -----------------------------------------------------------------------

    def _room(self) -> int:
        return AHEAD * max(self.workers, 1)

    async def _rows(
        self, scenarios: Iterator[ConcreteScenario], room: Any, suspects: list[ConcreteScenario]
    ) -> AsyncIterator[ScenarioRow]:
        ended = as_completed([], self._client.loop, with_results=True, raise_errors=False)
        under_way: dict[str, ConcreteScenario] = {}
        again: deque[ConcreteScenario] = deque()

        def fill() -> None:
            while len(under_way) < room():
                one = again.popleft() if again else next(scenarios, None)
                if one is None:
                    return
                under_way[one.id] = one
                ended.add(self._submit(one))

        fill()
        while under_way:
            future, result = await self._next(ended)
            scenario = under_way.pop(_id_of(future))
            if future.status == "finished":
                yield result
            elif future.status == "error":
                error = await future.exception()
                if isinstance(error, KilledWorker):
                    suspects.append(scenario)
                elif isinstance(error, OtherVersionError):
                    await self._client.retire_workers([error.worker])
                    again.append(scenario)
                else:
                    yield row_of_error(scenario, f"{type(error).__name__}: {error}")
            else:  # cancelled or lost: the scheduler has forgotten it
                await self._refuse_lost()
                again.append(scenario)
            future.release()
            fill()

    def _submit(self, scenario: ConcreteScenario) -> Future:
        return self._client.submit(
            _carry_out, scenario, fingerprint(), key=f"scenario-{scenario.id}", pure=False
        )

    async def _next(self, ended: Any) -> Any:
        """Wait for the next scenario to end, and look at times whether the scheduler lives."""
        waiting = asyncio.ensure_future(anext(ended))
        try:
            while True:
                done, _ = await asyncio.wait([waiting], timeout=LOST_S)
                if done:
                    return waiting.result()
                await self._refuse_lost()
        finally:
            waiting.cancel()

    async def _refuse_lost(self) -> None:
        status = self._client.status
        if status != "running":
            raise PoolError(
                f"the scheduler is gone (the connection is {status}); what has ended is kept"
            )

    # ---- the cluster ---------------------------------------------------------------------

    @property
    def _is_local(self) -> bool:
        return self._options.scheduler is None

    def _connected(self) -> Any:
        return _AsyncContext(self._connect, self._disconnect)

    async def _connect(self) -> Client:
        # What it has to say of a lost connection is told as an error of ours.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        if self._options.scheduler is not None:
            return await self._join(self._options.scheduler)
        with _interrupts_ignored():
            self._cluster = await LocalCluster(
                n_workers=self._options.workers or os.cpu_count() or 1,
                threads_per_worker=1,
                processes=True,
                memory_limit=self._options.memory,
                host="127.0.0.1",
                dashboard_address=_dashboard(self._options.dashboard),
                worker_dashboard_address=None,
                silence_logs=logging.CRITICAL,
                asynchronous=True,
                scheduler_kwargs={"allowed_failures": MOST_KILLS - 1},
            )
        return await Client(self._cluster, asynchronous=True)

    async def _join(self, address: str) -> Client:
        try:
            get_backend(parse_address(address)[0])
            client = await Client(address, asynchronous=True, timeout=CONNECT_S)
        except (OSError, ValueError, TimeoutError, ImportError) as error:
            raise PoolError(
                f"no scheduler of Dask answers at {address} ({_line(error)}); start one with "
                "`dask scheduler`"
            ) from error
        return client

    async def _disconnect(self, client: Client) -> None:
        with suppress(Exception):  # a scheduler that is gone has no plugins
            if not self._is_local and client.status == "running":
                await asyncio.wait_for(client.unregister_worker_plugin(PLUGIN), 5)
        with suppress(Exception):
            await asyncio.wait_for(client.close(), 5)
        if self._is_local:
            with suppress(Exception):
                await asyncio.wait_for(self._cluster.close(), 10)

    async def _close(self) -> None:
        await self._stack.aclose()

    async def _refuse_other_versions(self) -> None:
        """Refuse workers that would make other traces.

        Raises:
            PoolError: With what is on which worker.
        """
        client = self._client
        info = await client.scheduler.identity()
        is_wanted = not self._is_local or self._options.dashboard is not None
        self._has_dashboard = is_wanted and "dashboard" in info["services"]
        if not info["workers"]:
            raise PoolError(
                f"{self._options.scheduler}: the scheduler has no workers; start some with "
                f"`dask worker {self._options.scheduler} --nthreads 1`"
            )
        found = await client.run(_fingerprint_there, on_error="return")
        ours = fingerprint()
        wrong = {name: one for name, one in found.items() if one != ours}
        if wrong:
            name, one = next(iter(wrong.items()))
            what = (
                f"no bt-mission ({_line(one)})"
                if isinstance(one, Exception)
                else "another bt-mission, or other packages or shipped missions"
            )
            raise PoolError(
                f"{len(wrong)} of {len(found)} workers cannot take part, their traces would "
                f"differ: {name} has {what}; here is {told()}"
            )
        threads = {
            name: one["nthreads"] for name, one in info["workers"].items() if one["nthreads"] != 1
        }
        if threads:
            name, count = next(iter(threads.items()))
            raise PoolError(
                f"{name} has {count} threads; a simulation takes a process of its own: start "
                "workers with --nthreads 1 (and --nworkers N)"
            )


class OtherVersionError(Exception):
    """A worker that joined later has another version.

    Args:
        worker: Its address.
    """

    def __init__(self, worker: str) -> None:
        super().__init__(worker)
        self.worker = worker


class _BundlePlugin(WorkerPlugin):  # type: ignore[misc] # distributed publishes no types for it
    """Gives each worker the files of a sweep, also those that join or start again later.

    Args:
        bundle: The files.
        is_local: Is it a worker of ours, on this machine? Ctrl-C is then for the client alone.
    """

    def __init__(self, bundle: Bundle, is_local: bool) -> None:  # noqa: FBT001 - pickled by position
        self.bundle = bundle
        self.is_local = is_local

    def setup(self, worker: Any) -> None:  # noqa: ARG002 - named by distributed
        """Make the worker ready."""
        if self.is_local:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Loads rclpy and MuJoCo.
        from rclpy.logging import LoggingSeverity, set_logger_level  # noqa: PLC0415 - likewise

        from bt_mission.scenarios.runner import (  # noqa: PLC0415 - not in the client
            ScenarioProcess,
            prepare_process,
        )
        from bt_mission.sweeps.work import ScenarioWorker  # noqa: PLC0415 - likewise

        prepare_process()
        self.scenarios = ScenarioWorker(self.bundle, ScenarioProcess().run)
        # What thousands of broken runs warn of would bury the progress; their rows have the reason.
        set_logger_level("", LoggingSeverity.FATAL)

    def teardown(self, worker: Any) -> None:  # noqa: ARG002 - likewise
        """Remove its files."""
        self.scenarios.close()


def _carry_out(scenario: ConcreteScenario, wanted: str) -> ScenarioRow:
    """Carry a scenario out on the worker that this runs on."""
    worker = get_worker()
    if fingerprint() != wanted:
        raise OtherVersionError(worker.address)
    row: ScenarioRow = worker.plugins[PLUGIN].scenarios.carry_out(scenario)
    return row


def _record(scenario: ConcreteScenario) -> tuple[bytes, bytes]:
    found: tuple[bytes, bytes] = get_worker().plugins[PLUGIN].scenarios.record(scenario)
    return found


def _fingerprint_there() -> str:
    return fingerprint()


def _id_of(future: Future) -> str:
    return str(future.key).removeprefix("scenario-")


def _dashboard(port: int | None) -> str:
    """Return where Dask serves its pages; it always does, if only its metrics."""
    return f"127.0.0.1:{port or 0}"


def _line(error: BaseException) -> str:
    return (str(error) or type(error).__name__).splitlines()[0]


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes that start now ignore Ctrl-C, which a terminal sends to all of them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


class _AsyncContext:
    """An asynchronous context manager of two coroutines."""

    def __init__(self, enter: Any, leave: Any) -> None:
        self._enter = enter
        self._leave = leave

    async def __aenter__(self) -> Any:
        self._made = await self._enter()
        return self._made

    async def __aexit__(self, *_: object) -> None:
        await self._leave(self._made)
