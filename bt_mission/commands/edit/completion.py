"""Completion, hover and definitions at a place of a mission that is being written.

The text need not be valid YAML, so the context of a place follows from indentation and brackets.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from bt_mission.base import files
from bt_mission.base.errors import BtMissionError
from bt_mission.commands.edit.checks import permissions
from bt_mission.commands.edit.source import CHILD_KEYS, LIST_KEYS
from bt_mission.commands.edit.vocabulary import FieldFacts, KindFacts, kinds, mission_fields
from bt_mission.language.expressions.functions import FUNCTIONS
from sim.world.loader import load_world

LONGEST_LINE = 10_000
"""Characters of a line in which there is completion. No mission that a person writes has more."""

# Each of these takes a time that grows as the text does, whatever the text.
_DASHES = re.compile(r"[ ]*(?:-[ ]+)*")
_COMMENT = re.compile(r"(?:^|(?<=\s))#")
_NAMES = re.compile(r"^ *(?:- +)?(?:set|outputs|inputs|needs): *\{([^}]{0,1000})\}", re.MULTILINE)
_PAIR = re.compile(r"(?<![A-Za-z_0-9])([A-Za-z_]\w*): *([^,}]*)")


@dataclass(frozen=True)
class Suggestion:
    """A word that fits at a place.

    Attributes:
        insert: What is written, which may be several lines.
        detail: A few words beside it: type and unit.
        text: Its documentation.
    """

    label: str
    insert: str
    detail: str = ""
    text: str = ""


@dataclass(frozen=True)
class Completion:
    """The words that fit at a place, and the offset from which they replace the text."""

    start: int
    options: tuple[Suggestion, ...]


@dataclass
class CursorContext:
    """The context of an offset: the keys around it, and those beside it.

    Attributes:
        path: Keys from the top to the mapping around it, without indices of lists.
        key: The key whose value it is in; empty in a key.
        beside: The keys of the same mapping, without the one of the place.
        around: In braces, the keys beside the mapping in braces.
        word: What is written of the word so far.
    """

    path: list[str] = field(default_factory=list)
    key: str = ""
    beside: list[str] = field(default_factory=list)
    around: list[str] = field(default_factory=list)
    word: str = ""
    column: int = 0


@dataclass(frozen=True)
class _Line:
    dash: int
    """The column of its first dash; -1 without one."""
    column: int
    key: str


class LongLineError(BtMissionError):
    """A line that is too long for completion."""

    code = "BT-1301"


def place_at(text: str, offset: int) -> CursorContext:
    """Return the context of an offset in a text.

    Raises:
        LongLineError: Its line is too long.
    """
    lines = text[:offset].split("\n")
    current = lines[-1]
    if len(current) > LONGEST_LINE:
        raise LongLineError(
            f"line {len(lines)}: no completion behind {LONGEST_LINE:,} characters of one line"
        )
    place = CursorContext(word=_last_word(current, "./-"))
    before = current[: len(current) - len(place.word)]
    own = _line(current) or _Line(-1, len(current), "")
    opened = _brackets(before)
    at = own.column
    if not before.strip(" -"):
        at = len(before)
        own = _Line(before.find("-"), at, "")
    place.column = at
    place.path = _above(lines[:-1], own, place)
    place.beside += _behind(text[offset:].split("\n")[1:], at)
    if opened:
        place.around = [*place.beside, own.key]
        place.path += [key for key in [own.key, *opened] if key]
        inside = before[before.rindex("{" if "{" in before else "[") + 1 :]
        last = inside.rpartition(",")[2]
        place.key = last.rpartition(":")[0].strip() if ":" in last else ""
        place.beside = [key for key, _ in _PAIR.findall(inside)]
    elif own.key and ":" in before:
        place.key = own.key
    return place


def completion(
    text: str, offset: int, file: str | Path = "", folder: Path | None = None
) -> Completion:
    """Return the words that fit at an offset.

    Args:
        text: The text.
        offset: The place.
        file: Of the text, which need not exist.
        folder: A world is read from there and below, or is a shipped one; None is any.

    Raises:
        LongLineError: The line is too long.
    """
    place = place_at(text, offset)
    wanted = place.word.lower()
    options = [
        option
        for option in (_values(place, text, file, folder) if place.key else _keys(place))
        if option.label.lower().startswith(wanted) or wanted in option.label.lower()
    ]
    options.sort(key=lambda facts: not facts.label.lower().startswith(wanted))
    return Completion(offset - len(place.word), tuple(options))


def hover(
    text: str, offset: int, file: str | Path = "", folder: Path | None = None
) -> Suggestion | None:
    """Return what the word at an offset means, or None. See `completion`."""
    rest = re.match(r"[\w./-]*", text[offset:])
    end = offset + (rest.end() if rest else 0)
    place = place_at(text, end)
    if not place.word:
        return None
    known = _values(place, text, file, folder) if place.key else _keys(place, is_all=True)
    return next((option for option in known if option.label == place.word), None)


def definition(text: str, offset: int) -> int | None:
    """Return the offset at which the tree or variable of a word is defined, or None."""
    rest = re.match(r"[\w-]*", text[offset:])
    word = _last_word(text[:offset], "-") + (rest.group() if rest else "")
    if not word:
        return None
    for block in ("trees", "inputs", "places", "follow"):
        head = re.search(rf"^{block}:", text, re.MULTILINE)
        if head is None:
            continue
        stop = re.search(r"^\S", text[head.end() :], re.MULTILINE)
        end = head.end() + stop.start() if stop else len(text)
        match = re.search(rf"(?<![\w-]){re.escape(word)}[ ]*:", text[head.end() : end])
        if match and head.end() + match.start() != offset:
            return head.end() + match.start()
    match = re.search(
        rf"(?<=[\s{{,]){re.escape(word)}(?= *:)|(?<=: ){re.escape(word)}(?=[}},])", text
    )
    return None if match is None or match.start() <= offset <= match.end() else match.start()


# ---- the context ---------------------------------------------------------------------------------


def _last_word(text: str, signs: str) -> str:
    """Return the letters, digits, underscores and signs at the end of a text."""
    start = len(text)
    while start and (
        text[start - 1].isalnum() or text[start - 1] in signs or text[start - 1] == "_"
    ):
        start -= 1
    return text[start:]


def _line(line: str) -> _Line | None:
    match = _DASHES.match(line)
    column = match.end() if match else 0
    margin = len(line) - len(line.lstrip(" "))
    comment = _COMMENT.search(line, column)
    written = line[column : comment.start() if comment else len(line)].rstrip()
    dash = margin if column > margin else -1
    if written[:1] in ("", "'", '"', "{", "["):
        return _Line(dash, column, "") if dash >= 0 else None
    return _Line(dash, column, written.partition(":")[0].rstrip())


def _brackets(before: str) -> list[str | None] | None:
    """Return the keys of the brackets that are open at the end of a line, the outermost first.

    The key of the first bracket is that of the line itself, and left out; None without brackets.
    """
    opened: list[str | None] = []
    quote = ""
    for index, char in enumerate(before):
        if quote:
            quote = "" if char == quote else quote
        elif char in "'\"":
            quote = char
        elif char in "{[":
            opened.append((_key_before(before, index) or None) if opened else None)
        elif char in "}]" and opened:
            opened.pop()
    return opened or None


def _key_before(text: str, end: int) -> str:
    """Return the key whose value begins at an offset, if it is a plain word."""
    while end and text[end - 1] == " ":
        end -= 1
    if not end or text[end - 1] != ":":
        return ""
    end -= 1
    while end and text[end - 1] == " ":
        end -= 1
    return _last_word(text[:end], ".-")


def _above(lines: Sequence[str], own: _Line, place: CursorContext) -> list[str]:
    """Return the keys above a line, and note those beside it."""
    path: list[str] = []
    column = own.column
    limit = own.dash if own.dash >= 0 else column - 1
    is_beside = own.dash < 0
    for written in reversed(lines):
        line = _line(written)
        if line is None:
            continue
        if line.column == column and line.column > limit:
            if is_beside and line.key:
                place.beside.append(line.key)
            if line.dash >= 0 and is_beside:
                limit, is_beside = line.dash, False
            elif line.dash >= 0 and line.dash < limit:
                limit = line.dash
        elif line.column <= limit:
            if line.key:
                path.insert(0, line.key)
            column = line.column
            limit = line.dash if line.dash >= 0 else line.column - 1
            is_beside = False
            if line.column == 0:
                break
    return path


def _behind(lines: Sequence[str], column: int) -> Iterator[str]:
    """Yield the keys of the same mapping in the lines behind."""
    for written in lines:
        line = _line(written)
        if line is None:
            continue
        if line.column < column or (line.dash >= 0 and line.column <= column):
            return
        if line.column == column and line.key:
            yield line.key


def _is_node(path: Sequence[str]) -> bool:
    if not path:
        return False
    return path[-1] in LIST_KEYS or path[-1] in CHILD_KEYS or list(path) == ["tree"]


# ---- the words -----------------------------------------------------------------------------------


def _keys(place: CursorContext, *, is_all: bool = False) -> Iterator[Suggestion]:
    """Yield the keys that fit."""
    known = kinds()
    if not place.path:
        taken = () if is_all else place.beside
        yield from (_of_field(facts) for facts in mission_fields() if facts.keys[0] not in taken)
        for key, words in (("tree", "the tree of the mission"), ("trees", "named trees")):
            if key not in taken:
                yield Suggestion(key, f"{key}:", "", words)
        return
    if _is_node(place.path):
        kind = next((key for key in place.beside if key in known), None)
        if kind is None or is_all:
            for facts in known.values():
                yield Suggestion(
                    facts.kind, _indented(facts.template, place), facts.family, facts.text
                )
        if kind is not None:
            yield from _modifiers(known[kind], () if is_all else place.beside)
        return
    last = place.path[-1]
    if last in known:
        yield from (
            _of_field(facts)
            for facts in known[last].fields
            if facts.keys[0] == last
            and len(facts.keys) > 1
            and (is_all or facts.keys[1] not in place.beside)
        )
    if last == "outputs":
        node = next((key for key in place.around if key in known), "")
        yield from (Suggestion(name, f"{name}: ") for name in (known[node].results if node else ()))


def _modifiers(kind: KindFacts, taken: Sequence[str]) -> Iterator[Suggestion]:
    for facts in kind.fields:
        if len(facts.keys) == 1 and facts.keys[0] not in taken and facts.keys[0] != kind.kind:
            yield _of_field(facts)
    for key in kind.children:
        if key not in ("*", kind.kind, *taken):
            yield Suggestion(key, f"{key}:", "", "the node below")


def _indented(template: str, place: CursorContext) -> str:
    return template.replace("\n", "\n" + " " * place.column)


def _of_field(facts: FieldFacts) -> Suggestion:
    words = facts.words or facts.unit or (facts.type if facts.type != "yaml" else "")
    default = f"default: {facts.default}" if facts.default else ""
    text = ". ".join(filter(None, (facts.text, default)))
    return Suggestion(facts.keys[-1], f"{facts.keys[-1]}: ", words, text)


def _values(
    place: CursorContext, text: str, file: str | Path, folder: Path | None
) -> Iterator[Suggestion]:
    """Yield the values that fit."""
    key = place.key
    if not place.path and key in ("world", "robot"):
        names = files.names("worlds" if key == "world" else "robots")
        yield from (Suggestion(name, name, key) for name in names)
        return
    if key == "tree" or (key == "name" and place.path[-1:] == ["tree"]):
        yield from (Suggestion(name, name, "tree") for name in _entries(text, "trees"))
        return
    facts = _field_of(place)
    if facts is not None and facts.options:
        yield from (Suggestion(option, option) for option in facts.options)
        return
    if key in ("cancel_when", "until"):
        for kind in place.beside:
            for name in kinds()[kind].feedback if kind in kinds() else ():
                yield Suggestion(name, name, "feedback")
    if key in ("pose", "poses", "target"):
        yield from (Suggestion(name, name, "place") for name in _places(text, file, folder))
    yield from (Suggestion(name, name, "variable") for name in variables(text))
    yield from (Suggestion(name, f"{name}(", "function") for name in FUNCTIONS)


def _field_of(place: CursorContext) -> FieldFacts | None:
    if not place.path:
        return next((facts for facts in mission_fields() if facts.keys[0] == place.key), None)
    known = kinds()
    names = [*place.beside, place.key, place.path[-1]]
    for kind in (known[name] for name in names if name in known):
        for facts in kind.fields:
            if facts.keys in ((place.key,), (place.path[-1], place.key)):
                return facts
    return None


def variables(text: str) -> list[str]:
    """Return the names of inputs, outputs and variables that a text mentions."""
    names = dict.fromkeys(_entries(text, "inputs"))
    for inside in _NAMES.findall(text):
        for name, value in _PAIR.findall(inside):
            names[name] = None
            if value.isidentifier():
                names[value] = None
    return list(names)


def _entries(text: str, block: str) -> list[str]:
    """Return the keys directly below a key at the top."""
    head = re.search(rf"^{block}:[ ]*(\{{[^}}]*\}})?.*\n", text, re.MULTILINE)
    if head is None:
        return []
    if head[1]:
        return [name for name, _ in _PAIR.findall(head[1])]
    body = re.match(r"(?:[ ]+.*\n|[ ]*\n|#.*\n)*", text[head.end() :])
    match = re.findall(r"^( +)([\w-]+) *:", body.group() if body else "", re.MULTILINE)
    least = min((len(margin) for margin, _ in match), default=0)
    return [name for margin, name in match if len(margin) == least]


def _places(text: str, file: str | Path, folder: Path | None) -> Iterator[str]:
    yield from _entries(text, "places")
    world = re.search(r"^world: *(\S+)", text, re.MULTILINE)
    path = files.look_for("worlds", world[1], file or None) if world else None
    if path is None or (folder and not permissions(folder).allows(path, "worlds")):
        return
    with suppress(BtMissionError):
        yield from (zone.name for zone in load_world(path).zones)
