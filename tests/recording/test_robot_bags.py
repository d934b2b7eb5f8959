"""Requirements over recordings of robots that know nothing of missions."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from bt_mission.language.requirements.formula import Formula, Requirement
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import Channel, RecordedFile, RecordingError
from bt_mission.recording.verification import RecordedRequirements
from tests.support.recordings import recording
from tests.support.robot_bag import RobotBag, verify


@pytest.fixture
def bag(tmp_path: Path) -> RobotBag:
    """What `ros2 bag record` has kept of a robot that drives for ten seconds, ever faster."""
    bag = RobotBag(tmp_path / "bag.mcap")
    for step in range(201):
        bag.odometry(0.05 * step, x=0.01 * step, speed=0.001 * step)
    for step in range(41):
        bag.scan(0.25 * step, [2.0, 3.0 - 0.05 * step, math.inf])
    return bag


def test_a_recording_of_another_robot(bag: RobotBag) -> None:
    """Its topics tell signals; of what only a simulation or a mission knows it is said so."""
    result = verify(
        bag.close(),
        "always speed < 0.15",
        "always scan_clearance > 0.5",
        "always age('scan') < 0.3",
        "always distance <= 2",
        "always topic('odom', 'twist.twist.linear.x') < 0.3",
        "always clearance > 0.1",
        "always running('drive')",
        "always battery > 20",
        "always topic('odom', 'nothing') < 1",
    )
    speed, room, age, distance, field, clearance, node, battery, nothing = result.results
    assert (speed.verdict, speed.margin, speed.violated_at, speed.at) == (
        *("violated", -0.05, 7.5, 10.0),
    )
    assert (room.verdict, room.margin, room.at) == ("holds", 0.5, 10.0)
    assert (age.verdict, age.margin) == ("holds", 0.1)
    assert (distance.verdict, field.verdict) == ("holds", "holds")
    assert distance.margin == pytest.approx(0.0, abs=1e-9)
    unknown = (clearance, node, battery, nothing)
    assert {judged.verdict for judged in unknown} == {"unknown"}
    assert [judged.why for judged in unknown] == [
        "clearance: only a simulation provides it",
        "running('drive'): the recording contains no mission",
        "battery: the recording has no topic /battery_state",
        "its signals never had a value",
    ]
    assert (speed.sources, distance.sources) == (("speed by odometry",), ("distance by odometry",))


def test_a_robot_in_a_namespace(tmp_path: Path) -> None:
    """Its topics are found where they are said to be; nothing is guessed."""
    bag = RobotBag(tmp_path / "bag.mcap", "/tb3_1")
    bag.odometry(0.0, x=0.0, speed=0.1)
    bag.odometry(1.0, x=0.0, speed=0.3)
    formula = Requirement("slow", "", Formula("always speed < 0.25").root)
    (result,) = RecordedRequirements(bag.close()).verify((formula,)).results
    assert result.why == "speed: the recording has no topic /odom"
    recorded = RecordedRequirements(tmp_path / "bag.mcap", "tb3_1")
    assert recorded.verify((formula,)).results[0].margin == -0.05


def test_a_message_that_cannot_be_read_decides_nothing(bag: RobotBag) -> None:
    """Not even where others of its topic can: it might have been the one."""
    bag.raw(10.5, "/odom", b"\0\1\0\0too short")
    result = verify(bag.close(), "always speed < 0.15", "always scan_clearance > 0.1")
    assert [judged.verdict for judged in result.results] == ["unknown", "holds"]
    assert result.results[0].why.startswith("speed: a message cannot be read: ")


def test_clocks_that_do_not_agree_are_told(bag: RobotBag) -> None:
    """Years between two messages are evaluated for nobody."""
    bag.odometry(1e9, x=0.0, speed=0.0)
    with pytest.raises(RecordingError, match="its messages span 11,574 days; were they recorded"):
        verify(bag.close(), "always speed < 1")


def test_a_recording_without_a_message(tmp_path: Path) -> None:
    """There is nothing to evaluate."""
    with pytest.raises(RecordingError, match="contains no messages"):
        RecordedRequirements(RobotBag(tmp_path / "bag.mcap").close())


def test_a_message_of_ours_that_cannot_be_read_makes_all_unknown(tmp_path: Path) -> None:
    """Also where messages are not in the order of time, as of files that were joined."""
    copy = McapFile(tmp_path / "joined.mcap", "another")
    numbers: dict[Channel, int] = {}
    messages = [*RecordedFile(recording()).messages()]
    for channel, time_ns, data in reversed(messages):
        if channel.topic.endswith("/signals"):
            continue
        if channel not in numbers:
            numbers[channel] = copy.channel(
                channel.topic, channel.type_name, channel.definition, {}
            )
        is_bad = channel.topic.endswith("/trace") and time_ns > 3_000_000_000
        copy.write(time_ns, [(numbers[channel], b"\0\1\0\0" if is_bad else data)])
    copy.close()
    (result,) = verify(tmp_path / "joined.mcap", "always running('drive')").results
    assert result.verdict == "unknown"
    assert result.why.startswith("the messages of the mission cannot be read: ")
