"""Files that were cut, that are damaged, and that are something else."""

from __future__ import annotations

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import CompressionType, Writer

from bt_mission.recording.file import McapFile
from bt_mission.recording.reader import read_run
from bt_mission.recording.reading import RecordedFile, RecordingError

S = 1_000_000_000


@pytest.fixture
def ten_seconds(tmp_path: Path) -> Path:
    """A file with a hundred messages in ten seconds."""
    path = tmp_path / "a.mcap"
    file = McapFile(path, "test")
    file.note("about", {"a": "b"})
    file.attach("m.yaml", "text/plain", b"mission: m\n", S)
    channel = file.channel("/t", "std_msgs/msg/String", "string data\n", {})
    noise = random.Random(1)
    for number in range(100):
        file.write(S + number * S // 10, [(channel, noise.randbytes(200))])
    file.close()
    return path


def read(path: Path) -> tuple[RecordedFile, list[int]]:
    """A file, and the times of its messages."""
    file = RecordedFile(path)
    return file, [time_ns for _, time_ns, _ in file.messages()]


def test_a_whole_file(ten_seconds: Path) -> None:
    """Messages, metadata, attachments, and who wrote it."""
    file, times = read(ten_seconds)
    assert len(times) == 100
    assert (file.why_cut, file.library) == ("", "test")
    assert file.notes == {"about": {"a": "b"}}
    assert [(attached.name, attached.data) for attached in file.attached] == [
        ("m.yaml", b"mission: m\n")
    ]


def test_a_file_cut_anywhere_gives_what_is_before_the_cut(ten_seconds: Path) -> None:
    """At four hundred places: messages in order, all of the chunks that are whole, no traceback."""
    data = ten_seconds.read_bytes()
    _, whole = read(ten_seconds)
    places = random.Random(2).sample(range(1, len(data)), 400)
    most = 0
    for place in sorted(places):
        ten_seconds.write_bytes(data[:place])
        file, times = read(ten_seconds)
        assert times == whole[: len(times)]
        assert len(times) >= most
        most = len(times)
        why_cut = "the file is incomplete, or the recorder was killed"
        assert file.why_cut == why_cut or (file.why_cut, len(times)) == ("", 100)
    assert most == 100


def test_a_damaged_file_gives_what_is_before_the_damage(ten_seconds: Path) -> None:
    """Bytes changed at two hundred places; what is given is right, by the sums of the chunks."""
    data = ten_seconds.read_bytes()
    expected = [(time_ns, message) for _, time_ns, message in RecordedFile(ten_seconds).messages()]
    noise = random.Random(3)
    for place in noise.sample(range(8, len(data)), 200):
        broken = bytearray(data)
        broken[place] ^= noise.randrange(1, 256)
        ten_seconds.write_bytes(broken)
        file = RecordedFile(ten_seconds)
        given = [(time_ns, message) for _, time_ns, message in file.messages()]
        assert given == expected[: len(given)]


@pytest.mark.parametrize(
    ("data", "what"),
    [
        (b"", "the file is empty"),
        (b"not an mcap", "not an MCAP file; create one"),
        (b"SQLite format 3\0", "not an MCAP file"),
        (None, "cannot read it: No such file"),
    ],
)
def test_what_is_no_recording_is_refused(tmp_path: Path, data: bytes | None, what: str) -> None:
    """With its name."""
    path = tmp_path / "a.mcap"
    if data is not None:
        path.write_bytes(data)
    with pytest.raises(RecordingError, match=what) as caught:
        read(path)
    assert str(caught.value).startswith(f"{path}: ")


def test_a_folder_is_refused(tmp_path: Path) -> None:
    """As the system says it."""
    with pytest.raises(RecordingError, match="cannot read it: expected a file, got a folder"):
        read(tmp_path)


@pytest.mark.parametrize("compression", [CompressionType.NONE, CompressionType.ZSTD])
def test_files_of_other_recorders_are_read(tmp_path: Path, compression: CompressionType) -> None:
    """However they are compressed, in chunks or not; a channel may be without a schema."""
    for use_chunking in (True, False):
        path = tmp_path / "b.mcap"
        with path.open("wb") as stream:
            writer = Writer(stream, compression=compression, use_chunking=use_chunking)
            writer.start("ros2", "other")
            channel = writer.register_channel("/x", "json", 0)
            writer.add_message(channel, 5, b"{}", 5)
            writer.finish()
        ((message, time_ns, data),) = RecordedFile(path).messages()
        assert (message.topic, message.encoding, message.type_name) == ("/x", "json", "")
        assert (time_ns, data) == (5, b"{}")


@pytest.mark.thorough
def test_a_run_that_is_cut_anywhere_is_a_run_or_an_error(
    record: Callable[..., Any], tmp_path: Path
) -> None:
    """What can be known of it is, and a person is told the rest."""
    data = record().path.read_bytes()
    whole = read_run(tmp_path / "run.mcap")
    cut = tmp_path / "cut.mcap"
    lengths, early = [], []
    for place in sorted(random.Random(4).sample(range(1, len(data)), 40)):
        cut.write_bytes(data[:place])
        try:
            run = read_run(cut)
        except RecordingError as error:
            early.append(str(error))
            continue
        assert run.tree == whole.tree
        for spans, whole_spans in zip(run.spans, whole.spans, strict=True):
            ended = tuple(span for span in spans if span.status != "running")
            assert ended == whole_spans[: len(ended)]
        lengths.append(len(run.truth))
    for output in early:
        assert output.startswith(f"{cut}: it ends before the mission began: the file is incomplete")
    assert lengths == sorted(lengths)
    assert lengths[-1] > lengths[0] > 0
