"""Faults as text: ``at 5.0: drop scan lasting 2``.

fault     = beginning ":" name argument* "may_not_happen"?
beginning = "at" time | "after" time | "when" condition ("for" time)?
argument  = value | name value | name "=" value | name         the last of a flag
value     = number unit? | word | text in quotes | "(" number ("," number)* ")"
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from typing import Any

from bt_mission.base.diagnostics import did_you_mean, listed, quoted
from bt_mission.base.units import UNITS
from bt_mission.language.expressions.parser import tokenized
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.requirements.language.formula import CONTROL_STEP_S, Condition
from bt_mission.requirements.language.parser import RequirementParser
from bt_mission.scenarios.faults.planned import (
    WORD,
    AfterStep,
    AtTime,
    Beginning,
    PlannedFault,
    WhenTrue,
)
from bt_mission.scenarios.faults.values import (
    TIME,
    ArgumentReader,
    Given,
    WrittenQuantity,
    argument_value,
)

EXAMPLE = "at 5.0: drop scan lasting 2"
MAX_LENGTH = 2_000
"""Characters of a fault."""

_TOKEN = re.compile(
    rf"""(?P<number>[-+]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[-+]?\.inf|\.nan)
      | (?P<text>'[^']*'|"(?:[^"\\]|\\.)*")
      | (?P<word>{WORD.pattern})
      | (?P<symbol>[=(),\[\]])
      | (?P<blank>\s+)""",
    re.VERBOSE,
)
_QUOTED = re.compile(r"""'[^']*'|"(?:[^"\\]|\\.)*"|(?P<colon>:)""")
_BEGINNINGS = ("at", "after", "when")


