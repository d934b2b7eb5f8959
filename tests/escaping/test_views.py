"""Every text that an executive tells, a recording or a trace holds, in every view of it."""

from __future__ import annotations

import asyncio
import io
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from py_trees.common import Status

from bt_mission.cli.main import main
from bt_mission.executive.events import reader
from bt_mission.executive.events.codec import json_line
from bt_mission.executive.events.events import NodeChanged
from bt_mission.executive.events.feed import MissionFeed
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import ControlResponse, ListedExecutive, Received
from bt_mission.executive.leaf_statistics import LeafSummary
from bt_mission.executive.report import FailurePath, Report
from bt_mission.executive.trace import VERSION
from bt_mission.recording.model import RecordedRun
from bt_mission.recording.recorded_messages import EXECUTIVE
from bt_mission.ros.interface_types import message_type, service_type
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.scenarios.coverage.record import CoverageTally, CoveredFile
from bt_mission.testing.coverage_report import as_html
from bt_mission.views.terminal.console import EscapingConsole, coloured
from bt_mission.views.terminal.lines import PlainLines, leaf_table, log_line, whole_tree
from bt_mission.views.terminal.live_view import LiveTree, LiveView, PlainView
from bt_mission.views.terminal.marks import ASCII_SIGNS, SIGNS
from bt_mission.views.tui.app import WatchApp
from bt_mission.views.web.report.details import details
from bt_mission.views.web.report.page import RobotRun, page_of
from tests.support.hostile import (
    HOSTILE,
    MARK,
    MARKUP,
    SHORT,
    escape_nothing,
    fill,
    filled,
    leaks,
    markup_leaks,
)
from tests.support.played_session import PlayedSession
from tests.support.watched import ScriptedExecutive, ScriptedGraph

BRIEF = MARK + SHORT + "\nFORGED [reverse]m[/]"
"""Short enough to stand in a panel as a whole."""


def batches_of(text: str = HOSTILE) -> Iterator[Any]:
    """All that an executive tells, each text of each message hostile."""
    for type_name, read in EXECUTIVE.items():
        message = fill(message_type(type_name)(), text)
        if type_name.endswith("StatusChanges"):
            message.sequence = 1
        if type_name.endswith("Details"):
            message.running[0].limit, message.goals[0].state = 2.0, "active"
        yield read(message)
    answer = fill(service_type("bt_mission_interfaces/srv/GetStatuses").Response(), text)
    answer.sequence = 1
    yield reader.statuses(answer)


def watched(text: str = HOSTILE) -> tuple[MissionState, list[Any]]:
    """A mission that was told of, and what has happened in it."""
    feed = MissionFeed(MissionState())
    return feed.mission, [happened for batch in batches_of(text) for happened in feed.take(batch)]


@pytest.mark.parametrize("marks", [SIGNS, ASCII_SIGNS], ids=["utf-8", "ascii"])
@pytest.mark.parametrize("width", [None, 60, 4000])
def test_a_watched_mission_in_lines(marks, width):
    """The tree once, and a line for each thing that happens."""
    mission, events = watched()
    lines = list(whole_tree(mission, marks, width))
    lines += [log_line(entry, 0, marks) for event in events if (entry := mission.entry_of(event))]
    assert len(lines) > 4
    assert all(MARK in line for line in lines if line != "requirements")
    assert leaks("\n".join(lines)) == []


def test_a_watched_mission_in_json():
    """Plain ASCII, with every text as it came."""
    mission, events = watched()
    assert mission.tree is not None
    lines = [json_line(event, mission.tree.nodes) for event in events]
    assert leaks("\n".join(lines)) == []
    assert HOSTILE in {json.loads(line).get("text") for line in lines}


class HostileExecutive(ScriptedExecutive):
    """An executive that tells all that it can at once."""

    def __init__(self) -> None:
        super().__init__(name=BRIEF)
        self._received = Received(tuple(batches_of(BRIEF)), (), (filled(ControlResponse, BRIEF),))

    def take(self, *, needs_statuses: bool) -> Received:
        return self._received


