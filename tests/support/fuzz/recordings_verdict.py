"""Whether a recording is read as what it is: whole, cut, damaged, or none.

Every command that reads it ends in output or in one of our errors. Where the file itself, looked
at with the sums and counts that are in it, lacks something, the output has to say so.
"""

from __future__ import annotations

import io
import zlib
from argparse import Namespace
from collections.abc import Callable, Mapping
from contextlib import redirect_stdout
from pathlib import Path

from mcap import records
from mcap.stream_reader import StreamReader

from bt_mission.base.errors import BtMissionError
from bt_mission.commands import diff, replay, report, verify
from bt_mission.executive.events.watched_mission import targets
from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.terminal import panels
from bt_mission.views.terminal.map_chart import MapChart
from bt_mission.views.terminal.marks import marks_for
from tests.support.fuzz.finding import Finding, Verdict

LARGEST_OUTPUT = 10_000_000
NO_OPTIONS = Namespace(options=())
"""In the place of the parser, whose options have rules that are tested elsewhere."""
PAGE = Path("page.html")
SAID = ("ends here", "not whole", "cut here", "incomplete", "the recording is cut")
REQUIREMENTS = """\
requirements:
  keeps off: always clearance > 0.1
  is slow: always speed < 1 and distance < 100 and open_goals < 3
  hears: always age("scan") < 3 and scan_clearance > 0.1 and battery > 3
  is calm: 'whenever topic("odom", "twist.twist.linear.x") > 0.1: odometry.x < 4 within 2 s'
"""
MARK = b"\x89MCAP0\r\n"


class TooMuchError(Exception):
    """More output than anybody could want of a small file."""


class _Output(io.StringIO):
    def write(self, text: str) -> int:
        text.encode(errors="replace")
        if self.tell() > LARGEST_OUTPUT:
            raise TooMuchError
        return super().write(text)


def judge(path: Path) -> Verdict:
    """Read a recording or a trace by the commands that do."""
    contents = path.read_bytes()
    choice = zlib.crc32(contents)
    at_s = (0.0, 0.5, 5.0, 1e9)[choice // 4 % 4]
    replayed = {
        "file": path,
        "speed": None,
        "at": at_s,
        "plain": True,
        "once": choice % 4 == 1,
        "poses": choice % 4 == 2,
        **dict.fromkeys(("web", "port", "open", "read_only", "host", "robot")),
        "parser": NO_OPTIONS,
    }
    commands = _commands(path, contents, choice, replayed)
    text, ended = "", []
    for command in commands:
        output = _Output()
        try:
            with redirect_stdout(output):
                ended.append(command())
        except BtMissionError as error:
            text += _clear(error, path)
            ended.append(2)
        text += output.getvalue()
    if 2 not in ended and choice % 4 == 0 and path.suffix == ".mcap":
        _draw(path)
    if 2 in ended:
        return Verdict(accepted=False)
    if path.suffix == ".mcap" and choice % 4 == 3:
        text = PAGE.read_text(encoding="utf-8")
    lack = _lacks(contents) if path.suffix == ".mcap" else _torn(contents)
    if lack and not any(words in text for words in SAID):
        return Verdict(True, finding=Finding(f"taken for whole: {lack.kind}", lack.text))
    return Verdict(accepted=True)


def _commands(
    path: Path, contents: bytes, choice: int, replayed: Mapping[str, object]
) -> list[Callable[[], int]]:
    """Choose what reads a file."""
    commands: list[Callable[[], int]] = [lambda: replay.replay(Namespace(**replayed))]
    if path.suffix == ".jsonl":
        others = Path("other.jsonl")
        if not others.exists():
            others.write_bytes(contents)
        compared = Namespace(first=path, second=others, json=choice % 2 == 0)
        commands = [commands[0], lambda: diff.compare(compared)]
    elif choice % 4 == 3:
        page = Namespace(file=path, output=PAGE, force=True, robot=None, parser=NO_OPTIONS)
        commands = [lambda: report.report(page)]
    elif choice % 8 == 2:
        commands = [lambda: _verify(path)]
    return commands


def _verify(path: Path) -> int:
    """Evaluate requirements over a recording."""
    required = path.with_name("required.yaml")
    required.write_text(REQUIREMENTS)
    options = {"require": [required], "mission": None, "namespace": None, "json": False}
    return verify.verify(Namespace(file=path, robot=None, parser=NO_OPTIONS, **options))


def _draw(path: Path) -> None:
    """Draw what the full screen shows of a recording, at a few times."""
    timeline = read_timeline(path)
    marks = marks_for("utf-8")
    for share in (1.0, 0.0, 0.4, 0.9):
        duration_s = (timeline.end_ns - timeline.start_ns) / 1e9
        mission = Player(timeline, at_s=share * duration_s).mission
        places = targets(mission)
        drawn = [
            *MapChart(marks).draw(mission.robot, places, 60, 20),
            *panels.goal_rows(mission, marks),
            *panels.variable_rows(mission, marks),
            *panels.log_rows(mission.log, timeline.start_ns, marks),
            *panels.node_rows(mission, 0, 60, marks),
        ]
        assert len(drawn) < LARGEST_OUTPUT
        panels.map_title(mission.robot)
        panels.goals_title(mission)


def _torn(contents: bytes) -> Finding | None:
    return None if contents.endswith(b"\n") else Finding("a torn trace", "")


def _clear(error: BtMissionError, path: Path) -> str:
    """Return the words of an error, which begin with the place."""
    text = str(error)
    if not text.startswith((str(path), "--at", "other.jsonl")) or len(text) > LARGEST_OUTPUT:
        raise AssertionError(f"an error without its place: {text[:500]}")
    return text


def _lacks(contents: bytes) -> Finding | None:
    """Return what a file lacks, by its own sums and counts; None where it is whole."""
    counts = {records.Message: 0, records.Attachment: 0, records.Metadata: 0}
    seen_end, statistics = False, None
    stream = StreamReader(io.BytesIO(contents), validate_crcs=True, record_size_limit=1 << 24)
    try:
        for record in stream.records:
            if isinstance(record, records.DataEnd):
                seen_end = True
            elif isinstance(record, records.Statistics):
                statistics = record
            elif type(record) in counts and not seen_end:
                counts[type(record)] += 1
    except Exception as error:  # noqa: BLE001 - whatever a damaged chunk does to a decompressor
        return Finding("damaged", f"{type(error).__name__}: {error}")
    if not seen_end:
        return Finding("no end of the data", "")
    if statistics is not None:
        wanted = (statistics.message_count, statistics.attachment_count, statistics.metadata_count)
        if wanted != tuple(counts.values()):
            return Finding("records are missing", f"{wanted} told, {tuple(counts.values())} there")
    return None
