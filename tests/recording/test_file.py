"""The file itself, without ROS, read back by the library of MCAP's makers."""

from __future__ import annotations

import errno
import io
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader

from bt_mission.base.errors import BtMissionError
from bt_mission.recording.file import McapFile
from bt_mission.recording.reading import RecordedFile
from tests.support.recorded_runs import summary_of

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


@pytest.fixture
def chunked(tmp_path: Path) -> McapFile:
    """A file with two chunks, an attachment and metadata."""
    file = McapFile(tmp_path / "a.mcap", "test")
    first = file.channel("/one", "std_msgs/msg/String", "string data\n", {"a": "b"})
    file.write(10, [(first, b"x")])
    file.write(30, [(first, b"yy")])
    file.flush()
    file.attach("m.yaml", "text/plain", b"mission: m\n", 35)
    second = file.channel("/two", "std_msgs/msg/String", "string data\n", {})
    file.write(40, [(first, b"z")])
    file.write(20, [(second, b"")])
    file.note("about", {"seed": "7"})
    file.close()
    return file


def test_mcap_reads_it_by_its_index_and_checks_the_sums(chunked: McapFile) -> None:
    """In the order of time, which is not that of the file; or only a part of it."""
    with chunked.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        messages = list(reader.iter_messages())
        late = [m.log_time for _, _, m in reader.iter_messages(topics=["/one"], starting_at=25)]
        attached = [(each.name, each.log_time) for each in reader.iter_attachments()]
        notes = [record.metadata for record in reader.iter_metadata()]
    assert [(channel.topic, m.log_time, m.data) for _, channel, m in messages] == [
        ("/one", 10, b"x"),
        ("/two", 20, b""),
        ("/one", 30, b"yy"),
        ("/one", 40, b"z"),
    ]
    assert (late, attached, notes) == ([30, 40], [("m.yaml", 35)], [{"seed": "7"}])
    schema, channel, _ = messages[0]
    assert schema is not None
    assert (schema.name, schema.encoding) == ("std_msgs/msg/String", "ros2msg")
    assert (channel.message_encoding, channel.metadata) == ("cdr", {"a": "b"})


def test_the_summary_counts_what_is_there(chunked: McapFile) -> None:
    """Messages of each channel, chunks, and the first and last time."""
    counts = summary_of(chunked.path).statistics
    assert counts is not None
    assert (counts.message_count, counts.chunk_count, counts.channel_count) == (4, 2, 2)
    assert counts.channel_message_counts == {1: 3, 2: 1}
    assert (counts.message_start_time, counts.message_end_time) == (10, 40)
    assert chunked.bytes == chunked.path.stat().st_size


def test_it_reads_from_front_to_back(chunked: McapFile) -> None:
    """Each definition comes before what needs it, in the chunk that does."""
    data = chunked.path.read_bytes()
    chunks = StreamReader(io.BytesIO(data), emit_chunks=True).records
    assert sum(isinstance(record, Chunk) for record in chunks) == 2
    records = StreamReader(io.BytesIO(data), validate_crcs=True).records
    times = [record.log_time for record in records if isinstance(record, Message)]
    assert times == [10, 30, 40, 20]


def test_a_file_without_messages_is_a_file(tmp_path: Path) -> None:
    """Its definitions stand in the summary."""
    file = McapFile(tmp_path / "a.mcap", "test")
    file.channel("/one", "a/msg/B", "", {})
    file.close()
    assert [each.topic for each in summary_of(file.path).channels.values()] == ["/one"]


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
    assert file.write_error == "No space left on device"
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
    assert file.write_error == "No space left on device"


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
