"""Runs concrete scenarios in this process, one after another."""

from __future__ import annotations

import json
import os
import socket
import traceback
from collections.abc import AsyncGenerator, Callable, Iterable
from contextlib import redirect_stdout
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Protocol, Self, TypeVar

from bt_mission.base.clock_watch import is_main_thread, run_apart, told_by
from bt_mission.base.diagnostics import Diagnostic, InputError
from bt_mission.base.errors import BtMissionError
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.base.yaml.document import read_text
from bt_mission.language.trees import has_python
from bt_mission.scenarios.concrete.base_scenario import BaseScenario
from bt_mission.scenarios.concrete.bundle import MISSION_FOLDER, Bundle, fingerprint
from bt_mission.scenarios.concrete.concrete_scenario import ConcreteScenario
from bt_mission.scenarios.concrete.ranges import Parameter
from bt_mission.scenarios.concrete.row import ScenarioRow, row_of, row_of_error
from bt_mission.scenarios.loader import load_scenario
from bt_mission.scenarios.run import run_scenario
from bt_mission.scenarios.scenario import Scenario, ScenarioResult

T = TypeVar("T")


class ScenarioRunner(Protocol):
    """Runs concrete scenarios of one bundle: a worker in this process, or a pool of many."""

    def rows(self, scenarios: Iterable[ConcreteScenario]) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario, in the order in which they end."""


class ScenarioWorker:
    """Runs scenarios of a bundle; what it sets up for the first serves all.

    Args:
        bundle: The files of all scenarios.
        run: Runs one, as `run_scenario` does.

    Use it as a context manager, or close it: it has a temporary folder.
    """

    def __init__(self, bundle: Bundle, run: Callable[..., ScenarioResult] = run_scenario) -> None:
        self._bundle = bundle
        self._run = run
        self._folder = TemporaryDirectory(prefix="bt_mission_", ignore_cleanup_errors=True)
        self.name = f"{socket.gethostname()}:{os.getpid()}"
        bundle.write_to(Path(self._folder.name))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove its folder."""
        self._folder.cleanup()

    def load(self, scenario: ConcreteScenario) -> Scenario:
        """Load a concrete scenario.

        Raises:
            InputError: With its errors; the mission's files have the user's names.
        """
        place = Path(self._folder.name) / self._bundle.mission
        # JSON is YAML, and leaves no doubt about what is a text.
        text = json.dumps(dict(scenario.data), ensure_ascii=False)
        document = read_text(text, str(place.with_name(f"{scenario.id}.scenario.yaml")))
        try:
            return load_scenario(document)
        except InputError as error:
            raise InputError(
                replace(
                    fault, message=self._for_user(fault.message), file=self._for_user(fault.file)
                )
                for fault in error.diagnostics
            ) from error

    def refuse_values(self, base: BaseScenario, parameters: Iterable[Parameter]) -> None:
        """Load the base as it is, and with each end of each parameter.

        Raises:
            InputError: With the errors of the base, or else with each refused value at its place.
        """
        self.load(base.concrete({}))
        wrong: list[Diagnostic] = []
        for parameter in parameters:
            for value in parameter.ends:
                try:
                    self.load(base.concrete({parameter.name: value}))
                except InputError as error:
                    wrong += [
                        replace(
                            parameter.place, code=each.code, message=each.message, hint=each.hint
                        )
                        for each in error.diagnostics
                        if each.severity == "error"
                    ]
        if wrong:
            raise InputError(list(dict.fromkeys(wrong)))

    def run_again(self, scenario: ConcreteScenario, run: Callable[[Scenario], T]) -> T:
        """Run a concrete scenario in another way, and return what that gives.

        Raises:
            BtMissionError: It cannot run.
        """
        loaded = self.load(scenario)
        return _apart(loaded, partial(run, loaded))

    async def rows(
        self, scenarios: Iterable[ConcreteScenario]
    ) -> AsyncGenerator[ScenarioRow, None]:
        """Yield the row of each scenario, in order."""
        for scenario in scenarios:
            yield self.carry_out(scenario)

    def carry_out(self, scenario: ConcreteScenario) -> ScenarioRow:
        """Run a concrete scenario; any error is its row.

        The output of its leaves is dropped: that of thousands would hide everything else.
        """
        watch = Stopwatch()
        try:
            with Path(os.devnull).open("w") as nowhere, redirect_stdout(nowhere):
                loaded = self.load(scenario)
                result = _apart(loaded, partial(self._run, loaded, with_coverage=True))
            row = row_of(scenario, result, wall_s=watch.elapsed_s)
        except InputError as error:
            row = row_of_error(scenario, "; ".join(fault.message for fault in error.diagnostics))
        except BtMissionError as error:
            row = row_of_error(scenario, self._for_user(str(error)))
        except Exception as error:  # noqa: BLE001 - one scenario must not stop the others
            where = traceback.extract_tb(error.__traceback__)[-1]
            place = f"{Path(where.filename).name}:{where.lineno}"
            row = row_of_error(scenario, f"{type(error).__name__} at {place}: {error}")
        return replace(row, versions=fingerprint(), worker=self.name)

    def _for_user(self, text: str) -> str:
        """Return a message with the paths of the user instead of those of the worker's folder."""
        written = "" if self._bundle.folder in ("", ".") else f"{self._bundle.folder}/"
        mine = f"{self._folder.name}/"
        return text.replace(f"{mine}{MISSION_FOLDER}/", written).replace(mine, "")


def _apart(scenario: Scenario, run: Callable[[], T]) -> T:
    """Run a scenario; code of users that does not return is left behind in its own thread.

    The result says what has held the clock, so that no line does.

    Raises:
        HeldClockError: It was left behind.
    """
    has_code = scenario.mission.nodes or scenario.simulator or has_python(scenario.mission)
    with told_by(lambda _: None):
        return run_apart(run) if has_code and not is_main_thread() else run()
