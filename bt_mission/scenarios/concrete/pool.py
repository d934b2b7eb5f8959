"""Workers of Dask distributed that run scenarios, on this machine or in a cluster.

Functions are sent to workers by name, so bt-mission must be installed there, too.
"""

from __future__ import annotations

import asyncio
import logging
import os
import re
import signal
from collections import Counter, deque
from collections.abc import (
    AsyncGenerator,
    AsyncIterator,
    Callable,
    Iterable,
    Iterator,
    Mapping,
)
from contextlib import AsyncExitStack, asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from itertools import count
from types import TracebackType
from typing import Any, Self, TypeAlias, TypeVar

import dask
import distributed
from dask.utils import parse_bytes
from distributed import (
    Client,
    KilledWorker,
    LocalCluster,
    WorkerPlugin,
    as_completed,
    get_worker,
)
from distributed.comm import parse_address
from distributed.comm.registry import get_backend
from distributed.core import rpc
from distributed.security import Security

from bt_mission.base.errors import BtMissionError
from bt_mission.base.python_process import safe_processes
from bt_mission.base.versions import versions
from bt_mission.scenarios.concrete.bundle import Bundle, fingerprint, versions_in_words
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.row import ScenarioRow, row_of_error

T = TypeVar("T")

SOURCES = "sources"
"""The key of the fingerprint among the versions of a worker."""

PROFILERS = ("profile", "profile-cycle")
"""Dask's profilers, which read the stack of each task a hundred times a second, and keep an hour of
it: 0.2 MB for each second of a simulation.
"""

MOST_KILLS = 3
"""A scenario that has killed this number of workers on this machine is marked, and not tried again;
other schedulers have their own limit, ``distributed.scheduler.allowed-failures``.
"""

WORKER_MEMORY = "2GiB"
"""The memory limit of a worker on this machine; one that takes 95 % of it is ended, and its
scenario starts again elsewhere. A simulation takes 0.3 to 0.4 GB, with its camera 0.2 GB more.
"""

LEAST_MEMORY = 100_000_000
CONNECT_S = 10.0
ANSWER_S = 60.0
"""A worker may load bt-mission from a slow disk in so long, s."""

CLOSE_S = 20.0
LEAVE_S = 1.0
"""Worker processes that nobody waits for are killed when they have not ended after this time, s."""

NEVER = "1000 days"
MUST_BE_EQUAL = ("dask", "distributed")
"""Packages that the scheduler must have as they are here."""

_MISSING = re.compile(r"No module named '([\w.]+)'")

AHEAD = 2
"""Scenarios that wait or run at each worker: one runs, the next is there when it has ended."""

MOST_TRIES = 2
"""The number of attempts of a scenario if Dask itself fails with it."""

LOOK_S = 1.0
"""The interval of checks for the scheduler while no scenario ends, s."""

Killed: TypeAlias = list[tuple[ConcreteScenario, int]]
"""Scenarios whose workers have died, and how many of them."""


# ---- on a worker ------------------------------------------------------------------------------


class UnfitWorkerError(Exception):
    """A worker that cannot take part, for example because it joined later with other versions.

    Attributes:
        address: The worker's address.
        versions: Its versions.
        threads: The number of its parallel tasks.
    """

    def __init__(self, address: str, versions: dict[str, str], threads: int) -> None:
        super().__init__(address, versions, threads)
        self.address, self.versions, self.threads = address, versions, threads


class BundlePlugin(WorkerPlugin):  # type: ignore[misc] # distributed publishes no types for it
    """Gives each worker the files of a sweep, also those that join or restart later.

    Args:
        bundle: The files.
        is_local: Whether this process has started the worker. Ctrl-C then applies only to the
            client.
    """

    def __init__(self, bundle: Bundle, is_local: bool) -> None:  # noqa: FBT001 - pickled by position
        self.bundle = bundle
        self.is_local = is_local

    def setup(self, worker: Any) -> None:
        """Make the worker ready."""
        for profiler in _profilers(worker):
            profiler.stop()
        if self.is_local:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Loads rclpy and MuJoCo.
        from bt_mission.scenarios.concrete.worker import ScenarioWorker  # noqa: PLC0415 - not in the client

        self.scenarios = ScenarioWorker(self.bundle, _scenario_process().run)

    def teardown(self, worker: Any) -> None:
        """Remove its files, and restore the worker."""
        self.scenarios.close()
        for profiler in _profilers(worker):
            profiler.start()


