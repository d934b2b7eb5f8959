"""Recordings that are damaged, or say other things than ours: read as far as they go, and told."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from mcap.opcode import Opcode

from bt_mission.cli import main
from bt_mission.recording.contents import string_message
from bt_mission.recording.reader import read_run
from bt_mission.recording.reading import RecordedFile
from bt_mission.recording.replay.timeline import read_timeline
from tests.support.fuzz.recorded import Recording, load, records, written
from tests.support.project import ROOT
from tests.support.report_pages import data_of

SQUARE = ROOT / "tests/fuzz/corpus/recordings/square.mcap"
"""A run of the shipped mission, with a few messages of each topic."""

Edit = Callable[[Recording], None]


@pytest.fixture
def edited(tmp_path: Path) -> Callable[[Edit], Path]:
    """The recording, changed, and written as ours are."""

    def edit(change: Edit) -> Path:
        recording = load(SQUARE)
        change(recording)
        path = tmp_path / "run.mcap"
        path.write_bytes(written(recording))
        return path

    return edit


def damage(contents: bytes, opcode: Opcode, change: Callable[[bytearray, int, int], None]) -> bytes:
    """Return a file with its last record of a kind changed."""
    damaged = bytearray(contents)
    at, length = [record for record in records(contents) if contents[record[0]] == opcode][-1]
    change(damaged, at, length)
    return bytes(damaged)


def why_cut(path: Path, contents: bytes) -> str:
    """Return what is said of a file."""
    path.write_bytes(contents)
    file = RecordedFile(path)
    for _ in file.messages():
        pass
    assert read_timeline(path).why_cut == file.why_cut
    return file.why_cut


def clear_sum(data: bytearray, at: int, _: int) -> None:
    """Take out the sum over the data, as in files of earlier versions."""
    data[at + 9 : at + 13] = bytes(4)


def unknown(data: bytearray, at: int, _: int) -> None:
    """Make a record one of a kind that nobody knows, which readers pass over."""
    data[at] |= 0x80


def remove(data: bytearray, at: int, length: int) -> None:
    """Take a record out."""
    del data[at : at + 9 + length]


def cut_end(data: bytearray, at: int, length: int) -> None:
    """Take the last byte out, which is behind all records."""
    del data[-1]


def flip(data: bytearray, at: int, length: int) -> None:
    """Change a letter at the end of a record."""
    data[at + 8 + length] ^= 1


SUM = "the file is damaged: its data has another checksum than when written"


@pytest.mark.parametrize(
    ("opcode", "change", "why"),
    [
        (Opcode.METADATA, flip, SUM),
        (Opcode.CHUNK, unknown, SUM),
        (Opcode.CHUNK, remove, SUM),
        (Opcode.ATTACHMENT, flip, SUM),
        (Opcode.DATA_END, remove, "the marker at the end of the data is missing"),
        (Opcode.FOOTER, cut_end, "the file is incomplete, or the recorder was killed"),
    ],
)
def test_any_damage_to_what_we_have_recorded_is_told(edited, tmp_path, opcode, change, why):
    """The sum over all data is in the file: also a letter of a note, or a lost chunk, is missed."""
    contents = edited(lambda _: None).read_bytes()
    path = tmp_path / "run.mcap"
    assert why_cut(path, contents) == ""
    assert why_cut(path, damage(contents, opcode, change)) == why


def test_a_lost_chunk_of_a_file_without_a_sum_is_told(edited, tmp_path):
    """By the counts in its summary: as earlier versions and rosbag2 write it."""
    whole = edited(lambda _: None).read_bytes()
    contents = damage(whole, Opcode.DATA_END, clear_sum)
    path = tmp_path / "run.mcap"
    assert why_cut(path, contents) == ""
    wanted = len(load(SQUARE).messages)
    result = why_cut(path, damage(contents, Opcode.CHUNK, unknown))
    assert result.startswith("the file is damaged: it has ")
    assert result.endswith(f" messages where {wanted:,} were recorded")


def test_facts_that_are_none_are_left_out_and_named(edited, capsys, tmp_path):
    """Each by itself: the run is shown all the same."""

    def spoil(recording: Recording) -> None:
        recording.notes["bt_mission"] |= {
            "start_ns": "9" * 5_000,
            "robot_hull": f"[1, 2, {'9' * 400}]",
            "versions": "[",
            "inputs": "7",
        }
        recording.notes["bt_mission_summary"]["wall_s"] = '"x"'

    path = edited(spoil)
    run = read_run(path)
    assert (run.hull, run.versions, run.inputs) == (None, {}, {})
    assert "wall_s" not in run.summary
    assert main(["replay", str(path), "--once"]) == 0
    names = ("wall_s", "start_ns", "robot_hull", "versions", "inputs")
    lacks = "; ".join(f"its '{name}' (cannot be read)" for name in names)
    assert run.missing == lacks
    assert capsys.readouterr().out.endswith(f"{path}: lacks {lacks}\n")
    page = tmp_path / "page.html"
    assert main(["report", str(path), "-o", str(page)]) == 0
    (data,) = data_of(page).values()
    assert data["details"]["lacks"] == lacks


def test_a_definition_that_contradicts_ours_is_not_believed(edited):
    """A text in the place of a number would end in a fault of its user, far from here."""

    def retype(recording: Recording) -> None:
        for topic in recording.topics:
            if topic.type_name == "nav_msgs/msg/Odometry":
                topic.definition = topic.definition.replace("float64 x", "string x")

    run = read_run(edited(retype))
    assert len(run.track) == 0
    assert (
        "messages of type nav_msgs/msg/Odometry (cannot be read: its definition of "
        "geometry_msgs/Point has a text as 'x', expected a float)"
    ) in run.missing


def test_a_topic_of_another_type_is_not_taken_for_the_robots(edited):
    """Whatever its fields are called."""

    def retype(recording: Recording) -> None:
        for topic in recording.topics:
            if topic.name == "/scan":
                topic.type_name = "my_msgs/msg/Scan"

    path = edited(retype)
    expected = "/scan is expected to have the type sensor_msgs/msg/LaserScan"
    assert expected in read_run(path).missing
    assert expected in read_timeline(path).missing


def test_a_message_of_a_time_that_cannot_be_is_left_out(edited):
    """Times of ROS end in the year 2262."""

    def misdate(recording: Recording) -> None:
        topic, _, data = recording.messages[-1]
        recording.messages[-1] = topic, 2**64 - 1, data

    path = edited(misdate)
    whole = read_timeline(SQUARE)
    timeline = read_timeline(path)
    assert timeline.end_ns <= whole.end_ns
    assert f"its time is {2**64 - 1} ns" in timeline.missing


def test_what_a_trace_says_of_a_goal_need_not_be_text(edited, tmp_path):
    """It is shown as it is."""

    def spoil(recording: Recording) -> None:
        for index, (topic, time_ns, data) in enumerate(recording.messages):
            if b'"event": "goal sent"' in data:
                event = json.loads(data[8:].rstrip(b"\0"))
                line = json.dumps({**event, "owner": ["a", 1]})
                recording.messages[index] = topic, time_ns, string_message(line)

    path = edited(spoil)
    assert {goal.owner for goal in read_run(path).goals if goal.owner} == {"['a', 1]"}
    page = tmp_path / "page.html"
    assert main(["report", str(path), "-o", str(page)]) == 0
    (data,) = data_of(page).values()
    assert "['a', 1]" in {goal["owner"] for goal in data["details"]["goals"]}


def test_a_trace_whose_time_cannot_be_is_refused_with_the_line(tmp_path, capsys):
    """Also where Python could not even print it."""
    path = tmp_path / "trace.jsonl"
    path.write_text(
        '{"trace_version": 3}\n{"t": 0, "event": "x"}\n{"t": 1' + "0" * 400 + ', "event": "x"}\n'
    )
    assert main(["replay", str(path)]) == 2
    assert (
        capsys.readouterr().err
        == f"{path}:3: not an event: expected 't' in ns and 'event' [BT-1002]\n"
    )
