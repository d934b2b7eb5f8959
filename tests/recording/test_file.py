"""The file itself, without ROS."""

from __future__ import annotations

import errno
import io
from pathlib import Path

import pytest
from mcap.reader import make_reader

from bt_mission.core.errors import BtMissionError
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import RecordedFile

S = 1_000_000_000


class FullDisk(io.BytesIO):
    """Takes so many bytes and no more."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room
        self.was_closed = False

    def write(self, data: bytes) -> int:  # type: ignore[override]  # all that is written here
        if self.tell() + len(data) > self.room:
            raise OSError(errno.ENOSPC, "No space left on device")
        return super().write(data)

    def close(self) -> None:
        self.was_closed = True


def written(path: Path, seconds: int) -> McapFile:
    """A file with ten messages a second."""
    file = McapFile(path, "test")
    channel = file.channel("/t", "std_msgs/msg/String", "string data\n", {})
    for number in range(10 * seconds):
        file.write(S + number * S // 10, [(channel, f"{number}".encode())])
    return file


def test_each_message_is_found_with_its_time(tmp_path: Path) -> None:
    """By the library's own reader, which checks the sums."""
    written(tmp_path / "a.mcap", 3).close()
    with (tmp_path / "a.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        messages = list(reader.iter_messages())
    assert [int(message.data) for _, _, message in messages] == list(range(30))
    assert {message.log_time for _, _, message in messages} == {
        S + number * S // 10 for number in range(30)
    }
    schema, channel, _ = messages[0]
    assert schema is not None
    assert (schema.name, schema.encoding) == ("std_msgs/msg/String", "ros2msg")
    assert (channel.topic, channel.message_encoding) == ("/t", "cdr")


def test_what_is_a_second_old_is_on_the_disk_while_the_file_is_open(tmp_path: Path) -> None:
    """So a process that is killed leaves everything but its last second."""
    file = written(tmp_path / "a.mcap", 5)
    times = [time_ns for _, time_ns, _ in RecordedFile(tmp_path / "a.mcap").messages()]
    assert times[0] == S
    assert S + 49 * S // 10 - times[-1] <= S
    file.close()


def test_a_full_disk_ends_the_recording_and_nothing_else() -> None:
    """What came before is kept, and the time of the first loss is known."""
    disk = FullDisk(1500)
    file = McapFile(Path("a.mcap"), "test", disk)
    channel = file.channel("/t", "std_msgs/msg/String", "string data\n", {})
    for number in range(100):
        file.write(S + number * S // 10, [(channel, bytes(100))])
    assert file.fault == "No space left on device"
    assert file.kept_ns is not None
    assert S <= file.kept_ns < 11 * S
    file.attach("a", "text/plain", b"", 0)
    file.note("a", {})
    file.flush()
    file.close()
    assert disk.was_closed


@pytest.mark.parametrize("room", [0, 10, 700])
def test_a_disk_may_be_full_at_any_time(room: int) -> None:
    """From the first byte on."""
    file = McapFile(Path("a.mcap"), "test", FullDisk(room))
    channel = file.channel("/t", "std_msgs/msg/String", "string data\n" * 20, {})
    file.note("a", {"a": "b" * 100})
    file.attach("a", "text/plain", bytes(1000), 0)
    file.write(S, [(channel, bytes(100))])
    file.close()
    assert file.fault == "No space left on device"


def test_a_time_that_goes_back_does_not_stop_the_flushing(tmp_path: Path) -> None:
    """A simulator that starts anew sets the clock back."""
    file = written(tmp_path / "a.mcap", 5)
    before = file.bytes
    channel = file.channel("/u", "std_msgs/msg/String", "string data\n", {})
    file.write(S, [(channel, b"")])
    assert file.bytes > before
    file.close()


def test_a_file_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    """Before anything is run."""
    with pytest.raises(BtMissionError, match=r"cannot write .*a\.mcap: No such file"):
        McapFile(tmp_path / "no" / "a.mcap", "test")
