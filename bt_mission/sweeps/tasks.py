"""What a worker of Dask is told to do: by name, so bt-mission must be installed there, too."""

from __future__ import annotations

import signal
from functools import cache
from typing import Any

import dask
import distributed
from distributed import WorkerPlugin, get_worker

from bt_mission.recording.contents import versions
from bt_mission.sweeps.bundle import Bundle
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.versions import fingerprint

SOURCES = "sources"
"""The key of the fingerprint among the versions of a worker."""

PROFILERS = ("profile", "profile-cycle")
"""Of Dask, which looks at the stack of each task a hundred times a second, and keeps an hour of it:
0.2 MB for each second of a simulation."""


class UnfitWorkerError(Exception):
    """A worker that cannot take part, since it has joined later with other versions, say.

    Attributes:
        address: Of the worker.
        versions: Of what it has.
        threads: How many tasks it takes at once.
    """

    def __init__(self, address: str, versions: dict[str, str], threads: int) -> None:
        super().__init__(address, versions, threads)
        self.address, self.versions, self.threads = address, versions, threads


class BundlePlugin(WorkerPlugin):  # type: ignore[misc] # distributed publishes no types for it
    """Gives each worker the files of a sweep, also those that join or start again later.

    Args:
        bundle: The files.
        is_local: Is it a worker of ours, on this machine? Ctrl-C is then for the client alone.
    """

    def __init__(self, bundle: Bundle, is_local: bool) -> None:  # noqa: FBT001 - pickled by position
        self.bundle = bundle
        self.is_local = is_local

    def setup(self, worker: Any) -> None:
        """Make the worker ready."""
        for one in _profilers(worker):
            one.stop()
        if self.is_local:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
        # Loads rclpy and MuJoCo.
        from bt_mission.sweeps.work import ScenarioWorker  # noqa: PLC0415 - not in the client

        self.scenarios = ScenarioWorker(self.bundle, _scenario_process().run)

    def teardown(self, worker: Any) -> None:
        """Remove its files, and leave the worker as it was."""
        self.scenarios.close()
        for one in _profilers(worker):
            one.start()


def _profilers(worker: Any) -> list[Any]:
    callbacks = worker.periodic_callbacks
    return [callbacks[name] for name in PROFILERS if name in callbacks]


@cache
def _scenario_process() -> Any:
    """What all sweeps share that this worker ever takes part in."""
    from bt_mission.scenarios.runner import (  # noqa: PLC0415 - likewise
        ScenarioProcess,
        prepare_process,
        silence_logs,
    )

    prepare_process()
    silence_logs()
    return ScenarioProcess()


def carry_out(scenario: ConcreteScenario, plugin: str, wanted: dict[str, str]) -> ScenarioRow:
    """Carry a scenario out on the worker that this runs on.

    Args:
        plugin: The name of that with its files.
        wanted: The versions that the worker must have.

    Raises:
        UnfitWorkerError: Where the worker cannot.
    """
    worker = get_worker()
    versions_here, threads = about_worker(), worker.state.nthreads
    if threads != 1 or versions_here != wanted or plugin not in worker.plugins:
        raise UnfitWorkerError(worker.address, versions_here, threads)
    row: ScenarioRow = worker.plugins[plugin].scenarios.carry_out(scenario)
    return row


def record(scenario: ConcreteScenario, plugin: str) -> tuple[bytes, bytes]:
    """Carry a scenario out once more on the worker that this runs on; gives recording and page."""
    found: tuple[bytes, bytes] = get_worker().plugins[plugin].scenarios.record(scenario)
    return found


def about_worker() -> dict[str, str]:
    """Return all versions of this process: traces of two differ unless these are equal."""
    dasks = {"dask": dask.__version__, "distributed": distributed.__version__}
    return {**versions(), **dasks, SOURCES: fingerprint()}