def _profilers(worker: Any) -> list[Any]:
    callbacks = worker.periodic_callbacks
    return [callbacks[name] for name in PROFILERS if name in callbacks]


@cache
def _scenario_process() -> Any:
    """Return the scenario process that all sweeps of this worker share."""
    from bt_mission.scenarios.runner import (  # noqa: PLC0415 - likewise
        ScenarioProcess,
        prepare_process,
        silence_logs,
    )

    prepare_process()
    silence_logs()
    return ScenarioProcess()


def carry_out(scenario: ConcreteScenario, plugin: str, wanted: dict[str, str]) -> ScenarioRow:
    """Run a scenario on this worker.

    Args:
        plugin: The name of the plugin with its files.
        wanted: The versions that the worker must have.

    Raises:
        UnfitWorkerError: The worker cannot run it.
    """
    worker = get_worker()
    versions_here, threads = about_worker(), worker.state.nthreads
    if threads != 1 or versions_here != wanted or plugin not in worker.plugins:
        raise UnfitWorkerError(worker.address, versions_here, threads)
    row: ScenarioRow = worker.plugins[plugin].scenarios.carry_out(scenario)
    return row


def run_again(scenario: ConcreteScenario, plugin: str, run: Callable[[Any], T]) -> T:
    """Run a scenario in another way on this worker."""
    result: T = get_worker().plugins[plugin].scenarios.run_again(scenario, run)
    return result


def about_worker() -> dict[str, str]:
    """Return all versions of this process: traces of two differ unless these are equal."""
    dasks = {"dask": dask.__version__, "distributed": distributed.__version__}
    return {**versions(), **dasks, SOURCES: fingerprint()}


# ---- a cluster --------------------------------------------------------------------------------


def memory(text: str) -> str:
    """Return an amount of memory, such as ``2GiB``, as it is written.

    Raises:
        BtMissionError: It is invalid.
    """
    try:
        amount = parse_bytes(text)
    except ValueError:
        amount = 0
    if amount < LEAST_MEMORY:
        raise BtMissionError(
            f"--worker-memory: expected an amount such as 2GiB or 800MB, got '{text}'",
            code="BT-1101",
        )
    return text


@dataclass(frozen=True)
class PoolOptions:
    """The workers of a sweep.

    Attributes:
        workers: Processes on this machine; None is one for each processor.
        scheduler: Address of a scheduler of Dask instead, such as ``tcp://10.0.0.1:8786``.
        memory: Of each worker on this machine, such as ``2GiB``.
        dashboard: Port of Dask's dashboard on this machine's loopback address, or None.
    """

    workers: int | None = None
    scheduler: str | None = None
    memory: str = WORKER_MEMORY
    dashboard: int | None = None


@asynccontextmanager
async def connected(options: PoolOptions) -> AsyncIterator[Client]:
    """Start workers on this machine, or join a scheduler.

    Raises:
        BtMissionError: No scheduler of this version answers.
    """
    # Its messages about a lost connection are reported as an error of ours.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if options.scheduler is not None:
        async with _closing(await _join(options.scheduler)) as client:
            yield client
        return
    with safe_processes() as variables:
        async with _local_cluster(options, variables) as client:
            yield client


@asynccontextmanager
async def _local_cluster(options: PoolOptions, variables: dict[str, str]) -> AsyncIterator[Client]:
    # Dask gives a worker up that has died and is not back in 15 s, or has died again by then; a
    # sweep would continue with fewer and fewer.
    dask.config.set({"distributed.deploy.lost-worker-timeout": NEVER})
    # It reads the stack of each process a hundred times a second, and keeps an hour of it.
    dask.config.set({"distributed.worker.profile.enabled": False})
    with _interrupts_ignored():
        cluster = await LocalCluster(
            n_workers=options.workers or os.cpu_count() or 1,
            threads_per_worker=1,
            processes=True,
            memory_limit=options.memory,
            host="127.0.0.1",
            # Dask always serves its metrics.
            dashboard_address=f"127.0.0.1:{options.dashboard or 0}",
            worker_dashboard_address=None,
            silence_logs=logging.CRITICAL,
            asynchronous=True,
            env=variables,
            scheduler_kwargs={"allowed_failures": MOST_KILLS - 1},
        )
    async with _closing(cluster), _closing(await Client(cluster, asynchronous=True)) as client:
        try:
            yield client
        except BaseException:  # nobody waits for the scenarios that are under way
            closed = (worker.close(timeout=LEAVE_S) for worker in cluster.workers.values())
            await asyncio.gather(*closed, return_exceptions=True)
            raise


