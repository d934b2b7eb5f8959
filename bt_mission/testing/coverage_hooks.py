"""The part of the plugin that measures the coverage of missions while tests run.

With pytest-xdist each worker watches its own, and sends what it saw when it ends; the process that
started them adds it up.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Generator, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from bt_mission.base import files
from bt_mission.base.errors import BtMissionError
from bt_mission.base.output import write_file
from bt_mission.base.text import escape_control
from bt_mission.base.yaml.document import Document
from bt_mission.ros.mission_runner import MissionRunner
from bt_mission.scenarios.coverage.places import CoveragePlace, places
from bt_mission.scenarios.coverage.record import CoverageTally, CoveredFile
from bt_mission.scenarios.coverage.watch import CoverageWatch
from bt_mission.sessions.load import load
from bt_mission.testing.coverage_report import as_html, as_text

if TYPE_CHECKING:
    from _pytest.terminal import TerminalReporter

    from bt_mission.language.mission import Mission

SENT = "bt_mission_coverage"
WRITERS: dict[str, Callable[[CoverageTally], str]] = {
    ".json": lambda tally: json.dumps(tally.report(), indent=2) + "\n",
    ".html": as_html,
    ".txt": lambda tally: "\n".join([*as_text(tally), ""]),
}
"""How a report of each kind of file is made."""


class CoverageHooks:
    """Hooks of one session.

    Raises:
        pytest.UsageError: For a report of an unknown kind.
    """

    def __init__(self, config: pytest.Config) -> None:
        self._config = config
        self._tally = CoverageTally()
        self._test_file = ""
        self._lost = 0
        self._unread: list[str] = []
        self._is_worker = hasattr(config, "workerinput")
        scratch = config.getoption("basetemp")
        self._scratch = Path(scratch).resolve() if scratch else None
        self._reports = [Path(report) for report in config.getoption("mission_cov_report")]
        for path in self._reports:
            if path.suffix not in WRITERS:
                raise pytest.UsageError(
                    f"--mission-cov-report: {path} must end in one of {', '.join(WRITERS)}"
                )
        MissionRunner.created.subscribe(self._watch)

    def pytest_unconfigure(self) -> None:
        """Watch no more."""
        MissionRunner.created.unsubscribe(self._watch)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Know the test that runs."""
        self._test_file = item.nodeid.partition("::")[0]
        return (yield)

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Take in what a worker has seen."""
        output = getattr(node, "workeroutput", None)
        if output is None:
            self._lost += 1
        else:
            self._tally.take(json.loads(output[SENT]))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Generator[None, object, object]:
        """Once all tests have run: fail where too little was reached."""
        result = yield
        if not self._is_worker:
            self._take_sources()
            if self._shortfall:
                session.testsfailed += 1
        return result

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self) -> None:
        """Send what was seen, or write it down."""
        if self._is_worker:
            self._config.workeroutput[SENT] = json.dumps(self._tally.data())  # type: ignore[attr-defined]
            return
        for path in self._reports:
            path.parent.mkdir(parents=True, exist_ok=True)
            write_file(path, WRITERS[path.suffix](self._tally))

    def pytest_terminal_summary(self, terminalreporter: TerminalReporter) -> None:
        """Show the table, and what was not reached."""
        terminalreporter.section("coverage of missions")
        for line in self._summary():
            terminalreporter.line(escape_control(line))
        if self._shortfall:
            terminalreporter.line(f"FAILED: {self._shortfall}", red=True)

    # ---- what is told --------------------------------------------------------------------

    @property
    def _shortfall(self) -> str:
        """How much is missing of what was asked for; empty where nothing is."""
        wanted = self._config.getoption("mission_cov_fail_under")
        percent = self._tally.score.percent if self._tally else 0.0
        if wanted is None or percent >= wanted:
            return ""
        return f"coverage of missions is {percent:.2f}%, below {wanted:g}%"

    def _summary(self) -> Iterator[str]:
        if self._tally:
            yield from as_text(self._tally, brief=True)
        else:
            yield "no mission was run in this process or its workers"
        yield from self._unread
        if self._lost:
            yield f"{self._lost} of the workers crashed; their coverage is lost"
        if self._reports:
            yield f"written to {', '.join(map(str, self._reports))}"

    # ---- what is seen --------------------------------------------------------------------

    def _watch(self, runner: MissionRunner) -> None:
        """Watch a mission that is set up in this process."""
        CoverageWatch(runner.mission, runner.executive, self._know(runner.mission))

    def _know(self, mission: Mission) -> dict[int, CoveragePlace]:
        """Take in what there is to reach in a mission; gives its places by their steps."""
        located = list(places(mission))
        known: dict[int, CoveragePlace] = {}
        for document in {covered.file: covered for covered, _, _ in located}.values():
            of_file = {
                place.key: place for covered, _, place in located if covered.file == document.file
            }
            path = self._named(document)
            label = path or f"{self._test_file} '{mission.name}'"
            key = label if path else f"{label} {_shape(of_file)}"
            self._tally.add(key, CoveredFile(label, {mission.name}, document.lines, of_file))
            counted = self._tally.files[key].places
            known |= {
                id(step): counted[place.key]
                for covered, step, place in located
                if covered.file == document.file
            }
        return known

    def _named(self, document: Document) -> str:
        """What a file of missions is called; empty for a text, or a file that a test has made."""
        path = Path(document.file)
        if not path.is_file():
            return ""
        real = path.resolve()
        if self._scratch is not None and real.is_relative_to(self._scratch):
            return ""
        if real.is_relative_to(self._config.rootpath):
            return real.relative_to(self._config.rootpath).as_posix()
        for folder in files.folders("missions"):
            if real.is_relative_to(folder.resolve()):
                return f"bt_mission:{real.relative_to(folder.resolve()).as_posix()}"
        return ""

    def _take_sources(self) -> None:
        """Take in the missions that should be covered, whether or not a test has run them."""
        for source in self._config.getoption("mission_cov_source"):
            path = Path(source)
            shape_files = sorted(path.rglob("*.yaml")) if path.is_dir() else [path]
            for file in shape_files:
                if files.kind_of(file) != "mission":
                    continue
                try:
                    self._know(load(file))
                except BtMissionError as error:
                    self._unread.append(f"not counted: {str(error).splitlines()[0]}")


def _shape(shapes: Iterable[tuple[int, int, str]]) -> str:
    """Tells texts of one name apart by their trees, not by numbers that a test puts into them."""
    return hashlib.sha256(repr(list(shapes)).encode()).hexdigest()[:8]