def screens() -> str:
    """All panels, a list to choose from, and what the line for notices says."""

    async def scene() -> list[str]:
        shown = []
        graph = ScriptedGraph(HostileExecutive())
        graph.faults[BRIEF] = filled(ListedExecutive, BRIEF)
        app = WatchApp(graph, SIGNS)
        async with app.run_test(size=(300, 60)) as pilot:
            app.attach(BRIEF)
            for key in (None, "tab", "tab", "tab", "tab", "b", "c", "escape", "question_mark"):
                if key:
                    await pilot.press(key)
                app.look()
                await pilot.pause()
                strips = app.screen._compositor.render_strips()
                shown += [strip.text for strip in strips]
            app.show_notice(BRIEF)
        return shown

    return "\n".join(asyncio.run(scene()))


def test_a_watched_mission_on_a_full_screen():
    """The tree and every panel, and the dialog of executives."""
    shown = screens()
    for output in ("MARK", "[reverse]m[/]", "x1b]52;c;A", "executives"):
        assert output in shown
    assert leaks(shown) == []


# ---- a mission that runs here ----------------------------------------------------------------


class Runs:
    """A mission that runs, whose every name and message is hostile."""

    def __init__(self, play: Any) -> None:
        self.played = play("  sequence: [{log: a}, {check: 1 > 2}, {wait: 1}]\n")
        for node in self.played.root.iterate():
            node.name = HOSTILE
        self.played.tick(2)
        for node in self.played.root.iterate():
            node.feedback_message = HOSTILE
        about = dict.fromkeys(("name", "world", "robot", "seed"), HOSTILE)
        self.session = PlayedSession(self.played.executive, now_ns=1, **about)
        self.session.world = HOSTILE

    def plain(self) -> str:
        stream = io.StringIO()
        view = PlainView(stream)
        view.open(self.session)
        lines = PlainLines(stream, self.played.executive, lambda: 0, lambda: 0)
        for index in range(len(self.played.executive.nodes)):
            lines.on_change(NodeChanged(1, index, Status.FAILURE, HOSTILE))
        self.session.say(view, HOSTILE)
        return stream.getvalue()

    def live(self) -> str:
        stream = io.StringIO()
        options = {"width": 4000, "height": 50, "force_terminal": True, "_environ": {}}
        console = EscapingConsole(stream, **options)
        view = LiveView(console)
        view.open(self.session)
        self.session.say(view, HOSTILE)
        view.refresh()
        view.close()
        console.print(LiveTree(console, self.played.executive, lambda: HOSTILE).render())
        console.print(coloured(HOSTILE))
        return stream.getvalue()


@pytest.mark.parametrize("view", ["plain", "live"])
def test_a_mission_that_runs(play, view):
    """Its title, its nodes, what they and others say."""
    shown = getattr(Runs(play), view)()
    assert shown.count(MARK) >= 4
    assert leaks(shown, is_coloured=view == "live") == []


def test_what_a_mission_came_to():
    """The report's text, with the failed path, and the table of leaves."""
    report = filled(Report)
    lines = [report.as_text(), *leaf_table([filled(LeafSummary)] * 2, 500, SIGNS)]
    assert filled(FailurePath).message == HOSTILE
    assert leaks("\n".join(lines)) == []


# ---- pages and pictures ----------------------------------------------------------------------


def hostile_run() -> RecordedRun:
    """A recorded run whose every text is hostile."""
    run = filled(RecordedRun)
    grid = replace(run.grid, cells=np.zeros((1, 1), np.int8))
    scans = tuple(replace(scan, points=np.zeros((1, 2))) for scan in run.scans)
    # Of closed lists.
    goals = tuple(
        replace(goal, result_status="aborted", served_status="aborted") for goal in run.goals
    )
    spans = tuple(tuple(replace(span, status="failure") for span in each) for each in run.spans)
    return replace(run, grid=grid, scans=scans, goals=goals, spans=spans)


