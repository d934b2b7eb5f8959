"""Carries the scenarios of a plan out, and keeps each row as it comes."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.plan import SweepPlan
from bt_mission.sweeps.row import ScenarioRow
from bt_mission.sweeps.runner import ScenarioRunner
from bt_mission.sweeps.store import ResultStore
from bt_mission.sweeps.versions import VERSIONS_KEY, fingerprint, told


async def sweep(
    plan: SweepPlan,
    store: ResultStore,
    runner: ScenarioRunner,
    on_row: Callable[[ScenarioRow], None],
    *,
    retry_errors: bool = False,
) -> None:
    """Carry out what is left of a plan.

    Args:
        store: Has the rows that are there already; the others are added as they come.
        on_row: Told of each after it was written.
        retry_errors: Carry out again what could not run, or killed its workers.
    """
    store.set_value(f"{VERSIONS_KEY} {fingerprint()}", told())
    async for row in runner.rows(left(plan, store, retry_errors=retry_errors)):
        store.add(row)
        on_row(row)


def left(
    plan: SweepPlan, store: ResultStore, *, retry_errors: bool = False
) -> Iterator[ConcreteScenario]:
    """What is not carried out yet."""
    done = store.ids(without_errors=retry_errors)
    return (one for one in plan.scenarios() if one.id not in done)
