"""A cluster of Dask: started on this machine or joined; who cannot take part is refused."""

from __future__ import annotations

import asyncio
import logging
import os
import re
import signal
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, suppress
from dataclasses import dataclass
from typing import Any

import dask
from dask.utils import parse_bytes
from distributed import Client, LocalCluster
from distributed.comm import parse_address
from distributed.comm.registry import get_backend
from distributed.core import rpc
from distributed.security import Security

from bt_mission.core.errors import BtMissionError
from bt_mission.sweeps.tasks import SOURCES, about_worker
from bt_mission.sweeps.versions import told

MOST_KILLS = 3
"""A scenario that has killed so many workers on this machine is marked, and not tried again; other
schedulers have their own number, ``distributed.scheduler.allowed-failures``."""

WORKER_MEMORY = "2GiB"
"""What a worker on this machine may take; one that takes 95 % of it is ended, and its scenario
begun again elsewhere. A simulation takes 0.3 to 0.4 GB, with its camera 0.2 GB more."""

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


@asynccontextmanager
async def connected(options: PoolOptions) -> AsyncIterator[Client]:
    """Start workers on this machine, or join a scheduler.

    Raises:
        PoolError: Where no scheduler of this version answers.
    """
    # What it has to say of a lost connection is told as an error of ours.
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if options.scheduler is not None:
        async with _closing(await _join(options.scheduler)) as client:
            yield client
        return
    # Dask gives a worker up that has died and is not back in 15 s, or has died again by then; a
    # sweep would go on with fewer and fewer.
    dask.config.set({"distributed.deploy.lost-worker-timeout": NEVER})
    # It looks at the stack of each process a hundred times a second, and keeps that of an hour.
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
            scheduler_kwargs={"allowed_failures": MOST_KILLS - 1},
        )
    async with _closing(cluster), _closing(await Client(cluster, asynchronous=True)) as client:
        try:
            yield client
        except BaseException:  # nobody waits for the scenarios that are under way
            closed = (one.close(timeout=LEAVE_S) for one in cluster.workers.values())
            await asyncio.gather(*closed, return_exceptions=True)
            raise


async def _join(address: str) -> Client:
    try:
        get_backend(parse_address(address)[0])
        await _refuse_other_scheduler(address)
        return await Client(address, asynchronous=True, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError, TimeoutError, ImportError) as error:
        raise PoolError(
            f"no scheduler of Dask answers at {address} ({line_of(error)}); start one with "
            "`dask scheduler`"
        ) from error


async def _refuse_other_scheduler(address: str) -> None:
    """Ask a scheduler for its versions in a way that all of them understand."""
    arguments = Security().get_connection_args("client")
    async with rpc(address, connection_args=arguments, timeout=CONNECT_S) as scheduler:
        found = await asyncio.wait_for(scheduler.versions(), CONNECT_S)
    there = found["packages"]
    here = about_worker()
    wrong = [name for name in MUST_BE_EQUAL if there.get(name) != here[name]]
    if wrong:
        raise PoolError(
            f"the scheduler at {address} has "
            + ", ".join(f"{name} {there.get(name)} (here {here[name]})" for name in wrong)
            + ": install there what is here, or here what is there"
        )


@asynccontextmanager
async def _closing(what: Any) -> AsyncIterator[Any]:
    try:
        yield what
    finally:
        with suppress(Exception):  # what is gone needs no closing
            await asyncio.wait_for(what.close(), CLOSE_S)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes that start now ignore Ctrl-C, which a terminal sends to all of them."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


# ---- who can take part ------------------------------------------------------------------------


async def workers_of(client: Client) -> dict[str, dict[str, Any]]:
    """Return what the scheduler knows of each worker, by its address."""
    return dict((await client.scheduler.identity())["workers"])


async def unfit_workers(client: Client) -> dict[str, str]:
    """Return why workers cannot take part, by their addresses; those that can are left out.

    Raises:
        PoolError: Where some do not answer.
    """
    threads = {name: one["nthreads"] for name, one in (await workers_of(client)).items()}
    try:
        found = await asyncio.wait_for(client.run(about_worker, on_error="return"), ANSWER_S)
    except TimeoutError:
        raise PoolError(
            f"some of {len(threads)} workers have not answered in {ANSWER_S:g} s"
        ) from None
    told_of = {name: why_unfit(one, threads.get(name, 1)) for name, one in found.items()}
    return {name: why for name, why in told_of.items() if why}


def why_unfit(found: Any, threads: int) -> str:
    """Say why a worker cannot take part; empty where it can, or is gone by now.

    Args:
        found: Its versions, or the exception that came instead.
        threads: How many tasks it takes at once.
    """
    if isinstance(found, OSError):
        return ""
    if isinstance(found, BaseException):
        missing = _MISSING.search(str(found))
        if missing and missing[1] == "bt_mission":
            return "has no bt-mission"
        return f"has another bt-mission, or a broken one ({line_of(found)})"
    here = about_worker()
    if not isinstance(found, Mapping):
        return "has another bt-mission"
    differing = [name for name in here if name != SOURCES and found.get(name) != here[name]]
    if differing:
        named = (f"{name} {found.get(name, 'missing')} (here {here[name]})" for name in differing)
        return f"has {', '.join(named)}"
    if found.get(SOURCES) != here[SOURCES]:
        return "has a bt-mission with other sources or shipped missions"
    if threads != 1:
        return (
            f"has {threads} threads, and a simulation takes a process of its own: start workers "
            "with --nthreads 1 (and --nworkers N)"
        )
    return ""


def refusal(unfit: Mapping[str, str], total: int) -> PoolError:
    """Return the error for workers that cannot take part."""
    name, why = next(iter(unfit.items()))
    return PoolError(
        f"{len(unfit)} of {total} workers cannot take part, or traces would differ: {name} {why}; "
        f"install everywhere what is here: {told()}"
    )


def line_of(error: BaseException) -> str:
    """Return the first line of what an error says."""
    return (str(error) or type(error).__name__).splitlines()[0]