async def _join(address: str) -> Client:
    try:
        get_backend(parse_address(address)[0])
        await _refuse_other_scheduler(address)
        return await Client(address, asynchronous=True, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError, TimeoutError, ImportError) as error:
        raise BtMissionError(
            f"no Dask scheduler answers at {address} ({line_of(error)}); start one with "
            "`dask scheduler`",
            code="BT-712",
        ) from error


async def _refuse_other_scheduler(address: str) -> None:
    """Ask a scheduler for its versions in a way that all versions support."""
    arguments = Security().get_connection_args("client")
    async with rpc(address, connection_args=arguments, timeout=CONNECT_S) as scheduler:
        versions = await asyncio.wait_for(scheduler.versions(), CONNECT_S)
    there = versions["packages"]
    here = about_worker()
    wrong = [name for name in MUST_BE_EQUAL if there.get(name) != here[name]]
    if wrong:
        raise BtMissionError(
            f"the scheduler at {address} has "
            + ", ".join(f"{name} {there.get(name)} (here {here[name]})" for name in wrong)
            + ": install the same versions on both",
            code="BT-712",
        )


@asynccontextmanager
async def _closing(what: Any) -> AsyncIterator[Any]:
    try:
        yield what
    finally:
        with suppress(Exception):  # what is gone is already closed
            await asyncio.wait_for(what.close(), CLOSE_S)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes that start now ignore Ctrl-C, which a terminal sends to all of them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


# ---- workers that can take part ---------------------------------------------------------------


async def workers_of(client: Client) -> dict[str, dict[str, Any]]:
    """Return the scheduler's facts on each worker, by its address."""
    return dict((await client.scheduler.identity())["workers"])


async def unfit_workers(client: Client) -> dict[str, str]:
    """Return why workers cannot take part, by their addresses; the others are omitted.

    Raises:
        BtMissionError: Some do not answer.
    """
    threads = {name: facts["nthreads"] for name, facts in (await workers_of(client)).items()}
    try:
        answers = await asyncio.wait_for(client.run(about_worker, on_error="return"), ANSWER_S)
    except TimeoutError:
        raise BtMissionError(
            f"some of {len(threads)} workers have not answered in {ANSWER_S:g} s", code="BT-712"
        ) from None
    reasons = {name: why_unfit(answer, threads.get(name, 1)) for name, answer in answers.items()}
    return {name: why for name, why in reasons.items() if why}


def why_unfit(answer: Any, threads: int) -> str:
    """Return why a worker cannot take part; empty if it can, or is gone.

    Args:
        answer: Its versions, or the exception that came instead.
        threads: The number of its parallel tasks.
    """
    if isinstance(answer, OSError):
        return ""
    if isinstance(answer, BaseException):
        missing = _MISSING.search(str(answer))
        if missing and missing[1] == "bt_mission":
            return "has no bt-mission"
        return f"has another bt-mission, or a broken one ({line_of(answer)})"
    here = about_worker()
    if not isinstance(answer, Mapping):
        return "has another bt-mission"
    differing = [name for name in here if name != SOURCES and answer.get(name) != here[name]]
    if differing:
        named = (f"{name} {answer.get(name, 'missing')} (here {here[name]})" for name in differing)
        return f"has {', '.join(named)}"
    if answer.get(SOURCES) != here[SOURCES]:
        return "has a bt-mission with other sources or shipped missions"
    if threads != 1:
        return (
            f"has {threads} threads, and each simulation needs its own process: start workers "
            "with --nthreads 1 (and --nworkers N)"
        )
    return ""


def refusal(unfit: Mapping[str, str], total: int) -> BtMissionError:
    """Return the error for workers that cannot take part."""
    name, why = next(iter(unfit.items()))
    return BtMissionError(
        f"{len(unfit)} of {total} workers cannot take part, or traces would differ: {name} {why}; "
        f"install the same everywhere: {versions_in_words()}",
        code="BT-712",
    )


def line_of(error: BaseException) -> str:
    """Return the first line of an error's text."""
    return (str(error) or type(error).__name__).splitlines()[0]


