"""Runs of scenarios that are recorded, and the report of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from bt_mission.executive.report import Report
from bt_mission.recording.writer import RunRecorder
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.scenario import Scenario, ScenarioResult
from bt_mission.sessions.stage import Stage
from bt_mission.views.web.report.page import write_report


def record_scenario(scenario: Scenario, path: Path) -> ScenarioResult:
    """Run a scenario, and record it.

    Raises:
        BtMissionError: The recording cannot be written.
    """

    @contextmanager
    def recorder(stage: Stage) -> Iterator[Callable[[Report], None]]:
        with RunRecorder(stage, path) as recorder:
            yield lambda report: recorder.finish(report.as_dict())

    path.unlink(missing_ok=True)
    return run_scenario(scenario, keep=recorder)


def recording_and_report(scenario: Scenario) -> tuple[bytes, bytes]:
    """Run a scenario. Return its recording, and the page of its report.

    Raises:
        BtMissionError: It cannot run, or be recorded.
    """
    with TemporaryDirectory(prefix="bt_mission_") as folder:
        recording = Path(folder) / "run.mcap"
        page = recording.with_suffix(".html")
        record_scenario(scenario, recording)
        write_report(recording, page)
        return recording.read_bytes(), page.read_bytes()
