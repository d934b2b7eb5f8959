"""MCAP as such, read back by the library of its makers."""

from __future__ import annotations

import io

from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader

from bt_mission.recording.chunks import ChunkWriter


def written() -> tuple[ChunkWriter, io.BytesIO]:
    """A file with two chunks, an attachment and metadata."""
    stream = io.BytesIO()
    writer = ChunkWriter(stream)
    writer.start("ros2", "test")
    schema = writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data\n")
    channel = writer.add_channel("/one", "cdr", schema, {"a": "b"})
    writer.add_messages(10, [(channel, b"x")])
    writer.add_messages(30, [(channel, b"yy")])
    writer.write_chunk()
    writer.write_attachment("m.yaml", "text/plain", b"mission: m\n", 35)
    two = writer.add_channel("/two", "cdr", schema, {})
    writer.add_messages(20, [(two, b"")])
    writer.add_messages(40, [(channel, b"z")])
    writer.write_chunk()
    writer.write_metadata("about", {"seed": "7"})
    writer.finish()
    return writer, stream


def test_the_library_reads_it_by_its_index_and_checks_the_sums() -> None:
    """In the order of time, which is not that of the file; or only a part of it."""
    reader = make_reader(io.BytesIO(written()[1].getvalue()), validate_crcs=True)
    messages = [(c.topic, m.log_time, m.data) for _, c, m in reader.iter_messages()]
    assert messages == [
        ("/one", 10, b"x"),
        ("/two", 20, b""),
        ("/one", 30, b"yy"),
        ("/one", 40, b"z"),
    ]
    late = [m.log_time for _, _, m in reader.iter_messages(topics=["/one"], starting_at=25)]
    assert late == [30, 40]
    assert [(attachment.name, attachment.log_time) for attachment in reader.iter_attachments()] == [
        ("m.yaml", 35)
    ]
    assert [record.metadata for record in reader.iter_metadata()] == [{"seed": "7"}]


def test_the_summary_counts_what_is_there() -> None:
    """Messages of each channel, chunks, and the first and last time."""
    writer, stream = written()
    summary = make_reader(io.BytesIO(stream.getvalue())).get_summary()
    assert summary is not None
    counts = summary.statistics
    assert counts is not None
    assert (counts.message_count, counts.chunk_count, counts.channel_count) == (4, 2, 2)
    assert counts.channel_message_counts == {1: 3, 2: 1}
    assert (counts.message_start_time, counts.message_end_time) == (10, 40)
    assert writer.bytes_written == len(stream.getvalue())


def test_it_reads_from_front_to_back() -> None:
    """Each definition comes before what needs it, in the chunk that does."""
    records = list(StreamReader(io.BytesIO(written()[1].getvalue()), emit_chunks=True).records)
    assert sum(isinstance(record, Chunk) for record in records) == 2
    stream = io.BytesIO(written()[1].getvalue())
    times = [
        r.log_time
        for r in StreamReader(stream, validate_crcs=True).records
        if isinstance(r, Message)
    ]
    assert times == [10, 30, 20, 40]


def test_a_file_without_messages_is_a_file() -> None:
    """Its definitions stand in the summary."""
    stream = io.BytesIO()
    writer = ChunkWriter(stream)
    writer.start("ros2", "test")
    writer.add_channel("/one", "cdr", writer.add_schema("a/msg/B", "ros2msg", b""), {})
    writer.finish()
    summary = make_reader(io.BytesIO(stream.getvalue())).get_summary()
    assert summary is not None
    assert [channel.topic for channel in summary.channels.values()] == ["/one"]
