"""An MCAP file that is written while things happen, and can be read wherever it is cut."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import BinaryIO

from bt_mission.base.output import OutputFile
from bt_mission.recording.chunks import ChunkWriter, Message

PROFILE = "ros2"
ENCODING = "cdr"
SCHEMA_ENCODING = "ros2msg"

MOST_WAITING = 5_000
"""Messages that wait to be written, however little time passes."""

FLUSH_NS = 1_000_000_000
"""Older messages, by their time, are flushed to the disk."""


class McapFile:
    """Messages of topics with their types, in chunks of about a second.

    Once the disk is full, or a write fails for another reason, nothing more is written, and
    :attr:`write_error` has the reason. Everything written before can be read.

    Args:
        path: See :class:`OutputFile`.
        library: The name of the writer, for the header.
        stream: Write here instead of opening ``path``.

    Raises:
        BtMissionError: The file cannot be opened.
    """

    def __init__(self, path: Path, library: str, stream: BinaryIO | None = None) -> None:
        self.output = OutputFile(path, stream)
        self.kept_ns: int | None = None
        """Everything up to this time is in the file; None before the first message."""
        self.messages = 0
        self.bytes = 0
        """Bytes written, as of the last flush."""
        self._newest_ns = self._last_ns = 0
        """The times of the newest message, and of the newest at the last flush."""
        self._schemas: dict[str, int] = {}
        self._stream = self.output.stream
        self._writer = ChunkWriter(self._stream)
        self._try(lambda: self._writer.start(PROFILE, library))

    @property
    def path(self) -> Path:
        """The path: a file that replaces another is beside that until it is closed complete."""
        return self.output.place

    @property
    def write_error(self) -> str | None:
        """Why nothing more is written; None without an error."""
        return self.output.write_error

    def channel(
        self, topic: str, type_name: str, definition: str, metadata: Mapping[str, str]
    ) -> int:
        """Make a channel for a topic. Return its number."""
        if type_name not in self._schemas:
            self._schemas[type_name] = self._writer.add_schema(
                type_name, SCHEMA_ENCODING, definition.encode()
            )
        return self._writer.add_channel(topic, ENCODING, self._schemas[type_name], metadata)

    def write(self, time_ns: int, messages: Sequence[Message]) -> None:
        """Add the messages of one instant, each the number of its channel and its bytes.

        They are flushed a second after the last time, or when many are waiting.
        """
        if not messages or self.write_error is not None:
            return
        self._writer.add_messages(time_ns, messages)
        self._newest_ns = time_ns
        is_late = not 0 <= time_ns - self._last_ns < FLUSH_NS
        if is_late or self._writer.waiting > MOST_WAITING:
            self.flush()

    def attach(self, name: str, media_type: str, data: bytes, time_ns: int) -> None:
        """Put a file into the file."""
        self._try(lambda: self._writer.write_attachment(name, media_type, data, time_ns))

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Put named facts into the file."""
        self._try(lambda: self._writer.write_metadata(name, facts))

    def flush(self) -> None:
        """End the chunk, and hand everything to the operating system."""
        waiting = self._writer.waiting

        def write() -> None:
            if waiting:
                self._writer.write_chunk()
            self._stream.flush()

        self._try(write)
        if self.write_error is not None:
            return
        self.bytes = self._writer.bytes_written
        self.messages += waiting
        if waiting:
            self.kept_ns = self._last_ns = self._newest_ns

    def abandon(self, why: str) -> None:
        """Write nothing more."""
        self.output.abandon(why)
        self.output.close()

    def close(self, *, replaces: bool = True) -> None:
        """Write the summary that readers use, and close.

        Args:
            replaces: Whether a complete file replaces the existing one.
        """
        self.flush()
        self._try(self._writer.finish)
        self._try(self._stream.flush)
        self.bytes = self._writer.bytes_written
        self.output.close(replaces=replaces)

    def _try(self, write: Callable[[], object]) -> None:
        """Write, unless a write has failed; stop writing if this one fails."""
        self.output.attempt(write)
        if self.write_error is not None:
            self.output.close()
