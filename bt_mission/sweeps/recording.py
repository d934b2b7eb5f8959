"""Recordings of scenarios, with their pages."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.core.output import write_file
from bt_mission.executive.report import Report
from bt_mission.faults.located import planned_on
from bt_mission.recording.verification import read_verified_run
from bt_mission.recording.writer import RunRecorder
from bt_mission.scenarios.run import stop_at
from bt_mission.scenarios.scenario import Scenario
from bt_mission.sessions.session import summarise
from bt_mission.sessions.stage import Stage
from bt_mission.views.html_report.page import page_of

FOLDER = "recordings"
"""Where they lie among the results of a sweep."""


def record_scenario(scenario: Scenario, path: Path) -> Report:
    """Carry a scenario out, and record it; gives what it came to.

    Raises:
        BtMissionError: Where it cannot be written.
    """
    path.unlink(missing_ok=True)
    with ExitStack() as stack:
        images = Path(stack.enter_context(TemporaryDirectory()))
        options = scenario.stage_options
        stack.enter_context(scenario.at_its_start())
        stage = stack.enter_context(
            Stage(scenario.mission, image_folder=images, say=lambda _: None, options=options)
        )
        stop_at(stage, scenario.limit)
        with_outcomes = stack.enter_context(planned_on(stage, scenario.faults))
        recorder = stack.enter_context(RunRecorder(stage, path))
        while not stage.is_done:
            stage.step()
        report = with_outcomes(summarise(stage, 0.0))
        recorder.finish(report.as_dict())
        return report


def write_page_of(recording: Path, page: Path) -> None:
    """Write the page of a recording.

    Raises:
        BtMissionError: Where it cannot be written.
    """
    write_file(page, page_of(read_verified_run(recording)))