# ---- the pool ---------------------------------------------------------------------------------


class ScenarioPool:
    """Runs scenarios on workers of Dask; use it as an asynchronous context manager.

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
            # Several sweeps may share workers: each has separate files and tasks.
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
        """The present number of workers."""
        return int(self._client.scheduler_info(n_workers=0).get("n_workers", 0))

    @property
    def dashboard(self) -> str:
        """Link to Dask's dashboard; empty without one."""
        return str(self._client.dashboard_link) if self._has_dashboard else ""

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Run scenarios, and yield the row of each, in the order in which they end.

        They are made as workers get free, so there may be any number of them. One that dies with
        its worker again and again is tried alone at the end; if it kills its worker there, too, it
        is reported as an error. Without workers, it waits for others.

        Raises:
            BtMissionError: Where the scheduler is gone, or the last worker cannot take part.
        """
        suspects: Killed = []
        async for row in self._rows(iter(scenarios), self._room, suspects):
            yield row
        for scenario, before in suspects:
            alone: Killed = []
            async for row in self._rows(iter([scenario]), lambda: 1, alone):
                yield replace(row, attempts=row.attempts + before)
            for _, kills in alone:
                reason = f"it killed its worker {kills} times while it ran alone"
                yield row_of_error(scenario, reason, attempts=2 * kills)

    async def runs_again(
        self, scenarios: Iterable[ConcreteScenario], run: Callable[[Any], T]
    ) -> AsyncIterator[tuple[ConcreteScenario, T]]:
        """Run scenarios in another way, and yield each with what that gives.

        Those that cannot run are skipped.

        Args:
            run: A function of a module, which takes a `Scenario`.
        """
        under_way = {
            self._submit(run_again, scenario, self._name, run): scenario for scenario in scenarios
        }
        ended = self._ended(list(under_way))
        for _ in range(len(under_way)):
            future, result = await self._next(ended)
            if future.status == "finished":
                yield under_way[future], result
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
        """Run scenarios.

        Args:
            room: The number of scenarios under way.
            killed: Receives those that have killed their workers.
        """
        ended = self._ended([])
        under_way: dict[Any, ConcreteScenario] = {}
        again: deque[ConcreteScenario] = deque()
        errors: Counter[str] = Counter()
        wanted = about_worker()

        def fill() -> None:
            while len(under_way) < room():
                following = again.popleft() if again else next(scenarios, None)
                if following is None:
                    return
                future = self._submit(carry_out, following, self._name, wanted)
                under_way[future] = following
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
        # A separate key for each attempt: Dask takes a known key for the same task.
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
        with suppress(Exception):  # a scheduler that is gone has none
            return int(await asyncio.wait_for(asked, LOOK_S))
        return 0

    def _ended(self, futures: list[Any]) -> Any:
        return as_completed(futures, self._client.loop, with_results=True, raise_errors=False)

    async def _next(self, ended: Any) -> Any:
        """Wait for the next scenario to end, and check the scheduler now and then."""
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
            raise BtMissionError(
                f"the connection to the scheduler is {status}; finished results are saved",
                code="BT-712",
            )

    # ---- workers -------------------------------------------------------------------------

    async def _refuse_unfit_workers(self) -> None:
        info = await self._client.scheduler.identity()
        is_wanted = self._options.scheduler is not None or self._options.dashboard is not None
        self._has_dashboard = is_wanted and "dashboard" in info["services"]
        if not info["workers"]:
            address = self._options.scheduler
            raise BtMissionError(
                f"{address}: the scheduler has no workers; start some with "
                f"`dask worker {address} --nthreads 1`",
                code="BT-712",
            )
        unfit = await unfit_workers(self._client)
        if unfit:
            raise refusal(unfit, len(info["workers"]))

    async def _retire(self, unfit: UnfitWorkerError) -> None:
        """Retire a worker that joined later and cannot take part.

        Raises:
            BtMissionError: There is no other worker.
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
            raise BtMissionError(
                f"a worker cannot be set up: {line_of(error)}", code="BT-712"
            ) from error

    async def _take_bundle_back(self) -> None:
        if self._options.scheduler is None or self._client.status != "running":
            return
        with suppress(Exception):  # a scheduler that is gone has no plugins
            await asyncio.wait_for(self._client.unregister_worker_plugin(self._name), CLOSE_S)
