"""An MCAP file that is written while things happen, and can be read wherever it is cut."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import BinaryIO

from mcap.writer import CompressionType, Writer

from bt_mission.common.errors import BtMissionError

PROFILE = "ros2"
ENCODING = "cdr"
SCHEMA_ENCODING = "ros2msg"

FLUSH_NS = 1_000_000_000
"""What is older than this, by the time of the messages, is on its way to the disk."""


class McapFile:
    """Messages of topics with their types, in chunks of about a second.

    Once the disk is full, or a write fails for another reason, nothing more is written, and
    :attr:`fault` says why; what was written before can be read.

    :param path: is overwritten.
    :param library: who writes, for the header.
    :param stream: write here instead of opening ``path``.
    :raises BtMissionError: when the file cannot be opened.
    """

    def __init__(self, path: Path, library: str, stream: BinaryIO | None = None) -> None:
        self.path = path
        self.fault: str | None = None
        self.kept_ns: int | None = None
        """Everything up to this time is in the file; None while no message is."""
        self.messages = 0
        self.bytes = 0
        """Bytes written, as of the last flush."""
        self._waiting: list[tuple[int, int, bytes]] = []
        self._last_ns = 0
        self._schemas: dict[str, int] = {}
        try:
            self._stream = path.open("wb") if stream is None else stream
        except OSError as error:
            raise BtMissionError(f"{path}: cannot write the recording: {error.strerror}") from error
        # LZ4 takes a fifth of the time of Zstandard here, and the file is a fifth larger.
        self._writer = Writer(self._stream, compression=CompressionType.LZ4)
        try:
            self._writer.start(PROFILE, library)
        except OSError as error:
            self._give_up(error)

    def channel(
        self, topic: str, type_name: str, definition: str, metadata: Mapping[str, str]
    ) -> int:
        """Make a channel for a topic; gives its number, which is 0 once writing has failed."""
        if self.fault is not None:
            return 0
        try:
            if type_name not in self._schemas:
                self._schemas[type_name] = self._writer.register_schema(
                    type_name, SCHEMA_ENCODING, definition.encode()
                )
            schema = self._schemas[type_name]
            return self._writer.register_channel(topic, ENCODING, schema, dict(metadata))
        except OSError as error:  # a chunk was full
            self._give_up(error)
            return 0

    def write(self, channel: int, time_ns: int, data: bytes) -> None:
        """Add a serialized message."""
        # Kept, and written together a second at a time: in between, other code would have to make
        # way for the writer's in the processor's caches, and be fetched again.
        self._waiting.append((channel, time_ns, data))
        if not 0 <= time_ns - self._last_ns < FLUSH_NS:
            self.flush()

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Put a file into the file."""
        if self.fault is None:
            try:
                self._writer.add_attachment(0, time_ns, name, media_type, data)
            except OSError as error:
                self._give_up(error)

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Put named facts into the file."""
        if self.fault is None:
            try:
                self._writer.add_metadata(name, dict(facts))
            except OSError as error:
                self._give_up(error)

    def flush(self) -> None:
        """End the chunk, and hand everything to the operating system."""
        waiting, self._waiting = self._waiting, []
        if self.fault is not None:
            return
        add = self._writer.add_message
        try:
            for channel, time_ns, data in waiting:
                add(channel, time_ns, data, time_ns)
            self._writer.flush()  # type: ignore[no-untyped-call]  # mcap annotates its parameters only
            self.bytes = self._stream.tell()
        except OSError as error:
            self._give_up(error)
            return
        self.messages += len(waiting)
        if waiting:
            self.kept_ns = self._last_ns = waiting[-1][1]

    def close(self) -> None:
        """Write the summary by which readers find their way, and close."""
        self.flush()
        if self.fault is None:
            try:
                self._writer.finish()  # type: ignore[no-untyped-call]
                self._stream.flush()
                self.bytes = self._stream.tell()
            except OSError as error:
                self._give_up(error)
        self._shut()

    def _give_up(self, error: OSError) -> None:
        self.fault = error.strerror or str(error)
        self._shut()

    def _shut(self) -> None:
        try:
            self._stream.close()
        except OSError:  # what is still buffered does not fit either; it is closed all the same
            if self.fault is None:
                raise
