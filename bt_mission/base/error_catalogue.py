"""The catalogue of errors and warnings: what each code means, with an example and a cure.

The entries are in `error_catalogue.toml`, and in ``errors.toml`` of each command's folder, which
also gives examples to these entries. Errors carry their code as a text such as ``BT-203``, so the
catalogue is read only where somebody asks for an explanation.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from types import MappingProxyType
from typing import Any

from bt_mission.base.commands import all_rows
from bt_mission.base.diagnostics import quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.text import escape_control

GROUPS: Mapping[int, str] = {
    1: "Files and YAML",
    2: "Nodes and keys",
    3: "Values and units",
    4: "Expressions",
    5: "Types, interfaces and goals",
    6: "Requirements",
    7: "Scenarios, faults, fleets and ranges",
    8: "Worlds and robots",
    9: "Runs and ROS",
    10: "Recordings",
    11: "Command line",
    12: "XML of BehaviorTree.CPP",
}
"""The kinds of mistake, by the hundreds of their codes; commands bring more."""

PROMPT = "$ "
"""Begins an example that is a command."""

_CODE = re.compile(r"(?:bt-?)?([0-9]{1,6})", re.IGNORECASE)


@dataclass(frozen=True)
class CatalogueEntry:
    """A kind of mistake.

    Attributes:
        code: Such as ``BT-203``.
        title: In a few words.
        cause: Why it is reported.
        cure: What to do.
        wrong: The smallest file with this mistake, or a command; may be empty.
        right: The same without the mistake.
        line: Of `wrong`, where it is reported; 0 is the whole file.
        file: The name of the file.
        beside: Files that the example needs, by their names.
        group: Its kind of mistake.
    """

    code: str
    title: str
    cause: str
    cure: str
    wrong: str = ""
    right: str = ""
    line: int = 0
    file: str = "mission.yaml"
    beside: Mapping[str, str] = field(default_factory=dict)
    group: str = ""

    @property
    def is_command(self) -> bool:
        """Whether the example is a command."""
        return self.wrong.startswith(PROMPT)

    @property
    def page(self) -> str:
        """The page that explains it, below the folder of pages."""
        return page_of(self.code)

    @property
    def anchor(self) -> str:
        """Of its section on its page."""
        return self.code.lower()


def page_of(code: str) -> str:
    """Return the page that explains a code: ``reference/errors/bt-2xx.md``."""
    return f"reference/errors/{code[:-2].lower()}xx.md"


@cache
def catalogue() -> Mapping[str, CatalogueEntry]:
    """Return all entries by their codes, in the order of the codes."""
    groups = dict(GROUPS)
    entries: dict[str, dict[str, Any]] = {}
    for text in _texts():
        written = tomllib.loads(text)
        named = {int(number): name for number, name in written.pop("groups", {}).items()}
        groups = named | groups  # ours have precedence
        for code, entry in written.items():
            entries[code] = entry | entries.get(code, {})
    return MappingProxyType(
        {
            code: CatalogueEntry(code, **entries[code], group=groups[_number(code) // 100])
            for code in sorted(entries, key=_number)
        }
    )


def _texts() -> Iterator[str]:
    """Yield the catalogue, and the part of each command."""
    yield files("bt_mission.base").joinpath("error_catalogue.toml").read_text(encoding="utf-8")
    for file in dict.fromkeys(row.errors for row in all_rows().values()):
        if file is not None:
            yield file.read_text(encoding="utf-8")


def _number(code: str) -> int:
    return int(code.removeprefix("BT-"))


def shown(example: str) -> str:
    """Return an example as it is printed: control characters are escaped."""
    return "\n".join(map(escape_control, example.strip("\n").split("\n")))


def looks_like_code(text: str) -> bool:
    """Return whether a text is written as a code, whether that exists or not."""
    return re.fullmatch(r"(?:bt-?)?[0-9]+", text.strip(), re.IGNORECASE) is not None


def entries_about(text: str, most: int = 5) -> list[CatalogueEntry]:
    """Return the entries whose title or cause has the most words of a text, the best first."""
    wanted = set(_words(text))

    def rank(entry: CatalogueEntry) -> tuple[int, int]:
        return len(wanted & {*_words(entry.title)}), len(wanted & {*_words(entry.cause)})

    known = [entry for entry in catalogue().values() if any(rank(entry))]
    return sorted(known, key=rank, reverse=True)[:most]


def _words(text: str) -> list[str]:
    """Return the words of a text in lower case, without those that any message may have."""
    words = re.findall(r"[a-z_]+", text.lower())
    return [word.removesuffix("s") for word in words if word not in _EVERYWHERE]


_EVERYWHERE = {"a", "an", "the", "is", "are", "of", "in", "on", "to", "such", "and", "or", "with"}


def entry_of(code: str) -> CatalogueEntry:
    """Return the entry of a code, which may be written as ``BT-203``, ``bt-203`` or ``203``.

    Raises:
        BtMissionError: With the nearest codes.
    """
    number = _CODE.fullmatch(code.strip())
    named = f"BT-{number[1]}" if number else code.upper()
    entries = catalogue()
    if named not in entries:
        near = difflib.get_close_matches(named[:20], entries, n=3, cutoff=0.0)
        shown = "; ".join(f"{each} ({entries[each].title})" for each in near)
        message = f"no error has the code {quoted(code)}; nearest: {shown}"
        raise BtMissionError(message, code="BT-1101")
    return entries[named]
