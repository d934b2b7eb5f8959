"""MCAP records written to a stream, a whole chunk of messages at a time.

The records are those of the library ``mcap``. Its writer takes 3 us for each message, which is a
fifth of what it takes to make one; here the messages of a chunk are packed together, in a tenth of
that.
"""

from __future__ import annotations

import struct
import zlib
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import BinaryIO

import lz4.frame
from mcap import records
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.writer import MCAP0_MAGIC

COMPRESSION = "lz4"
"""Takes a third of the time of Zstandard, for a file that is a fifth larger."""

Message = tuple[int, bytes]
"""A channel, and serialized data."""

_HEAD = struct.Struct("<BQHIQQ")
_INDEX_HEAD = struct.Struct("<BQHI")
_CHUNK_HEAD = struct.Struct(f"<BQQQQII{len(COMPRESSION)}sQ")
_RECORD_HEAD = 9
"""Bytes of the opcode and the length of a record."""
_FIELDS = _HEAD.size - _RECORD_HEAD  # of a message before its data


class ChunkWriter:
    """Writes one file. Its methods raise the exceptions of the stream."""

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.bytes_written = 0
        self._checksum = 0
        """The checksum of everything written (CRC-32), by which damage is detected."""
        self._summary: dict[Opcode, list[records.McapRecord]] = {
            Opcode.SCHEMA: [],
            Opcode.CHANNEL: [],
            Opcode.STATISTICS: [],
            Opcode.CHUNK_INDEX: [],
            Opcode.ATTACHMENT_INDEX: [],
            Opcode.METADATA_INDEX: [],
        }
        self._counts: dict[int, int] = {}
        self._times: list[int] = []
        self._begin_chunk()

    def start(self, profile: str, library: str) -> None:
        """Begin the file."""
        self._write(MCAP0_MAGIC)
        self._write(_packed(records.Header(profile, library)))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Add a schema; it is written with the next chunk."""
        number = len(self._summary[Opcode.SCHEMA]) + 1
        schema = records.Schema(id=number, data=data, encoding=encoding, name=name)
        self._add_definition(Opcode.SCHEMA, schema)
        return number

    def add_channel(
        self, topic: str, encoding: str, schema: int, metadata: Mapping[str, str]
    ) -> int:
        """Add a channel; it is written with the next chunk."""
        number = len(self._summary[Opcode.CHANNEL]) + 1
        channel = records.Channel(
            id=number,
            topic=topic,
            message_encoding=encoding,
            metadata=dict(metadata),
            schema_id=schema,
        )
        self._add_definition(Opcode.CHANNEL, channel)
        return number

    def _add_definition(self, opcode: Opcode, record: records.McapRecord) -> None:
        self._summary[opcode].append(record)
        data = _packed(record)
        self._parts.append(data)
        self._size += len(data)

    def _begin_chunk(self) -> None:
        self._parts: list[bytes] = []
        self._size = 0
        self._index: dict[int, list[int]] = defaultdict(list)
        """Of each channel the time and the place of each message, in turns."""
        self._chunk_times: list[int] = []
        self.waiting = 0
        """Messages of the next chunk."""

    def add_messages(self, time_ns: int, messages: Sequence[Message]) -> None:
        """Add messages of one instant, ns, to the next chunk."""
        parts, index, at = self._parts, self._index, self._size
        pack, head, fields = _HEAD.pack, _HEAD.size, _FIELDS
        for channel, data in messages:
            length = len(data)
            parts += (pack(Opcode.MESSAGE, fields + length, channel, 0, time_ns, time_ns), data)
            index[channel] += (time_ns, at)
            at += head + length
        self._size = at
        self._chunk_times.append(time_ns)
        self.waiting += len(messages)

    def write_chunk(self) -> None:
        """Write a chunk of the added messages, and their index."""
        data, index = b"".join(self._parts), self._index
        first_ns, last_ns = min(self._chunk_times), max(self._chunk_times)
        self._begin_chunk()
        self._write_chunk(data, first_ns, last_ns, index)
        self._times += (first_ns, last_ns)
        for channel, entries in index.items():
            self._counts[channel] = self._counts.get(channel, 0) + len(entries) // 2

    def _write_chunk(
        self, data: bytes, first_ns: int, last_ns: int, index: Mapping[int, list[int]]
    ) -> None:
        compressed = lz4.frame.compress(data)
        begin = self.bytes_written
        fields = _CHUNK_HEAD.size - _RECORD_HEAD
        head = _CHUNK_HEAD.pack(
            *(Opcode.CHUNK, fields + len(compressed), first_ns, last_ns, len(data)),
            *(zlib.crc32(data), len(COMPRESSION), COMPRESSION.encode(), len(compressed)),
        )
        self._write(head)
        self._write(compressed)
        length = self.bytes_written - begin
        offsets = {}
        for channel, entries in index.items():
            offsets[channel] = self.bytes_written
            size = 8 * len(entries)
            head = _INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, 6 + size, channel, size)
            self._write(head + struct.pack(f"<{len(entries)}Q", *entries))
        self._summary[Opcode.CHUNK_INDEX].append(
            records.ChunkIndex(
                chunk_length=length,
                chunk_start_offset=begin,
                compression=COMPRESSION,
                compressed_size=len(compressed),
                message_start_time=first_ns,
                message_end_time=last_ns,
                message_index_length=self.bytes_written - begin - length,
                message_index_offsets=offsets,
                uncompressed_size=len(data),
            )
        )

    def write_attachment(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Write a file into the file."""
        begin = self.bytes_written
        self._write(_packed(records.Attachment(0, time_ns, name, media_type, data)))
        self._summary[Opcode.ATTACHMENT_INDEX].append(
            records.AttachmentIndex(
                offset=begin,
                length=self.bytes_written - begin,
                create_time=0,
                log_time=time_ns,
                data_size=len(data),
                name=name,
                media_type=media_type,
            )
        )

    def write_metadata(self, name: str, facts: Mapping[str, str]) -> None:
        """Write named facts."""
        begin = self.bytes_written
        self._write(_packed(records.Metadata(name, dict(facts))))
        self._summary[Opcode.METADATA_INDEX].append(
            records.MetadataIndex(begin, self.bytes_written - begin, name)
        )

    def finish(self) -> None:
        """Write the summary, and end the file."""
        self._write(_packed(records.DataEnd(self._checksum)))
        begin = self.bytes_written
        self._summary[Opcode.STATISTICS].append(self._statistics())
        summary, offsets = b"", b""
        for opcode, group in self._summary.items():
            if group:
                data = b"".join(map(_packed, group))
                place = records.SummaryOffset(opcode, begin + len(summary), len(data))
                offsets += _packed(place)
                summary += data
        footer = records.Footer(
            summary_start=begin, summary_offset_start=begin + len(summary), summary_crc=0
        )
        # The sum covers everything from the summary on, up to the sum itself.
        before = summary + offsets + _packed(footer)[:-4]
        footer.summary_crc = zlib.crc32(before)
        self._write(summary + offsets + _packed(footer) + MCAP0_MAGIC)

    def _statistics(self) -> records.Statistics:
        counts = {opcode: len(group) for opcode, group in self._summary.items()}
        return records.Statistics(
            attachment_count=counts[Opcode.ATTACHMENT_INDEX],
            channel_count=counts[Opcode.CHANNEL],
            channel_message_counts=self._counts,
            chunk_count=counts[Opcode.CHUNK_INDEX],
            message_count=sum(self._counts.values()),
            message_end_time=max(self._times, default=0),
            message_start_time=min(self._times, default=0),
            metadata_count=counts[Opcode.METADATA_INDEX],
            schema_count=counts[Opcode.SCHEMA],
        )

    def _write(self, data: bytes) -> None:
        self._stream.write(data)
        self._checksum = zlib.crc32(data, self._checksum)
        self.bytes_written += len(data)


def _packed(record: records.McapRecord) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap annotates its parameters
