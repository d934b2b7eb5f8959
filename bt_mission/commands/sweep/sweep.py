"""Checks a plan, runs its scenarios, and keeps each row."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.output import cannot_write, within, write_file
from bt_mission.cli.recorded_scenario import recording_and_report
from bt_mission.commands.sweep.columns import WORST, SweepColumns
from bt_mission.commands.sweep.plan import SweepPlan
from bt_mission.commands.sweep.store import RECORDINGS, VERSIONS, ResultStore
from bt_mission.scenarios.concrete.bundle import fingerprint, versions_in_words
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.pool import ScenarioPool
from bt_mission.scenarios.concrete.row import ScenarioRow
from bt_mission.scenarios.concrete.worker import ScenarioRunner, ScenarioWorker
from bt_mission.scenarios.run import look_for_names


def refuse_impossible(plan: SweepPlan) -> None:
    """Load the first scenario, one with each end of each parameter, and one of each plan of faults.

    Raises:
        InputError: With the error, at the option that causes it.
        BtMissionError: A simulation cannot be set up.
    """
    base = plan.base
    with ScenarioWorker(base.bundle) as worker:
        worker.refuse_values(base, plan.parameters)
        first = plan.scenario(0)
        for name, faults in (plan.plans or {"": ()}).items():
            scenario = base.concrete(first.parameters, seed=0, faults=faults, plan=name)
            _look(worker, scenario)


def _look(worker: ScenarioWorker, scenario: ConcreteScenario) -> None:
    try:
        look_for_names(worker.load(scenario))
    except InputError as error:
        where = f"the plan '{scenario.plan}'" if scenario.plan else "--fault"
        raise InputError(
            [
                Diagnostic(fault.code, fault.message, where, 1, 1, fault.source, fault.hint)
                for fault in error.diagnostics
            ]
        ) from error


async def sweep(
    plan: SweepPlan,
    store: ResultStore,
    runner: ScenarioRunner,
    on_row: Callable[[ScenarioRow], None],
    *,
    retry_errors: bool = False,
) -> None:
    """Run the remaining scenarios of a plan.

    Args:
        store: Has the existing rows; new ones are added.
        on_row: Called with each row after it was written.
        retry_errors: Run again what could not run, or killed its workers.
    """
    store.set_value(f"{VERSIONS} {fingerprint()}", versions_in_words())
    async for row in runner.rows(left(plan, store, retry_errors=retry_errors)):
        store.add(row)
        on_row(row)


def left(
    plan: SweepPlan, store: ResultStore, *, retry_errors: bool = False
) -> Iterator[ConcreteScenario]:
    """Return the scenarios that have not run yet."""
    done = store.ids(without_errors=retry_errors)
    return (scenario for scenario in plan.scenarios() if scenario.id not in done)


def to_record(store: ResultStore, plan: SweepPlan, most: int | None) -> list[ConcreteScenario]:
    """Return the worst scenarios without a recording: those that the page lists.

    Args:
        most: Their number; None is twenty, or as many as have failed or are a tenth of all if that
            is less.
    """
    columns = SweepColumns(store.rows())
    rows = columns.worst_rows(store, WORST if most is None else most)
    if most is None:
        tenth = plan.count // 10
        rows = [row for number, row in enumerate(rows) if not row.passed or number < tenth]
    made = (plan.scenario(row.number) for row in rows)
    return [scenario for scenario in made if not _recording(store, scenario).exists()]


async def record(
    store: ResultStore,
    pool: ScenarioPool,
    scenarios: Sequence[ConcreteScenario],
    on_recorded: Callable[[], None],
) -> None:
    """Record scenarios among the results, each with its page.

    Raises:
        BtMissionError: Where they cannot be written.
    """
    async for scenario, (recording, page) in pool.runs_again(scenarios, recording_and_report):
        path = _recording(store, scenario)
        try:
            path.parent.mkdir(exist_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from error
        write_file(within(store.folder, f"{RECORDINGS}/{scenario.id}.html"), page)
        write_file(path, recording)
        on_recorded()


def _recording(store: ResultStore, scenario: ConcreteScenario) -> Path:
    return within(store.folder, f"{RECORDINGS}/{scenario.id}.mcap")
