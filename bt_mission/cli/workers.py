"""Options and ends of commands whose scenarios run on many workers."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Coroutine
from functools import partial
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from bt_mission.base.errors import BtMissionError
from bt_mission.cli.argument_types import count, port
from bt_mission.cli.checked import permissions_of
from bt_mission.cli.options import nature_of, simulator_of
from bt_mission.cli.parser import Option, each

if TYPE_CHECKING:
    from bt_mission.base.interrupts import InterruptSignals
    from bt_mission.scenarios.concrete.base_scenario import BaseChanges
    from bt_mission.scenarios.concrete.bundle import Bundle
    from bt_mission.scenarios.concrete.pool import ScenarioPool


def _check_bokeh() -> None:
    if find_spec("bokeh") is None:
        raise BtMissionError("--dashboard needs Bokeh: pip install bokeh", code="BT-905")


_LOCAL = each("scheduler", why="its workers were started elsewhere")
WORKER_OPTIONS = (
    Option(
        "--workers N",
        "number of worker processes on this machine (default: one per processor)",
        count,
        excludes=_LOCAL,
    ),
    Option(
        "--worker-memory SIZE",
        "memory limit of each worker (default: 2GiB); a worker above it is ended",
        excludes=_LOCAL,
    ),
    Option(
        "--scheduler ADDRESS",
        "use a running Dask scheduler, such as tcp://10.0.0.1:8786, whose workers have one "
        "thread each",
        page="cluster",
    ),
    Option(
        "--dashboard PORT",
        "serve Dask's dashboard of the workers on this machine at 127.0.0.1:PORT",
        port,
        excludes=_LOCAL,
        check=_check_bokeh,
    ),
)
"""Where the scenarios run."""


def require_dask() -> None:
    """Refuse to run without Dask.

    Raises:
        BtMissionError: With what to install.
    """
    try:
        import distributed  # noqa: F401
    except ImportError as error:
        raise BtMissionError(
            f"sweeps and searches need Dask, which is not installed ({error}): "
            "pip install 'bt-mission[sweep]'",
            code="BT-905",
        ) from error


def base_changes(options: argparse.Namespace) -> BaseChanges:
    """Return what the options say of every scenario.

    Raises:
        InputError: With what is wrong with requirements or faults.
    """
    from bt_mission.scenarios.concrete.base_scenario import BaseChanges, requirements_in_files
    from bt_mission.scenarios.faults.located import faults_in_texts

    faults_in_texts(options.fault)  # what is wrong is told of the option, not of the scenario
    return BaseChanges(
        set=dict(options.set),
        requirements=requirements_in_files(options.require),
        faults=options.fault,
        world=options.world,
        robot=options.robot,
        simulator=simulator_of(options),
        nature=nature_of(options),
        permissions=permissions_of(options),
    )


def is_alone(options: argparse.Namespace) -> bool:
    """Is one process enough: that of the command itself?"""
    return options.workers == 1 and options.scheduler is None


def pool_for(
    options: argparse.Namespace, bundle: Bundle, on_wait: Callable[[], None] = lambda: None
) -> ScenarioPool:
    """Return the workers that the options name, ready to be entered.

    Args:
        on_wait: Called each second in which no scenario ends.
    """
    from bt_mission.scenarios.concrete.pool import WORKER_MEMORY, PoolOptions, ScenarioPool, memory

    given = PoolOptions(
        workers=options.workers,
        scheduler=options.scheduler,
        memory=memory(options.worker_memory or WORKER_MEMORY),
        dashboard=options.dashboard,
    )
    return ScenarioPool(bundle, given, on_wait)


def run_interruptible(main: Coroutine[Any, Any, None], interrupts: InterruptSignals) -> bool:
    """Run a coroutine to its end; a signal cancels it. Return whether one has.

    Code in it that does not await calls :func:`stop_at_signal` between its steps.
    """
    import asyncio

    async def run() -> None:
        loop, task = asyncio.get_running_loop(), asyncio.ensure_future(main)
        with interrupts.calling(partial(loop.call_soon_threadsafe, task.cancel)):
            if interrupts.count:
                task.cancel()
            await task

    try:
        asyncio.run(run())
    except asyncio.CancelledError:
        if not interrupts.count:
            raise
        return True
    return False


def stop_at_signal(interrupts: InterruptSignals) -> None:
    """Raise asyncio.CancelledError if there was a signal."""
    if interrupts.count:
        import asyncio

        raise asyncio.CancelledError
