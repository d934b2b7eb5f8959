"""The stage on which a recorded run runs again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.commands.fork.change import ForkChange, refuse_earlier
from bt_mission.commands.fork.fork import ForkedRun, ForkResult
from bt_mission.commands.fork.source import ForkSource
from bt_mission.requirements.checks import with_requirements
from bt_mission.scenarios.faults.located import faults_in_texts, planned_on
from bt_mission.scenarios.faults.world import MOST_OBSTACLES
from bt_mission.sessions.drive import Reports
from bt_mission.sessions.stage import Stage

Finish = Callable[[Reports], ForkResult]
"""Returns the result of a fork, of the reports of its runs."""


@contextmanager
def forked_stage(
    source: ForkSource,
    change: ForkChange,
    step_ns: int,
    *,
    require: Sequence[Path] = (),
) -> Iterator[tuple[Stage, Finish]]:
    """Put a recorded run on the stage again, to be stepped to its end.

    Its pictures are made in a folder that goes with it.

    Args:
        source: The recorded run; of a fleet, that of the robot with the change.
        change: Takes effect at the fork.
        step_ns: The control step of the fork.
        require: Files of further requirements.

    Raises:
        BtMissionError: For a change that does not fit; from what gives the result, where the run
            is not the same up to the fork.
    """
    mission = with_requirements(change.mission_of(source.mission), require)
    parted: list[str] = []
    forked = {source.name: ForkedRun(source, change, step_ns, mission, parted)}
    members = {source.name: source.member(mission)}
    more = faults_in_texts(change.faults)
    refuse_earlier(more, source.seconds(step_ns))
    faults = [
        replace(fault, robot=source.name) for fault in (*faults_in_texts(source.faults), *more)
    ]
    for other in source.others:
        forked[other.name] = ForkedRun(other, ForkChange(), step_ns, other.mission, parted)
        members[other.name] = other.member(other.mission)
        faults += [replace(fault, robot=other.name) for fault in faults_in_texts(other.faults)]
    with (
        TemporaryDirectory() as folder,
        Stage(
            robots=[members[name] for name in source.names],
            image_folder=Path(folder),
            say=lambda _: None,
            options=source.options(props=MOST_OBSTACLES if faults else 0),
        ) as stage,
        planned_on(stage, faults) as with_outcomes,
    ):
        for robot in forked.values():
            robot.follow(stage)
        if source.fleet:
            stage.facts["fleet"] = source.fleet
        stage[source.name].facts |= forked[source.name].facts

        def finish(reports: Reports) -> ForkResult:
            by_name = {run.name: report for run, report in zip(stage.runs, reports, strict=True)}
            results = {
                name: forked[name].result(with_outcomes(by_name[name], name))
                for name in (*parted, *forked)
            }
            others = tuple(results[other.name] for other in source.others)
            return replace(results[source.name], others=others)

        yield stage, finish
