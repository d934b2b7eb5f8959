"""Recordings as data: read, made smaller, and written again, sound or not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from random import Random

from mcap.writer import CompressionType, Writer

from bt_mission.recording.file import ENCODING, PROFILE, SCHEMA_ENCODING, McapFile
from bt_mission.recording.reading import Channel, RecordedFile

MOST_OF_A_TOPIC = 4
"""Messages of each topic that a small recording keeps; those of the mission are all kept."""

MISSION = ("bt_mission_interfaces/msg/", "rcl_interfaces/msg/Log")
TEXT = 6_000
"""Bytes of a message or an attachment that a small recording keeps at most."""


@dataclass
class Topic:
    """A channel and its schema."""

    name: str
    type_name: str
    definition: str
    encoding: str = ENCODING


@dataclass
class Recording:
    """What stands in a file: messages are the index of a topic, a time (ns), and data."""

    topics: list[Topic]
    messages: list[tuple[int, int, bytes]]
    notes: dict[str, dict[str, str]] = field(default_factory=dict)
    attached: list[tuple[str, str, int, bytes]] = field(default_factory=list)


def load(path: Path) -> Recording:
    """Read a recording."""
    file = RecordedFile(path)
    numbers: dict[Channel, int] = {}
    messages = []
    for channel, time_ns, data in file.messages():
        number = numbers.setdefault(channel, len(numbers))
        messages.append((number, time_ns, data))
    topics = [
        Topic(topic.topic, topic.type_name, topic.definition, topic.encoding) for topic in numbers
    ]
    notes = {name: dict(facts) for name, facts in file.notes.items()}
    attached = [
        (attachment.name, attachment.media_type, attachment.time_ns, attachment.data)
        for attachment in file.attached
    ]
    return Recording(topics, messages, notes, attached)


def small(whole: Recording) -> Recording:
    """Return as much of a recording as shows everything that happens in it."""
    counts: dict[int, int] = {}
    kept = []
    for topic, time_ns, data in whole.messages:
        is_pose = whole.topics[topic].name.endswith("/trace") and b'"event": "pose"' in data
        counts[topic] = counts.get(topic, 0) + 1
        is_ours = whole.topics[topic].type_name.startswith(MISSION)
        most = 8 * MOST_OF_A_TOPIC if is_ours or "/trace" in whole.topics[topic].name else None
        most = MOST_OF_A_TOPIC if most is None else most
        if counts[topic] <= most and not is_pose and len(data) <= TEXT:
            kept.append((topic, time_ns, data))
    attached = [attachment for attachment in whole.attached if len(attachment[3]) <= TEXT]
    return Recording(whole.topics, kept, whole.notes, attached)


def written(recording: Recording) -> bytes:
    """Return a recording as our recorder writes it."""
    stream = BytesIO()
    stream.close = lambda: None  # type: ignore[method-assign]  # what is in it is still wanted
    file = McapFile(Path("fuzz.mcap"), "fuzz", stream)
    for name, facts in list(recording.notes.items())[:1]:
        file.note(name, facts)
    for name, media_type, time_ns, data in recording.attached:
        file.attach(name, media_type, data, time_ns)
    numbers = [
        file.channel(entry.name, entry.type_name, entry.definition, {})
        for entry in recording.topics
    ]
    for topic, time_ns, data in recording.messages:
        file.write(time_ns, [(numbers[topic], data)])
    for name, facts in list(recording.notes.items())[1:]:
        file.note(name, facts)
    file.close()
    return stream.getvalue()


def written_by_others(rng: Random, recording: Recording) -> bytes:
    """Return a recording as another recorder might write it: its order, its compression."""
    stream = BytesIO()
    writer = Writer(
        stream,
        chunk_size=rng.choice((1, 1_000, 1_000_000)),
        compression=rng.choice(tuple(CompressionType)),
        use_chunking=rng.random() < 0.8,
        enable_crcs=rng.random() < 0.5,
        enable_data_crcs=rng.random() < 0.5,
        use_statistics=rng.random() < 0.8,
    )
    writer.start(rng.choice((PROFILE, "", "x")), rng.choice(("libmcap 1.1", "", "é" * 300)))
    channels = [_registered(rng, writer, recorded) for recorded in recording.topics]
    for name, facts in recording.notes.items():
        writer.add_metadata(name, facts)
    for number, (topic, time_ns, data) in enumerate(recording.messages):
        writer.add_message(channels[topic], max(time_ns, 0) % 2**64, data, time_ns % 2**64, number)
    for name, media_type, time_ns, data in recording.attached:
        writer.add_attachment(0, time_ns % 2**64, name, media_type, data)
    writer.finish()
    return stream.getvalue()


def _registered(rng: Random, writer: Writer, topic: Topic) -> int:
    schema = 0
    if rng.random() > 0.01:
        encoding = rng.choice((SCHEMA_ENCODING, SCHEMA_ENCODING, "ros2idl", ""))
        schema = writer.register_schema(topic.type_name, encoding, topic.definition.encode())
    return writer.register_channel(topic.name, topic.encoding, schema)


def records(contents: bytes) -> Iterator[tuple[int, int]]:
    """Yield where each record of a file begins, and how long it is, as far as that can be told."""
    at = 8
    while at + 9 <= len(contents):
        length = int.from_bytes(contents[at + 1 : at + 9], "little")
        yield at, length
        at += 9 + length
