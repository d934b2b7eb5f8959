"""Scenario files as tests: ``*.scenario.yaml`` is collected, run, and judged by what it expects."""

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

from bt_mission.core.errors import BtMissionError
from bt_mission.core.text import escape_control, escape_lines
from bt_mission.scenarios.loader import load_scenario
from bt_mission.testing.results import STAGES, Results, what_to_record
from bt_mission.testing.stages import Stages


class ScenarioFailed(AssertionError):  # noqa: N818 - its name stands in pytest's summary
    """A scenario had another result than expected."""


class ScenarioItems(pytest.File):
    """A file with one scenario."""

    @override
    def collect(self) -> Iterator[ScenarioItem]:
        name = self.path.name.removesuffix(".scenario.yaml")
        yield ScenarioItem.from_parent(self, name=name)


class ScenarioItem(pytest.Item):
    """A scenario that is run as a test."""

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        self._folder: TemporaryDirectory[str] | None = None

    @override
    def setup(self) -> None:
        self._folder = TemporaryDirectory()
        folder = Path(self._folder.name)
        os.environ.setdefault("ROS_LOG_DIR", str(folder / "log"))
        results = self.config.pluginmanager.get_plugin("bt_mission_results")
        assert isinstance(results, Results), "pytest_configure has registered it"
        stages = Stages(
            folder,
            records=what_to_record(self.config) != "off",
            replay=partial(results.replay_command, self),
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
        if self._folder is not None:
            self._folder.cleanup()

    @override
    def repr_failure(
        self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None
    ) -> str | TerminalRepr:
        """Tell what is wrong by its place in the file; of anything else the traceback."""
        if isinstance(excinfo.value, ScenarioFailed | BtMissionError):
            return escape_lines(str(excinfo.value))
        return super().repr_failure(excinfo, style)

    @override
    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, escape_control(f"scenario {self.name}")