def parse_fault(text: str) -> PlannedFault:
    """Return the fault that a text describes. Raises ExpressionError, with the column."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            "BT-701", f"the fault has {len(text):,} characters, at most {MAX_LENGTH:,}"
        )
    word = re.match(r"\s*(\w*)", text)
    assert word is not None, "it matches the empty text"
    if word[1] not in _BEGINNINGS:
        near = did_you_mean(word[1], _BEGINNINGS)
        got = quoted(word[1]) if word[1] else "nothing"
        message = f"expected a fault such as '{EXAMPLE}', got {got} in place of at, after or when"
        raise ExpressionError("BT-701", message, word.start(1) + 1, near)
    colons = [match.start() for match in _QUOTED.finditer(text) if match["colon"]]
    if not colons:
        message = f"expected ':' between when a fault begins and what it is, as in '{EXAMPLE}'"
        raise ExpressionError("BT-701", message, len(text) + 1)
    begins = parse_beginning(text[: colons[-1]])
    return _Parser(text, colons[-1] + 1).fault(begins)


def parse_beginning(text: str) -> Beginning:
    """Return when a fault begins: ``at 5.0``. Raises ExpressionError, with the column."""
    word = re.match(r"\s*(\w+)\s*", text)
    assert word is not None, "the text begins with a word"
    if word[1] == "when":
        return _condition(text[word.end() :], word.end() + 1)
    time_s = _Parser(text, word.end()).time()
    return AtTime(time_s) if word[1] == "at" else AfterStep(time_s)


def _condition(text: str, column: int) -> WhenTrue:
    """Return a condition with the time that it has to be true for."""
    try:
        parser = RequirementParser(tokenized(text, symbols=":"))
        parser.either()
        token = parser.takes("for")
        held_s = _held(parser, token.column) if token else 0.0
        parser.end()
        end = token.column - 1 if token else len(text)
        return WhenTrue(Condition(text[:end].strip()), held_s)
    except ExpressionError as error:
        raise ExpressionError(
            error.code, error.message, error.column + column - 1, error.hint
        ) from None


def _held(parser: RequirementParser, column: int) -> float:
    held_s = parser.time()
    if held_s < CONTROL_STEP_S:
        message = f"{held_s:g} s is shorter than a control step of {CONTROL_STEP_S:g} s"
        raise ExpressionError("BT-703", message, column)
    return held_s


@dataclass(frozen=True)
class _Token:
    kind: str
    text: str
    column: int

    @property
    def shown(self) -> str:
        return quoted(self.text) if self.text else "the end"


class _Parser:
    """Reads the name of a fault and its arguments."""

    def __init__(self, text: str, start: int) -> None:
        self._tokens = list(_tokens(text, start))
        self._at = 0

    @property
    def _next(self) -> _Token:
        return self._tokens[self._at]

    def _take(self) -> _Token:
        token = self._next
        self._at += token.kind != "end"
        return token

    def _takes(self, kind: str, *texts: str) -> _Token | None:
        token = self._next
        return self._take() if token.kind == kind and (not texts or token.text in texts) else None

    def time(self) -> float:
        """Take a time, s, to the end of the text."""
        token = self._take()
        if token.kind != "number":
            message = f"expected a time such as '5.0', in seconds, got {token.shown}"
            raise ExpressionError("BT-701", message, token.column)
        time_s = argument_value(TIME, self._number(token, None, has_unit=True), token.column)
        if self._next.kind != "end":
            raise ExpressionError("BT-701", f"unexpected {self._next.shown}", self._next.column)
        assert isinstance(time_s, int | float), "it is a number"
        return float(time_s)

    def fault(self, begins: Beginning) -> PlannedFault:
        """Take the whole fault."""
        name = self._take()
        if name.kind != "word":
            raise ExpressionError(
                "BT-701", f"expected the name of a fault, got {name.shown}", name.column
            )
        reader = ArgumentReader(name.text, name.column)
        while self._next.kind != "end":
            self._argument(reader)
        return reader.planned(begins)

    def _argument(self, reader: ArgumentReader) -> None:
        """Take one argument: by its name, or by its position."""
        first, second = self._next, self._tokens[min(self._at + 1, len(self._tokens) - 1)]
        if first.kind == "word" and second.text == "=" and second.kind == "symbol":
            self._at += 2
            reader.by_name(first.text, self._value(reader, first.text), first.column)
        elif first.kind == "word" and reader.is_flag(first.text):
            self._take()
            value = self._takes("word", "true", "false")
            given = Given(value is None or value.text == "true", first.column)
            reader.by_name(first.text, given, first.column)
        elif self._is_name(first, second, reader):
            self._take()
            reader.by_name(first.text, self._value(reader, first.text), first.column)
        else:
            reader.by_position(self._value(reader, None))

    def _is_name(self, token: _Token, following: _Token, reader: ArgumentReader) -> bool:
        """Tell whether a word names an argument; it may be the text of one, too."""
        if token.kind != "word" or not reader.knows(token.text):
            return False
        if following.kind == "end" or (following.kind == "word" and reader.knows(following.text)):
            return not reader.is_next(token.text)
        return True

    def _value(self, reader: ArgumentReader, name: str | None) -> Given:
        token = self._take()
        if token.kind == "symbol" and token.text in "([":
            end = ")" if token.text == "(" else "]"
            return Given(self._items(end, reader), token.column)
        has_unit = reader.has_unit(name)
        return Given(self._scalar(token, reader, has_unit=has_unit), token.column)

    def _scalar(self, token: _Token, reader: ArgumentReader, *, has_unit: bool) -> Any:
        match token.kind:
            case "number":
                return self._number(token, reader, has_unit=has_unit)
            case "text":
                return _unquoted(token)
            case "word":
                return {"true": True, "false": False}.get(token.text, token.text)
        raise ExpressionError("BT-701", f"expected a value, got {token.shown}", token.column)

    def _number(
        self, token: _Token, reader: ArgumentReader | None, *, has_unit: bool
    ) -> int | float | WrittenQuantity:
        if token.text == ".nan":
            return math.nan  # always the same object, which is equal to itself in a mapping
        if token.text.endswith(".inf"):
            return float(token.text.replace(".", ""))
        is_whole = re.fullmatch(r"[-+]?[0-9]+", token.text) and len(token.text) < 20
        number = int(token.text) if is_whole else float(token.text)
        if not math.isfinite(number):
            raise ExpressionError("BT-304", f"{token.shown} is too large", token.column)
        unit = self._next
        after = self._tokens[min(self._at + 1, len(self._tokens) - 1)]
        is_name = after.text == "=" or (reader is not None and reader.knows(unit.text))
        is_unit = unit.text in UNITS or (has_unit and not is_name)
        if unit.kind != "word" or not is_unit:
            return number
        self._take()
        return WrittenQuantity(number, unit.text, unit.column)

    def _items(self, end: str, reader: ArgumentReader) -> tuple[Any, ...]:
        items: list[Any] = []
        while not self._takes("symbol", end):
            if items and not self._takes("symbol", ","):
                token = self._next
                raise ExpressionError(
                    "BT-701", f"expected ',' or '{end}', got {token.shown}", token.column
                )
            items.append(self._scalar(self._take(), reader, has_unit=True))
        return tuple(items)


def _tokens(text: str, start: int) -> list[_Token]:
    tokens = []
    at = start
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise ExpressionError("BT-701", f"unexpected {quoted(text[at])}", at + 1)
        assert match.lastgroup is not None, "every alternative has a name"
        if match.lastgroup != "blank":
            tokens.append(_Token(match.lastgroup, match[0], at + 1))
        at = match.end()
    return [*tokens, _Token("end", "", len(text) + 1)]


def _unquoted(token: _Token) -> str:
    if token.text.startswith("'"):
        return token.text[1:-1]
    try:
        return str(json.loads(token.text))
    except ValueError:
        message = f"expected a text in quotes, got {listed([token.text])}"
        raise ExpressionError("BT-701", message, token.column) from None
