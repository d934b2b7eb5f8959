"""The comments in interface files: descriptions of fields, units, named values.

A message class has names, types and defaults, but not the comments. ROS's reader of these files
joins a heading above a group of fields and the remark behind a field to one comment. The unit is in
the remark, so they are separated here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from bt_mission.base.units import UNITS

END_OF_SECTION = "---"

_UNITS = frozenset((*UNITS, "m^2", "m/s^2", "1/s", "Hz", "%", "V"))
"""Units that begin a comment, before a comma: ``deg, how far to turn``."""

_FIELD = re.compile(r"([A-Za-z][\w/]*(?:<=\d+)?(?:\[[^\]]*\])?)\s+([A-Za-z]\w*)\s*(=?)\s*(.*)")


@dataclass(frozen=True)
class FieldComment:
    """The comment of one field: its unit, empty if it is not known, and the rest of the text."""

    unit: str = ""
    text: str = ""


@dataclass(frozen=True)
class NamedValue:
    """A constant of a section, such as ``uint16 BLOCKED=906``."""

    type: str
    name: str
    value: str
    text: str = ""


@dataclass
class Section:
    """A part of an interface file: a goal, a request, a whole message."""

    remarks: dict[str, FieldComment] = field(default_factory=dict)
    types: dict[str, str] = field(default_factory=dict)
    constants: list[NamedValue] = field(default_factory=list)

    def remark(self, name: str) -> FieldComment:
        """Return the comment of a field; empty without one."""
        return self.remarks.get(name, FieldComment())

    def name_of(self, name: str, value: object) -> str:
        """Return the name of a field's value if it is that of a single constant, else empty."""
        if not re.search(r"code|status|state|mode|type|level|kind", name):
            return ""
        kind = self.types.get(name)
        constants = [
            constant
            for constant in self.constants
            if constant.type == kind and constant.value == str(value)
        ]
        return constants[0].name if len(constants) == 1 else ""


@dataclass(frozen=True)
class InterfaceText:
    """An interface file: its comment, and its sections in order."""

    text: str
    sections: tuple[Section, ...]

    def section(self, index: int) -> Section:
        """Return the section at an index; an empty one without it."""
        return self.sections[index] if index < len(self.sections) else Section()


def read_interface(text: str) -> InterfaceText:
    """Read the text of an ``.action``, ``.srv`` or ``.msg`` file; what it cannot read is left out.

    The comment behind a field is about the field; so is one directly above it, unless a blank line
    or the start of the section makes it a heading, and so are indented ones below it.
    """
    parts: list[list[str]] = [[]]
    for line in text.splitlines():
        if line.strip() == END_OF_SECTION:
            parts.append([])
        else:
            parts[-1].append(line.rstrip())
    heading = list(_heading(parts[0]))
    parts[0] = parts[0][len(heading) :]
    words = " ".join(line.strip("# ").strip() for line in heading).strip()
    is_title = re.fullmatch("(the )?(goal|request)( definition)?", words, re.IGNORECASE)
    return InterfaceText("" if is_title else words, tuple(_section(lines) for lines in parts))


def field_comment(comment: str) -> FieldComment:
    """Separate the unit from the rest of a comment."""
    whole = " ".join(comment.split())
    unit, _, text = whole.partition(",")
    return FieldComment(unit, text.strip()) if unit in _UNITS else FieldComment("", whole)


def _heading(lines: list[str]) -> Iterator[str]:
    """The comment on top of a file: it is about the file, as ROS has it, and not about a field."""
    for line in lines:
        if not line.startswith("#"):
            return
        yield line


def _section(lines: list[str]) -> Section:
    section = Section()
    above: list[str] = []
    last: str | None = None
    comments: dict[str, str] = {}
    for line in lines:
        code, hash_, comment = _split(line)
        if not code:
            if not hash_:
                above, last = [], None
            elif line[0] in " \t" and last is not None:
                comments[last] = f"{comments[last]} {comment}"
            else:
                above.append(comment)
            continue
        if match := _FIELD.fullmatch(code):
            kind, name, equals, value = match.groups()
            comment_text = comment or " ".join(above)
            if equals:
                section.constants.append(NamedValue(kind, name, value.strip(), comment_text))
                last = None
            else:
                section.types[name] = kind
                comments[name] = comment_text
                last = name
        above = []
    section.remarks = {name: field_comment(comment) for name, comment in comments.items()}
    return section


def _split(line: str) -> tuple[str, str, str]:
    """Split a line at its comment; a ``#`` within quotes begins none."""
    quote = ""
    for index, character in enumerate(line):
        if quote:
            quote = "" if character == quote else quote
        elif character in "\"'" and "=" in line[:index]:
            quote = character
        elif character == "#":
            return line[:index].strip(), "#", line[index:].strip("# ").strip()
    return line.strip(), "", ""
