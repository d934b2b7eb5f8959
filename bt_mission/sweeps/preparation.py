"""Looks at a plan before its scenarios run, so that its mistakes are told at once and only once."""

from __future__ import annotations

from bt_mission.core.diagnostics import Diagnostic, InputError
from bt_mission.scenarios.run import look_for_names
from bt_mission.sweeps.concrete import ConcreteScenario
from bt_mission.sweeps.plan import SweepPlan
from bt_mission.sweeps.work import ScenarioWorker


def refuse_impossible(plan: SweepPlan) -> None:
    """Load the first scenario, one with each end of each parameter, and one of each plan of faults.

    Raises:
        InputError: With what is wrong, as that of the option that brings it.
        BtMissionError: Where a simulation cannot be set up.
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
            [Diagnostic(one.message, where, 1, 1, one.source, one.hint) for one in error.faults]
        ) from error
