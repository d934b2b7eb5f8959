"""The bytes of a file around its text: the ends of its lines, and the mark at its beginning."""

from __future__ import annotations

import re
from codecs import BOM_UTF8
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from bt_mission.base.errors import BtMissionError
from bt_mission.base.yaml.document import text_of
from bt_mission.commands.edit.common_lines import common_lines

LINE_FEED = "\n"

_END = re.compile(r"\r\n|\r|\n")


class LineEndsError(BtMissionError):
    """Too many lines are alike to find which of them kept their ends."""

    code = "BT-1302"


@dataclass(frozen=True)
class EditedText:
    """A file as the editor shows it, and as it is written.

    Attributes:
        text: Its text, in which every line ends with a line feed.
        ends: How each line ends in the file, in the order of the lines.
        mark: Its byte order mark, if it has one.
    """

    text: str = ""
    ends: tuple[str, ...] = ()
    mark: bytes = b""

    @classmethod
    def of(cls, contents: bytes, file: str) -> Self:
        """Read the contents of a file. Raises InputError."""
        text = text_of(contents, file)
        mark = BOM_UTF8 if contents.startswith(BOM_UTF8) else b""
        return cls(unified(text), tuple(_END.findall(text)), mark)

    def changed_to(self, text: str) -> bytes:
        """Return the contents of the file with another text.

        Lines that are the same end as before, others as most lines do.

        Raises:
            LineEndsError: Lines end in several ways, and too many of them are alike.
        """
        text = unified(text)
        usual = Counter(self.ends).most_common(1)
        end = usual[0][0] if usual else LINE_FEED
        lines = text.split(LINE_FEED)
        ends = [end] * (len(lines) - 1)
        if len(set(self.ends)) > 1:
            self._keep(lines[:-1], ends)
        whole = "".join(line + its for line, its in zip(lines, [*ends, ""], strict=True))
        return self.mark + whole.encode()

    def _keep(self, lines: Sequence[str], ends: list[str]) -> None:
        """Put the ends of unchanged lines into those of other lines."""
        blocks = common_lines(self.text.split(LINE_FEED)[:-1], lines)
        if blocks is None:
            raise LineEndsError(
                "the lines of this file end in several ways, and too many between your changes "
                "are alike: give all lines one end in another program first"
            )
        for a, b, size in blocks:
            ends[b : b + size] = self.ends[a : a + size]


def unified(text: str) -> str:
    """Return a text in which every line ends with a line feed, as on a page."""
    return _END.sub(LINE_FEED, text) if "\r" in text else text
