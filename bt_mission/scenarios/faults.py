"""The faults and obstacles of a scenario file, as text or as mappings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from bt_mission.core.diagnostics import Diagnostic, describe, listed
from bt_mission.core.yaml.document import Document, Key
from bt_mission.faults.located import WrittenFault
from bt_mission.faults.planned import AfterStep, AtTime, Beginning
from bt_mission.faults.text import EXAMPLE, parse_beginning, parse_fault
from bt_mission.faults.values import ArgumentReader, Given, read_time
from bt_mission.language.expressions.values import ExpressionError

Path = tuple[Key, ...]
BEGINNINGS = ("at", "after", "when")
_OTHERS = ("lasting",)


class FaultReader:
    """Reads faults and obstacles, and collects what is wrong with all."""

    def __init__(self, document: Document) -> None:
        self.faults: list[WrittenFault] = []
        self.wrong: list[Diagnostic] = []
        self._document = document

    def obstacle(self, written: Any, path: Path) -> None:
        """Take a box, or a cylinder where it has a radius; it is there from the start."""
        if not isinstance(written, Mapping):
            example = "'at: [1.0, 0.5]' and 'size: [0.2, 0.2, 0.3]'"
            self._note(path, f"expected a mapping such as {example}, got {describe(written)}")
            return
        name = "spawn_cylinder" if "radius" in written else "spawn_box"
        self._add(path, AtTime(0.0), name, lambda reader: self._by_name(reader, written, path))

    def fault(self, written: Any, path: Path) -> None:
        """Take a fault."""
        match written:
            case str():
                self._text(written, path)
            case Mapping():
                text = _as_text(written)
                if text:
                    self._text(text, path)
                else:
                    self._mapping(written, path)
            case _:
                self._note(path, f"expected a fault such as '{EXAMPLE}', got {describe(written)}")

    # ---- text ----------------------------------------------------------------------------

    def _text(self, text: str, path: Path) -> None:
        document = self._document

        def locate(message: str, hint: str | None, part: str, offset: int) -> Diagnostic:
            return document.fault(path, message, hint, offset=max(text.find(part), 0) + offset)

        try:
            self.faults.append(WrittenFault(parse_fault(text), locate))
        except ExpressionError as error:
            offset = error.column - 1
            self.wrong.append(document.fault(path, error.message, error.hint, offset=offset))

    # ---- mappings ------------------------------------------------------------------------

    def _mapping(self, written: Mapping[str, Any], path: Path) -> None:
        found = [key for key in BEGINNINGS if key in written]
        names = [key for key in written if key not in (*BEGINNINGS, *_OTHERS)]
        if len(found) != 1 or len(names) != 1:
            got = listed(written)
            what = f"one of {', '.join(BEGINNINGS)}, and one fault, such as"
            self._note(path, f"expected {what} '{{at: 5.0, drop: scan, lasting: 2}}', got {got}")
            return
        begins = self._beginning(found[0], written[found[0]], (*path, found[0]))
        if begins is not None:
            name = names[0]
            self._add(path, begins, name, lambda reader: self._arguments(reader, written, path))

    def _beginning(self, word: str, written: Any, path: Path) -> Beginning | None:
        start = len(word) + 1
        try:
            if word == "when":
                return parse_beginning(f"when {written}")
            time_s = read_time(written)
            return AtTime(time_s) if word == "at" else AfterStep(time_s)
        except ExpressionError as error:
            offset = max(error.column - 1 - (start if word == "when" else 0), 0)
            self.wrong.append(self._document.fault(path, error.message, error.hint, offset=offset))
            return None

    def _arguments(self, reader: ArgumentReader, written: Mapping[str, Any], path: Path) -> None:
        """Take the arguments of a fault: a mapping, a list in their order, or the first alone."""
        name = reader.name
        match written[name]:
            case None:
                pass
            case Mapping() as arguments:
                self._by_name(reader, arguments, (*path, name))
            case list() as values:
                for number, value in enumerate(values):
                    self._located((*path, name, number), partial(reader.by_position, Given(value)))
            case value:
                self._located((*path, name), partial(reader.by_position, Given(value)))
        if "lasting" in written:
            self._by_name(reader, {"lasting": written["lasting"]}, path)

    def _by_name(self, reader: ArgumentReader, given: Mapping[str, Any], path: Path) -> None:
        for name, value in given.items():
            self._located(
                (*path, name),
                partial(reader.by_name, name, Given(value), 1),
                key=not reader.takes(name),
            )

    def _add(
        self, path: Path, begins: Beginning, name: str, take: Callable[[ArgumentReader], None]
    ) -> None:
        document = self._document

        def locate(message: str, hint: str | None, part: str, _: int) -> Diagnostic:
            for key, value in _parts(document, path):
                if part and value == part:
                    return document.fault((*path, *key), message, hint)
            return document.fault(path, message, hint)

        count = len(self.wrong)
        try:
            reader = ArgumentReader(name)
            take(reader)
            if len(self.wrong) == count:
                self.faults.append(WrittenFault(reader.planned(begins), locate))
        except ExpressionError as error:
            is_key = name in (document.find(path).keys or {})
            where = (*path, name) if is_key else path
            self.wrong.append(document.fault(where, error.message, error.hint, key=is_key))

    def _located(self, path: Path, take: Callable[[], None], *, key: bool = False) -> None:
        try:
            take()
        except ExpressionError as error:
            self.wrong.append(self._document.fault(path, error.message, error.hint, key=key))

    def _note(self, path: Path, message: str) -> None:
        self.wrong.append(self._document.fault(path, message))


def _as_text(written: Mapping[str, Any]) -> str:
    """Return the text that other readers of YAML take for a mapping; empty for a mapping."""
    for key, value in written.items() if len(written) == 1 else ():
        if isinstance(value, str) and " " in key and key.split(" ")[0] in BEGINNINGS:
            return f"{key}: {value}"
    return ""


def _parts(document: Document, path: Path) -> list[tuple[Path, Any]]:
    """Return the values in the mapping of a fault, each with the path to it."""
    data: Any = document.data
    for key in path:
        data = data[key]
    found: list[tuple[Path, Any]] = []
    for key, value in data.items():
        found.append(((key,), value))
        if isinstance(value, Mapping):
            found += [((key, name), one) for name, one in value.items()]
        elif isinstance(value, list):
            found += [((key, number), one) for number, one in enumerate(value)]
    return found
