"""MCAP files, read from their beginning as far as possible.

Readers that look for the summary at the end of a file find none in a cut one. This one reads record
after record until there is no more, and reports the cut.
"""

from __future__ import annotations

import gzip
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from struct import Struct
from typing import BinaryIO, cast

import zstandard
from mcap import records
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.stream_reader import CRCValidationError, StreamReader, get_chunk_data_stream

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.files import open_file
from bt_mission.cdr.decoder import DecodedMessage, DecodingError
from bt_mission.recording.expected_types import checked_decoder
from bt_mission.recording.facts import LARGEST_NS, RunFacts, robot_of

UNREADABLE = (
    *(DecodingError, AttributeError, TypeError, LookupError),
    *(ValueError, ArithmeticError, RecursionError),
)
"""Exceptions of a message whose definition does not fit, that lacks fields, or has impossible
values.
"""

LARGEST_RECORD = 1 << 30
SHOWN_TOPICS = 5
MAGIC = b"\x89MCAP0\r\n"
"""The first bytes of a file."""


_HEAD, _MESSAGE_HEAD = Struct("<BQ"), Struct("<HIQQ")
"""The heads of a record and of a message."""


class RecordingError(BtMissionError):
    """A file that is not a recording, or cannot be read at all."""

    code = "BT-1001"


@dataclass(frozen=True)
class Channel:
    """A topic of a file."""

    topic: str
    type_name: str
    definition: str
    encoding: str

    def expect(self, type_name: str) -> None:
        """Raise DecodingError where the topic has another type than is known here."""
        if self.type_name != type_name:
            raise DecodingError(f"{self.topic} is expected to have the type {type_name}")

    @cached_property
    def decode(self) -> Callable[[bytes], DecodedMessage]:
        """Decodes a message of it. Raises DecodingError."""
        try:
            return checked_decoder(self.type_name, self.definition).decode
        except DecodingError as error:
            return _refusing(str(error))


@dataclass(frozen=True)
class RecordingAttachment:
    """A file within the file."""

    name: str
    media_type: str
    time_ns: int
    data: bytes = field(repr=False)


def _records_in(chunk: records.Chunk) -> list[records.McapRecord]:
    """Return the records of a chunk.

    `mcap.stream_reader.breakup_chunk` calls a function for each field of each message: that is half
    of the time in which a replay opens.
    """
    stream, length = get_chunk_data_stream(chunk, validate_crc=True)
    data = stream.read(length)
    inside: list[records.McapRecord] = []
    at = 0
    while at < length:
        opcode, size = _HEAD.unpack_from(data, at)
        begin, at = at + _HEAD.size, at + _HEAD.size + size
        if at > length:
            raise EndOfFile
        if opcode == Opcode.MESSAGE:
            channel, sequence, time_ns, sent_ns = _MESSAGE_HEAD.unpack_from(data, begin)
            body = data[begin + _MESSAGE_HEAD.size : at]
            inside.append(records.Message(channel, time_ns, body, sent_ns, sequence))
        elif opcode == Opcode.CHANNEL:
            inside.append(records.Channel.read(ReadDataStream(BytesIO(data[begin:at]))))
        elif opcode == Opcode.SCHEMA:
            inside.append(records.Schema.read(ReadDataStream(BytesIO(data[begin:at]))))
    return inside


def _refusing(why: str) -> Callable[[bytes], DecodedMessage]:
    def decode(_: bytes) -> DecodedMessage:
        raise DecodingError(why)

    return decode


Message = tuple[Channel, int, bytes]
"""A channel, a time (ns) and serialized data."""


GZIP, ZSTANDARD = b"\x1f\x8b", b"\x28\xb5\x2f\xfd"
"""The first bytes of compressed files."""

UNPACKING = (EOFError, zlib.error, gzip.BadGzipFile, zstandard.ZstdError)


def open_recording(path: Path) -> BinaryIO:
    """Open a recording, also one that is compressed as a whole (gzip, Zstandard).

    Raises:
        OSError: It cannot be opened.
    """
    with open_file(path) as stream:
        beginning = stream.read(len(ZSTANDARD))
    if beginning.startswith(GZIP):
        return cast("BinaryIO", gzip.open(path, "rb"))
    if beginning == ZSTANDARD:
        return cast("BinaryIO", zstandard.open(path, "rb"))
    return open_file(path)


