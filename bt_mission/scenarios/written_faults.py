"""The faults of a scenario file, which are texts, and its obstacles, which are mappings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, describe
from bt_mission.base.yaml.document import Document, Key
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.scenarios.faults.planned import AtTime, PlannedFault
from bt_mission.scenarios.faults.text import EXAMPLE, parse_fault
from bt_mission.scenarios.faults.values import ArgumentReader, Given

Path = tuple[Key, ...]
BEGINNINGS = ("at", "after", "when")


class FaultReader:
    """Reads faults and obstacles, and collects what is wrong with all."""

    def __init__(self, document: Document) -> None:
        self.faults: list[PlannedFault] = []
        self.wrong: list[Diagnostic] = []
        self._document = document

    def obstacle(self, written: Any, path: Path) -> None:
        """Take a box, or a cylinder where it has a radius; it is there from the start."""
        if not isinstance(written, Mapping):
            example = "'at: [1.0, 0.5]' and 'size: [0.2, 0.2, 0.3]'"
            self._note(
                "BT-703", path, f"expected a mapping such as {example}, got {describe(written)}"
            )
            return
        document = self._document

        def locate(code: str, message: str, hint: str | None, part: str, _: int) -> Diagnostic:
            for key, value in written.items():
                if part and value == part:
                    return document.diagnostic(code, (*path, key), message, hint)
            return document.diagnostic(code, path, message, hint)

        reader = ArgumentReader("spawn_cylinder" if "radius" in written else "spawn_box")
        wrong = []
        for name, value in written.items():
            try:
                reader.by_name(name, Given(value), 1)
            except ExpressionError as error:
                place, is_key = (*path, name), not reader.takes(name)
                wrong.append(
                    document.diagnostic(error.code, place, error.message, error.hint, key=is_key)
                )
        if not wrong:
            try:
                self.faults.append(replace(reader.planned(AtTime(0.0)), place=locate))
            except ExpressionError as error:
                wrong.append(document.diagnostic(error.code, path, error.message, error.hint))
        self.wrong += wrong

    def fault(self, written: Any, path: Path) -> None:
        """Take a fault."""
        key = _beginning_of(written) if isinstance(written, Mapping) else ""
        if key:
            self._text(f"{key}: {written[key]}", path, key)
        elif isinstance(written, str) and written:
            self._text(written, path)
        else:
            self._note(
                "BT-701", path, f"expected a fault such as '{EXAMPLE}', got {describe(written)}"
            )

    def _text(self, text: str, path: Path, key: str = "") -> None:
        """Take a text, which is a key and its value where it has no quotes."""
        document = self._document

        def at(code: str, offset: int, message: str, hint: str | None) -> Diagnostic:
            if not key:
                return document.diagnostic(code, path, message, hint, offset=offset)
            in_value = offset - len(f"{key}: ")
            if in_value < 0:
                return document.diagnostic(
                    code, (*path, key), message, hint, key=True, offset=offset
                )
            return document.diagnostic(code, (*path, key), message, hint, offset=in_value)

        def locate(code: str, message: str, hint: str | None, part: str, offset: int) -> Diagnostic:
            return at(code, max(text.find(part), 0) + offset, message, hint)

        try:
            self.faults.append(replace(parse_fault(text), place=locate))
        except ExpressionError as error:
            self.wrong.append(at(error.code, error.column - 1, error.message, error.hint))

    def _note(self, code: str, path: Path, message: str) -> None:
        self.wrong.append(self._document.diagnostic(code, path, message))


def _beginning_of(written: Mapping[str, Any]) -> str:
    """Return the key of a fault without quotes, such as `at 5.0`; empty for another mapping."""
    for key, value in written.items() if len(written) == 1 else ():
        if isinstance(value, str) and " " in key and key.split(" ")[0] in BEGINNINGS:
            return key
    return ""
