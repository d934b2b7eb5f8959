"""Run a scenario on a new stage."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TypeAlias

from bt_mission.base.clock_watch import UNATTENDED_S
from bt_mission.base.stamps import NS
from bt_mission.executive.report import Report
from bt_mission.scenarios.coverage.record import CoverageRecord
from bt_mission.scenarios.faults.located import planned_on
from bt_mission.scenarios.loader import ScenarioChanges, load_scenario
from bt_mission.scenarios.scenario import TIME_IS_UP, Scenario, ScenarioResult
from bt_mission.scenarios.servers import ScriptedNode
from bt_mission.sessions.session import StepCallback
from bt_mission.sessions.stage import Stage

Keep: TypeAlias = Callable[[Stage], AbstractContextManager[Callable[[Report], object]]]
"""Watches a stage from before its first step; gives what is called with the report of the run."""


def _keep_nothing(_stage: Stage) -> AbstractContextManager[Callable[[Report], object]]:
    return nullcontext(lambda _: None)


def run_scenario(
    scenario: str | Path | Scenario,
    *,
    seed: int | None = None,
    with_coverage: bool = False,
    before_step: Callable[[], None] = lambda: None,
    keep: Keep = _keep_nothing,
) -> ScenarioResult:
    """Run a scenario in a new simulation; return its result.

    ``assert run_scenario("scan_lost.scenario.yaml").passed``

    Args:
        scenario: A file, or what `load_scenario` gives.
        seed: Of everything random, instead of the scenario's.
        with_coverage: Record what the run reaches of its mission, too.
        before_step: Called before each step; what it raises ends the run.
        keep: Watches the run, such as a recorder.

    Raises:
        InputError: With every error of the file, and of names that its faults find nothing of.
        BtMissionError: Where the stage cannot be set up, or breaks.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario, ScenarioChanges(seed=seed))
    elif seed is not None:
        scenario = replace(scenario, mission=replace(scenario.mission, seed=seed))
    with ExitStack() as stack:
        stage = stack.enter_context(on_stage(scenario))
        with_outcomes = stack.enter_context(planned_on(stage, scenario.faults))
        record = None
        if with_coverage:
            record = CoverageRecord.attach(scenario.mission, stage.executive)
        attend(stage, scenario)
        take_report = stack.enter_context(keep(stage))
        while not stage.is_done:
            before_step()
            stage.step()
        report = with_outcomes(stage.report())
        take_report(report)
    return replace(scenario.judge(report), coverage=record)


def look_for_names(scenario: Scenario) -> None:
    """Look for what the faults of a scenario name, on its stage; nothing moves.

    Raises:
        InputError: With all missing names.
        BtMissionError: Where the stage cannot be set up.
    """
    with on_stage(scenario) as stage, planned_on(stage, scenario.faults):
        pass


@contextmanager
def on_stage(scenario: Scenario) -> Iterator[Stage]:
    """Put a scenario on a new stage, where code of users is interrupted that does not return."""
    options = replace(scenario.stage_options, hold_limit_s=UNATTENDED_S)
    with (
        TemporaryDirectory() as folder,
        scenario.at_its_start(),
        Stage(
            scenario.mission, image_folder=Path(folder), say=lambda _: None, options=options
        ) as stage,
    ):
        yield stage


def attend(stage: Stage, scenario: Scenario) -> None:
    """Interrupt the mission of a scenario at its limit, and note which of its servers are unused.

    The limit is the first control step at its time. The observation of an ended mission continues.
    """
    end_ns = stage.start_ns + round(scenario.limit * NS)
    executive = stage.executive
    executive.untested += [
        node.untested for node in stage.clock.get_nodes() if isinstance(node, ScriptedNode)
    ]
    cycles = executive.cycles

    def look() -> None:
        nonlocal cycles
        is_over = executive.cycles != cycles and stage.now_ns >= end_ns
        if is_over and executive.status.is_active:
            executive.interrupt(TIME_IS_UP)
        cycles = executive.cycles

    stage.attach(StepCallback(look))