def is_recording(path: Path) -> bool:
    """Return whether a file is a recording, and not a trace.

    Raises:
        RecordingError: The file cannot be read, or begins as neither.
    """
    try:
        with open_recording(path) as stream:
            beginning = stream.read(len(MAGIC))
    except UNPACKING as error:
        raise RecordingError(f"{path}: cannot unpack it: {error}") from error
    except OSError as error:
        raise RecordingError(f"{path}: cannot read it: {error.strerror}") from error
    if not beginning or not (MAGIC.startswith(beginning) or beginning.startswith(b"{")):
        problem = "is neither" if beginning else "is empty: neither"
        raise RecordingError(
            f"{path}: the file {problem} a recording (MCAP, bt-mission run --record) nor a trace "
            "(JSON lines, run --trace)"
        )
    return MAGIC.startswith(beginning)


def node_of(path: Path, facts: RunFacts, robot: str) -> str:
    """Return the executive of a robot in a recording.

    Raises:
        RecordingError: The recording has no such robot.
    """
    nodes = {robot_of(node): node for node in facts.missions}
    wanted = robot.strip("/")
    if wanted in nodes:
        return nodes[wanted]
    known = [name for name in nodes if name]
    if not known:
        raise RecordingError(f"{path}: the recorded robot has no name; omit --robot")
    hint = did_you_mean(wanted, known)
    suggestion = f"; {hint}" if hint else ""
    raise RecordingError(
        f"{path}: contains no mission of a robot {quoted(robot)} (robots: "
        f"{listed(known)}){suggestion}"
    )