def hostile_page() -> str:
    """The page of it: its markup, and every text of its data, a line each."""
    mission = watched()[0]
    data = {"details": details(hostile_run(), mission)}
    page = page_of([RobotRun(HOSTILE, mission, data)])
    files = data["details"].pop("files")
    lines = [text.replace("\n", " ") for text in texts_of(files)]  # a file has line feeds
    return "\n".join([page.replace("\n", " "), *lines, *texts_of(data)])


def texts_of(value: Any) -> Iterator[str]:
    """All texts in a value that is ready for JSON."""
    match value:
        case str():
            yield value
        case dict():
            for key, each in value.items():
                yield from (key, *texts_of(each))
        case list() | tuple():
            for each in value:
                yield from texts_of(each)


def test_the_page_of_a_run():
    """Names, reasons, logs, goals, files, facts, versions: no element, and escaped in its data."""
    shown = hostile_page()
    assert shown.count(MARK) > 20
    assert markup_leaks(shown[: shown.index("</html>")]) == []
    assert leaks(shown) == []


def test_the_page_of_coverage():
    """Files, lines, nodes, outcomes and branches."""
    marks = {"reached": 1, f"outcome {HOSTILE}": 0, f"branch {HOSTILE}": 0}
    place = CoveragePlace(HOSTILE, "0", HOSTILE, HOSTILE, 1, 1, marks)
    covered = CoveredFile(HOSTILE, {HOSTILE}, (HOSTILE,), {place.key: place})
    shown = as_html(CoverageTally({HOSTILE: covered}))
    assert MARK in shown
    assert markup_leaks(shown) == []


# ---- traces ----------------------------------------------------------------------------------


def traces(folder: Any) -> tuple[str, str]:
    """Two traces with every event that there is, and one that is not known; all texts hostile."""
    fields = (
        "mission world robot node message action owner reason status text what state number note"
    )
    texts = dict.fromkeys(fields.split(), HOSTILE)
    figures = {"seed": 1, "goal": HOSTILE, "jump": 1.0, "with": {HOSTILE: HOSTILE}, "x": 0}
    kinds = ("start", "status", "goal sent", "mission", "log", "fault", "clock", "resumed")
    events = [{"t": 1, "event": kind, **texts, **figures} for kind in kinds]
    events += [{**events[1], "status": "FAILURE"}, {**events[2], "status": None}]
    events += [{"t": 2, "event": HOSTILE, HOSTILE: HOSTILE}]
    paths = []
    for name in ("a", "b"):
        path = folder / name
        lines = [{"trace_version": VERSION}, *events]
        path.write_text("".join(f"{json.dumps(line)}\n" for line in lines), encoding="utf-8")
        paths.append(str(path))
        events[0] = {**events[0], "mission": "other" + HOSTILE}
        events[4] = {**events[4], "text": "other" + HOSTILE}
    return paths[0], paths[1]


@pytest.mark.parametrize("command", ["replay", "diff", "diff --json"])
def test_traces(command, tmp_path, capsys):
    """Told as lines, and compared."""
    first, second = traces(tmp_path)
    words = command.split()
    main([*words, first] if command == "replay" else [*words, first, second])
    shown = capsys.readouterr()
    assert shown.out.count(MARK) > 4
    assert leaks(shown.out + shown.err) == []


# ---- each of them could leak -----------------------------------------------------------------


VIEWS: dict[str, Callable[[], str]] = {
    "lines": lambda: "\n".join(whole_tree(watched()[0], SIGNS, None)),
    "screen": screens,
    "report": lambda: filled(Report).as_text(),
    "page": hostile_page,
}


@pytest.mark.parametrize("name", VIEWS)
def test_views_can_leak(name, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(VIEWS[name]())


@pytest.mark.parametrize("view", ["plain", "live"])
def test_a_running_mission_can_leak(play, view, monkeypatch):
    """Where nothing is escaped, it is noticed."""
    escape_nothing(monkeypatch)
    assert leaks(getattr(Runs(play), view)(), is_coloured=True)


def test_a_page_can_have_elements_that_it_should_not_have():
    """The parser of the test finds those of the attack."""
    assert markup_leaks(f"<p>{MARKUP}</p>")
    assert markup_leaks('<p title="" onevil="1">')
    assert markup_leaks("<p>plain</p>") == []
