"""Results of a test: properties for JUnit's file, and the files of a failed one.

A failed test leaves a folder of its own with what happened in its runs; one that passes none,
unless all are to be recorded.
"""

from __future__ import annotations

import hashlib
import os
import re
import shlex
import shutil
from collections.abc import Generator, Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import pytest

from bt_mission.base.text import escape_control, escape_lines, escape_uncoloured
from bt_mission.testing.options import MOST_RUNS

if TYPE_CHECKING:
    from bt_mission.testing.failure_recording import FailureRecording
    from bt_mission.testing.live_graph import LiveGraph
    from bt_mission.testing.run import Run
    from bt_mission.testing.stages import Stages

STAGES: pytest.StashKey[list[Stages]] = pytest.StashKey()
GRAPHS: pytest.StashKey[list[LiveGraph]] = pytest.StashKey()
WALL_S = pytest.StashKey[float]()
FOLDER = pytest.StashKey[Path]()

DEFAULT = "scenario_results"
LIBRARY = Path(__file__).parents[1]
RECORD = ("off", "failed", "all")


class Results:
    """Hooks of one session."""

    def __init__(self, config: pytest.Config) -> None:
        given = config.getoption("scenario_results")
        self._leaves_all = what_to_record(config) == "all"
        self._here = config.invocation_params.dir
        self._parent = self._here / given if given else config.rootpath / DEFAULT

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Take away what this test left the last time."""
        shutil.rmtree(self._folder_of(item), ignore_errors=True)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Tell of the runs of a test."""
        if call.excinfo is not None and not item.config.getoption("fulltrace"):
            hide_library(call.excinfo)
        report = yield
        runs = _runs_of(item)
        if report.when == "call":
            item.stash[WALL_S] = report.duration
        if report.failed:
            self._tell(item, report, runs)
        if report.when == "teardown":
            if self._leaves_all and runs:
                item.stash.setdefault(FOLDER, self._folder_of(item))
            if FOLDER in item.stash:  # once more: now the runs have ended
                with suppress(OSError):  # told when it was tried first
                    self.leave(item.stash[FOLDER], runs)
            for run in runs:
                if run.recording is not None:
                    run.recording.discard()
            if runs:
                report.user_properties += properties(runs, item.stash.get(WALL_S, 0.0))
                # pytest keeps the item to the end of the session; a run is 3 MB.
                del item.stash[STAGES]
        return report

    def leave(self, folder: Path, runs: list[Run]) -> list[Path]:
        """Write down what happened; gives what can be replayed, a file for each run.

        Raises:
            OSError: Where that cannot be written.
        """
        self._make_folder(folder)
        paths = []
        for number, run in enumerate(runs, 1):
            suffix = _suffix(number)
            trace = folder / f"trace{suffix}.jsonl"
            lines = (f"{line}\n" for line in run.history.events)
            trace.write_text("".join(lines), encoding="utf-8")
            text_file = folder / f"run{suffix}.txt"
            text_file.write_text(run.describe() + "\n", encoding="utf-8")
            recording = folder / f"recording{suffix}.mcap"
            is_recorded = run.recording is not None and run.recording.leave(recording)
            paths.append(recording if is_recorded else trace)
            if run.is_done:
                leave_scenario(run, folder / f"scenario{suffix}.yaml")
        return paths

    def keep(self, item: pytest.Item, recording: FailureRecording) -> str:
        """Keep the recording of a run that no fixture has made; gives what to type."""
        path = self._folder_of(item) / "recording.mcap"
        try:
            self._make_folder(path.parent)
            is_left = recording.leave(path)
        except OSError as error:
            return _unsaved(error, path)
        lacks = recording.missing and f"  the recording lacks {recording.missing}"
        return "\n".join(filter(None, (self._replay_of(path) if is_left else "", lacks)))

    def _make_folder(self, folder: Path) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        (self._parent / ".gitignore").write_text("*\n", encoding="utf-8")

    def replay_command(self, item: pytest.Item, run: Run) -> str:
        """Return what to type to see a run of a test again, once that has failed.

        Before that, the file is not there.
        """
        runs = _runs_of(item)
        if run not in runs:
            return ""
        suffix = _suffix(runs.index(run) + 1)
        name = f"trace{suffix}.jsonl" if run.recording is None else f"recording{suffix}.mcap"
        return self._replay_of(self._folder_of(item) / name)

    def _replay_of(self, path: Path) -> str:
        return f"bt-mission replay {shlex.quote(os.path.relpath(path, self._here))}"

    def _tell(self, item: pytest.Item, report: pytest.TestReport, runs: list[Run]) -> None:
        """Show and leave what happened; leave it once."""
        if runs:
            escape_error(report)
        if FOLDER in item.stash:
            return
        sections = [("mission", run.describe()) for run in runs]
        for graph in item.stash.get(GRAPHS, []):
            sections += [(f"process {process.name}", process.output) for process in graph.processes]
        report.sections += [(escape_control(title), escape_lines(text)) for title, text in sections]
        if runs:
            item.stash[FOLDER] = self._folder_of(item)
            report.sections.append(("to see it again", self._left(item.stash[FOLDER], runs)))

    def _left(self, folder: Path, runs: list[Run]) -> str:
        """Leave what happened; gives what to type."""
        try:
            paths = self.leave(folder, runs)
        except OSError as error:
            return _unsaved(error, folder)
        lines = []
        for run, path in zip(runs, paths, strict=True):
            lines.append(self._replay_of(path))
            lines += self._run_again(run, path)
            if run.recording is not None and run.recording.missing:
                lines.append(f"  the recording lacks {run.recording.missing}")
        return "\n".join(lines)

    def _run_again(self, run: Run, path: Path) -> list[str]:
        """Return what to type to run the same again, or why that cannot be."""
        from bt_mission.scenarios.writer import NotExpressibleError, refuse_inexpressible

        suffix = path.stem.removeprefix("recording").removeprefix("trace")
        scenario = path.parent / f"scenario{suffix}.yaml"
        try:
            refuse_inexpressible(run)
        except NotExpressibleError as error:
            return [f"  no scenario was written: {error}"]
        return [f"bt-mission run {shlex.quote(os.path.relpath(scenario, self._here))}"]

    def _folder_of(self, item: pytest.Item) -> Path:
        return self._parent / folder_name(item.nodeid)