class RecordedFile:
    """The content of an MCAP file. Read :meth:`messages` to the end; the rest is known then.

    Args:
        robot: The robot of several with missions; None is the first.

    Raises:
        RecordingError: The file is invalid or cannot be opened.
    """

    def __init__(self, path: Path, robot: str | None = None) -> None:
        self.path = path
        self._robot = robot
        self._begins: str | None = None
        self._others: tuple[str, ...] | None = None
        """The prefixes of topics of other robots with missions; None before they are known."""
        self.library = ""
        self.notes: dict[str, Mapping[str, str]] = {}
        self.attached: list[RecordingAttachment] = []
        self.why_cut = ""
        """Why it ends early; empty if it is complete."""
        self.first_ns: int | None = None
        self.last_ns = 0
        """Times of the messages that :meth:`timed_messages` has yielded."""
        self.unread: dict[str, str] = {}
        """Why the messages of a type could not be read."""
        self._unread: Counter[str] = Counter()
        self._unknown: Counter[str] = Counter()
        self._read: Counter[type[records.McapRecord]] = Counter()
        self._topics: set[str] = set()

    @property
    def topics(self) -> str:
        """Some of the topics, as text; empty without a message."""
        more = ", ..." if len(self._topics) > SHOWN_TOPICS else ""
        return ", ".join(sorted(self._topics)[:SHOWN_TOPICS]) + more

    @cached_property
    def facts(self) -> RunFacts:
        """The facts of the recorder, once all messages were read."""
        return RunFacts(self.notes, self.node)

    @property
    def node(self) -> str:
        """The executive whose mission is read; known with the first message, empty for a bag."""
        first = RunFacts(self.notes)
        return node_of(self.path, first, self._robot) if self._robot is not None else first.node

    def is_of_another(self, topic: str) -> bool:
        """Return whether a topic belongs to another robot with a mission in the file."""
        if self._others is None:
            first, node = RunFacts(self.notes), self.node
            names = [robot_of(mission) for mission in first.missions if mission != node]
            self._others = tuple(f"/{name}/" for name in names)
        return topic.startswith(self._others)

    def is_of_mission(self, topic: str) -> bool:
        """Return whether a topic may be the mission's. Of other graphs, those of its node are."""
        if self._begins is None:
            self._begins = f"{self.node}/" if self.node else "/"
        return topic.startswith(self._begins)

    @property
    def missing(self) -> str:
        """The parts that are missing or cannot be read; empty if it is complete."""
        lacks = [self.facts.missing] if self.facts.missing else []
        for kind, count in self._unread.items():
            what = "a message" if count == 1 else f"{count:,} messages"
            lacks.append(f"{what} of type {kind or '?'} (cannot be read: {self.unread[kind]})")
        for name, count in self._unknown.items():
            what = "an event" if count == 1 else f"{count:,} events"
            lacks.append(f"{what} {quoted(name)} (this bt-mission does not know it)")
        lacks += [f"its '{name}' (cannot be read)" for name in self.facts.unread]
        return "; ".join(lacks)

    def started_ns(self, tree_ns: int) -> int:
        """Return the ROS time from which the times of a run count, ns, as `run` does.

        A simulation starts before the first tick; against other servers a run starts with it.

        Args:
            tree_ns: The stamp of the mission's tree.
        """
        return tree_ns if self.facts.start_ns is None else self.facts.start_ns

    def timed_messages(self) -> Iterator[tuple[int, Channel, bytes]]:
        """Yield the CDR messages in the order of the file, each with its time, ns.

        Raises:
            RecordingError: The file is invalid or cannot be opened.
        """
        for channel, time_ns, data in self.messages():
            if channel.encoding != "cdr":
                continue
            if time_ns > LARGEST_NS:
                self.note_unread(channel, DecodingError(f"its time is {time_ns} ns"))
                continue
            if self.first_ns is None:
                self.first_ns = time_ns
            self.last_ns = max(self.last_ns, time_ns)
            yield time_ns, channel, data

    def note_unread(self, channel: Channel, error: Exception) -> None:
        """Note why a message of a topic cannot be read."""
        self._unread[channel.type_name] += 1
        self.unread.setdefault(channel.type_name, str(error) or type(error).__name__)

    def note_unknown(self, event: str) -> None:
        """Note the name of an event in the trace that is not known here."""
        self._unknown[event] += 1

    def messages(self) -> Iterator[Message]:
        """Yield all messages in the order of the file.

        Raises:
            RecordingError: The file is invalid or cannot be opened.
        """
        try:
            with open_recording(self.path) as stream:
                self._check_beginning(stream)
            with open_recording(self.path) as stream:
                yield from self._messages(stream)
        except UNPACKING as error:
            raise RecordingError(f"{self.path}: cannot unpack it: {error}") from error
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot read it: {error.strerror}") from error

    def _check_beginning(self, stream: BinaryIO) -> None:
        beginning = stream.read(len(MAGIC))
        if not beginning:
            raise RecordingError(f"{self.path}: the file is empty")
        if not MAGIC.startswith(beginning):
            raise RecordingError(
                f"{self.path}: not an MCAP file; create one with `bt-mission run --record`"
            )

    def _messages(self, stream: BinaryIO) -> Iterator[Message]:
        schemas: dict[int, records.Schema] = {}
        channels: dict[int, Channel] = {}
        for record in self._records(stream):
            self._read[type(record)] += 1
            match record:
                case records.Message():
                    channel = channels.get(record.channel_id)
                    if channel is None:
                        continue
                    self._topics.add(channel.topic)
                    yield channel, record.log_time, record.data
                case records.Schema():
                    schemas[record.id] = record
                case records.Channel():
                    schema = schemas.get(record.schema_id)
                    channel = Channel(
                        record.topic,
                        schema.name if schema else "",
                        schema.data.decode(errors="replace") if schema else "",
                        record.message_encoding,
                    )
                    if channel != channels.get(record.id):  # some repeat it in each chunk
                        channels[record.id] = channel
                case records.Metadata():
                    self.notes[record.name] = record.metadata
                case records.Attachment():
                    self.attached.append(
                        RecordingAttachment(
                            record.name, record.media_type, record.log_time, record.data
                        )
                    )
                case records.Header():
                    self.library = record.library

    def _records(self, stream: BinaryIO) -> Iterator[records.McapRecord]:
        self._read.clear()
        reader = StreamReader(
            stream, emit_chunks=True, validate_crcs=True, record_size_limit=LARGEST_RECORD
        )
        read = reader.records
        while True:
            try:
                record = next(read)
                inside = _records_in(record) if isinstance(record, records.Chunk) else (record,)
            except StopIteration:
                self.why_cut = "the marker at the end of the data is missing"
                return
            except Exception as error:  # noqa: BLE001 - whatever a damaged chunk does to a decompressor
                self._note_cut(stream, error)
                return
            if isinstance(record, records.DataEnd):
                self._compare(read, stream)
                return
            yield from inside

    def _compare(self, summary: Iterator[records.McapRecord], stream: BinaryIO) -> None:
        """Look whether all was read of what is in the file, as the summary at its end counts it."""
        try:
            for record in summary:
                if isinstance(record, records.Statistics):
                    counts = {
                        "messages": (record.message_count, self._read[records.Message]),
                        "files": (record.attachment_count, self._read[records.Attachment]),
                        "notes": (record.metadata_count, self._read[records.Metadata]),
                    }
                    wrong = [
                        f"{there:,} {name} where {wanted:,} were recorded"
                        for name, (wanted, there) in counts.items()
                        if there != wanted
                    ]
                    if wrong:
                        self.why_cut = f"the file is damaged: it has {listed(wrong)}"
        except Exception as error:  # noqa: BLE001 - as where messages are read
            self._note_cut(stream, error)

    def _note_cut(self, stream: BinaryIO, error: Exception) -> None:
        if isinstance(error, CRCValidationError) and isinstance(error.record, records.DataEnd):
            self.why_cut = "the file is damaged: its data has another checksum than when written"
            return
        at = stream.tell()
        size = self.path.stat().st_size
        self.why_cut = (
            "the file is incomplete, or the recorder was killed"
            if at >= size
            else f"the file is damaged before byte {at} of {size} ({type(error).__name__}: {error})"
        )
