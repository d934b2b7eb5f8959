"""Files as tests: ``*.scenario.yaml`` and ``*.fleet.yaml`` are collected, run and judged."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from _pytest._code.code import TerminalRepr
from typing_extensions import override

from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control, escape_lines
from bt_mission.scenarios.fleets.loader import load_fleet
from bt_mission.scenarios.fleets.report import FleetReport
from bt_mission.scenarios.fleets.run import fleet_report, fleet_stage
from bt_mission.scenarios.loader import load_scenario
from bt_mission.sessions.drive import drive
from bt_mission.testing.failure_recording import FailureRecording
from bt_mission.testing.results import STAGES, Results, what_to_record
from bt_mission.testing.stages import Stages


class ScenarioFailed(AssertionError):  # noqa: N818 - its name stands in pytest's summary
    """A scenario had another result than expected."""


class FleetFailed(AssertionError):  # noqa: N818 - its name stands in pytest's summary
    """A mission of a fleet did not succeed, or a requirement fails."""


class FileItems(pytest.File):
    """A file with one scenario or fleet."""

    @override
    def collect(self) -> Iterator[FileItem]:
        for kind in (ScenarioItem, FleetItem):
            name = self.path.name.removesuffix(f".{kind.what}.yaml")
            if name != self.path.name:
                yield kind.from_parent(self, name=name)


class FileItem(pytest.Item):
    """A file that is run as a test.

    Attributes:
        what: The kind of file.
    """

    what: str

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self._folder: TemporaryDirectory[str] | None = None

    @override
    def setup(self) -> None:
        self._folder = TemporaryDirectory()
        os.environ.setdefault("ROS_LOG_DIR", str(self.folder / "log"))

    @property
    def folder(self) -> Path:
        """For files, while the test runs."""
        assert self._folder is not None, "it is made in `setup`"
        return Path(self._folder.name)

    @property
    def results(self) -> Results:
        """Where a failed test leaves its files."""
        results = self.config.pluginmanager.get_plugin("bt_mission_results")
        assert isinstance(results, Results), "pytest_configure has registered it"
        return results

    @override
    def teardown(self) -> None:
        if self._folder is not None:
            self._folder.cleanup()

    @override
    def repr_failure(
        self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None
    ) -> str | TerminalRepr:
        """Tell what is wrong by its place in the file; of anything else the traceback."""
        if isinstance(excinfo.value, ScenarioFailed | FleetFailed | BtMissionError):
            return escape_lines(str(excinfo.value))
        return super().repr_failure(excinfo, style)

    @override
    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, escape_control(f"{self.what} {self.name}")


class ScenarioItem(FileItem):
    """A scenario that is run as a test: it passes with the expected result."""

    what = "scenario"

    @override
    def setup(self) -> None:
        super().setup()
        stages = Stages(
            self.folder,
            records=what_to_record(self.config) != "off",
            replay=partial(self.results.replay_command, self),
        )
        self.stash.setdefault(STAGES, []).append(stages)

    @override
    def runtest(self) -> None:
        (stages,) = self.stash[STAGES]
        result = stages.run_scenario(load_scenario(self.path))
        if not result.passed:
            raise ScenarioFailed("\n".join(map(str, result.differences)))

    @override
    def teardown(self) -> None:
        for stages in self.stash[STAGES]:
            stages.close()
        super().teardown()


class FleetItem(FileItem):
    """A fleet that is run as a test: it passes where `bt-mission run` exits with 0."""

    what = "fleet"

    @override
    def runtest(self) -> None:
        report, recording = self._run()
        if any(robot.mission.reason.startswith("interrupted by") for robot in report.robots):
            raise KeyboardInterrupt
        for robot in report.robots:
            self.user_properties += [
                ("seed", robot.mission.seed),
                ("trace_sha256", robot.mission.trace_sha256),
            ]
        has_failed = not report.passed
        kept = ""
        if recording and (has_failed or what_to_record(self.config) == "all"):
            kept = f"\n{self.results.keep(self, recording)}"
        if has_failed:
            raise FleetFailed(f"{report}{kept}")

    def _run(self) -> tuple[FleetReport, FailureRecording | None]:
        """Run it, and record it if it is to be recorded."""
        plan = load_fleet(self.path)
        recording = None
        with fleet_stage(plan) as stage:
            if what_to_record(self.config) != "off":
                recording = FailureRecording(stage, self.folder / "recording.mcap")
            report = fleet_report(plan.name, stage, drive(stage))
            if recording is not None:
                recording.finish(report.as_dict())
        return report, recording