def _suffix(number: int) -> str:
    """Return the end of the names of files of a run: none of the first one, however many follow."""
    return f"_{number}" if number > 1 else ""


def leave_scenario(run: Run, path: Path) -> None:
    """Write the scenario of a run that has ended, if it can be written as data.

    Raises:
        OSError: Where that cannot be written.
    """
    from bt_mission.scenarios.writer import NotExpressibleError, scenario_text

    try:
        text = scenario_text(run, path.parent.name, path.parent)
    except NotExpressibleError:
        return
    path.write_text(text, encoding="utf-8")


def hide_library(excinfo: pytest.ExceptionInfo[BaseException]) -> None:
    """Remove frames of bt-mission from the traceback of an error of a test.

    It then ends at the line of the test. Of any other error they stay: it may be our own.
    """
    shown = _without_library(excinfo.tb)
    if shown is not None and type(excinfo.value).__module__.startswith(f"{LIBRARY.name}."):
        excinfo.traceback = type(excinfo.traceback)(shown)


def escape_error(report: pytest.TestReport) -> None:
    """Escape the message of an error, which may quote what a server or a mission says.

    Its further lines are indented: where ``CI`` is set, pytest prints them all in the summary, and
    none should look like a separate line.
    """
    for traceback, crash, _ in getattr(report.longrepr, "chain", ()):
        for entry in traceback.reprentries:
            entry.lines = [
                escape_uncoloured(line) if line.startswith("E") else line for line in entry.lines
            ]
        if crash is not None:
            crash.message = escape_lines(crash.message).replace("\n", "\n  ")


def _without_library(entry: TracebackType | None) -> TracebackType | None:
    """Return a traceback without our frames.

    `__tracebackhide__` would have to stand in every function that an error can come through.
    """
    if entry is None:
        return None
    inner = _without_library(entry.tb_next)
    if Path(entry.tb_frame.f_code.co_filename).is_relative_to(LIBRARY):
        return inner
    return TracebackType(inner, entry.tb_frame, entry.tb_lasti, entry.tb_lineno)


def _runs_of(item: pytest.Item) -> list[Run]:
    return [run for made in item.stash.get(STAGES, []) for run in made.runs][-MOST_RUNS:]


def sample_of_runs(item: pytest.Item) -> str:
    """Return a text that is equal for tests whose runs have the same outcomes and signals.

    Empty for a test without a run on the stage.
    """
    return " ".join(run.report.sample for run in _runs_of(item))


def what_to_record(config: pytest.Config) -> str:
    """One of :data:`RECORD`.

    Raises:
        pytest.UsageError: For an invalid ini option.
    """
    chosen = config.getoption("mission_record") or config.getini("mission_record")
    if chosen not in RECORD:
        raise pytest.UsageError(
            f"mission_record: expected one of {', '.join(RECORD)}, got '{chosen}'"
        )
    return str(chosen)


def folder_name(nodeid: str) -> str:
    """A name for the folder of a test, alike for no two."""
    plain = re.sub(r"\.py(?=::)|\]$", "", nodeid).replace("::", ".").replace("/", ".")
    name = re.sub(r"[^\w.-]+", "-", plain.replace("[", "-"))
    if name == plain.replace("[", "-") and len(name) <= 120:
        return name
    return f"{name[:100]}-{hashlib.sha256(nodeid.encode()).hexdigest()[:8]}"


def properties(runs: list[Run], wall_s: float) -> Iterator[tuple[str, object]]:
    """What stands beside a test in JUnit's file: seconds in all, seed and trace of each run."""
    yield "virtual_s", round(sum(run.t for run in runs), 6)
    yield "wall_s", round(wall_s, 6)
    for run in runs:
        yield "seed", run.mission.seed
        yield "trace_sha256", run.stage.trace.sha256


def _unsaved(error: OSError, place: Path) -> str:
    """Return the reason; an error of writing does not know its file."""
    return f"it was not saved: {error.filename or place}: {error.strerror}"
