"""The stage on which a recorded run is run again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.executive.report import Report
from bt_mission.faults.located import faults_in_texts, planned_on
from bt_mission.faults.world import MOST_OBSTACLES
from bt_mission.language.checks.requirements import with_requirements
from bt_mission.recording.forks.change import ForkChange, refuse_earlier
from bt_mission.recording.forks.fork import ForkedRun, ForkResult
from bt_mission.recording.forks.source import ForkSource
from bt_mission.sessions.stage import Stage

Finish = Callable[[Report], ForkResult]
"""Gives what a fork came to, of the report of its run."""


@contextmanager
def forked_stage(
    source: ForkSource,
    change: ForkChange,
    step_ns: int,
    *,
    require: Sequence[Path] = (),
    limit_s: float | None = None,
) -> Iterator[tuple[Stage, Finish]]:
    """Put a recorded run on the stage again, to be stepped to its end.

    Its pictures are made in a folder that goes with it.

    Args:
        source: The recorded run.
        change: Takes effect at the fork.
        step_ns: The control step of the fork.
        require: Files of further requirements.
        limit_s: Virtual seconds after which it is interrupted; None is none.

    Raises:
        BtMissionError: For a change that does not fit; from what gives the result, where the run
            is not the same up to the fork.
    """
    mission = with_requirements(change.mission_of(source.mission), require)
    forked = ForkedRun(source, change, step_ns, mission)
    faults = faults_in_texts([*source.faults, *change.faults])
    refuse_earlier(faults[len(source.faults) :], source.seconds(step_ns))
    options = source.options(props=MOST_OBSTACLES if faults else 0)
    with (
        TemporaryDirectory() as folder,
        Stage(mission, image_folder=Path(folder), say=lambda _: None, options=options) as stage,
        planned_on(stage, faults) as with_outcomes,
    ):
        forked.follow(stage, limit_s)
        stage.facts |= forked.facts
        yield stage, lambda report: forked.result(with_outcomes(report))
