"""Expressions of missions as scripts of BehaviorTree.CPP and back, where both mean the same.

Both have numbers, texts in single quotes, names, `+ - * /`, comparisons and logic. In a script
`!` takes only what stands directly behind it, and `&&` and `||` are read from left to right
without one coming first; so both together need parentheses.
"""

from __future__ import annotations

import re
from typing import Any

from bt_mission.base.diagnostics import quoted
from bt_mission.commands.convert.attributes import (
    GLOBAL,
    Codec,
    LocatedValue,
    MisreadError,
    located,
    mapping,
)
from bt_mission.commands.convert.elements import Attribute
from bt_mission.language.expressions.expression import Expression
from bt_mission.language.expressions.parser import RESERVED, Token
from bt_mission.language.expressions.units import quantities
from bt_mission.language.expressions.values import ExpressionError

_TOKEN = re.compile(
    r"""(?P<number>(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][-+]?[0-9]+)?(?![\w.]))
      | (?P<text>'[^']*')
      | (?P<name>[A-Za-z_][A-Za-z0-9_]*)
      | (?P<symbol>&&|\|\||<=|>=|==|!=|[-+*/<>()!])
      | (?P<blank>\s+)""",
    re.VERBOSE,
)
_ASSIGNMENT = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)\s*(:=|\+=|-=|\*=|/=|=(?!=))\s*")
_STATEMENT = re.compile(r"(?:'[^']*'|[^';])*")
_LITERAL = re.compile(r"-?[0-9]+(\.[0-9]+)?([eE][-+]?[0-9]+)?")
_OURS = {"&&": "and", "||": "or", "!": "not "}
_THEIRS = {"and": "&&", "or": "||", "not": "!"}
_VALUES = frozenset(("true", "false"))
_BEFORE_SIGN = frozenset(("(", "&&", "||", "<", "<=", ">", ">=", "==", "!=", "+", "-", "*", "/"))
_LARGEST = 2**63 - 1


class ScriptError(ExpressionError):
    """A script without an equivalent expression."""


def from_script(code: str) -> str:
    """Return a script as an expression. Raises ScriptError where ours has none."""
    tokens = _tokens(code)
    _refuse_ambiguity([token for token in tokens if token.kind != "blank"])
    text, is_open = "", False
    for token in tokens:
        if token.kind == "name" and token.text in RESERVED - _VALUES:
            message = (
                f"'{token.text}' is a keyword of mission expressions, so it cannot be a variable"
            )
            raise ScriptError("BT-1206", message, token.column, "rename the variable")
        if token.kind == "blank":
            text += " " * len(token.text)
            continue
        if (is_open or token.text in _OURS) and text and text[-1] not in " (":
            text += " "
        text += _OURS.get(token.text, token.text)
        is_open = token.text in ("&&", "||")
    text = text.strip()
    try:
        expression = Expression(text)
    except ExpressionError as error:
        raise ScriptError(error.code, error.message, 1, error.hint) from None
    if any(quantities(expression.root)):
        raise ScriptError(
            "BT-1206", "scripts have no units", 1, "convert the number to metres or seconds"
        )
    return text


def to_script(text: str) -> str | None:
    """Return an expression as a script that comes back as the same text, or None."""
    script = ""
    skip = False
    for match in re.finditer(r"'[^']*'|[A-Za-z_][A-Za-z0-9_]*|.", text, re.DOTALL):
        piece = match.group()
        if skip and piece != " ":
            return None
        if not skip:
            script += _THEIRS.get(piece, piece)
        skip = piece == "not"
    try:
        return script if from_script(script) == text else None
    except ScriptError:
        return None


def _literal(text: str) -> Any:
    """Return what a variable is set to: a constant, or the text of an expression."""
    if text in _VALUES:
        return text == "true"
    if _LITERAL.fullmatch(text):
        return int(text) if text.lstrip("-").isdigit() else float(text)
    return from_script(text)


def assignments(code: str) -> list[tuple[str, int, Any]]:
    """Return the variables that a script sets: name, column, value. Raises ScriptError."""
    assignments: list[tuple[str, int, Any]] = []
    at = 0
    while at <= len(code):
        statement = _STATEMENT.match(code, at)
        assert statement is not None, "the pattern takes an empty text"
        if code[statement.end() : statement.end() + 1] == "'":
            raise ScriptError("BT-1206", "this quoted text is never closed", statement.end() + 1)
        if statement.group().strip():
            assignments.append(
                _assignment(statement.group(), at, {name for name, _, _ in assignments})
            )
        at = statement.end() + 1
    return assignments


def written_assignments(values: dict[str, Any]) -> str | None:
    """Return a script that sets variables to these values, or None if no script can."""
    statements = []
    for name, value in values.items():
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        right = repr(value) if is_number else _written_condition(value)
        if right is None:
            return None
        statements.append(f"{name} := {right}")
    script = "; ".join(statements)
    try:
        back = [(name, type(value), value) for name, _, value in assignments(script)]
    except ScriptError:
        return None
    return script if back == [(key, type(value), value) for key, value in values.items()] else None


def _read_condition(attribute: Attribute) -> LocatedValue:
    code = attribute.value.lstrip()
    try:
        return located(_literal(code.rstrip()), attribute.value_at)
    except ScriptError as error:
        at = attribute.within(len(attribute.value) - len(code) + error.column - 1)
        raise MisreadError((error.code, at, error.message, error.hint)) from None


def _written_condition(condition: Any) -> str | None:
    if isinstance(condition, bool):
        return "true" if condition else "false"
    code = to_script(condition) if isinstance(condition, str) else None
    return code if code is not None and _literal(code) == condition else None


def _read_assignments(attribute: Attribute) -> LocatedValue:
    try:
        values = assignments(attribute.value)
    except ScriptError as error:
        at = attribute.within(error.column - 1)
        raise MisreadError((error.code, at, error.message, error.hint)) from None
    if not values:
        raise MisreadError(
            ("BT-1206", attribute.value_at, "expected 'name := value', got nothing", None)
        )
    return mapping(
        attribute.value_at,
        (
            (name, attribute.within(column - 1), located(value, attribute.value_at))
            for name, column, value in values
        ),
    )


CONDITION = Codec(_read_condition, _written_condition)
ASSIGNMENTS = Codec(_read_assignments, written_assignments)


def _assignment(statement: str, offset: int, taken: set[str]) -> tuple[str, int, Any]:
    match = _ASSIGNMENT.match(statement)
    if match is None:
        start = offset + len(statement) - len(statement.lstrip()) + 1
        message = f"expected 'name := value', got {quoted(statement.strip())}"
        hint = GLOBAL if statement.lstrip().startswith("@") else None
        raise ScriptError("BT-1206", message, start, hint)
    name, sign, right = match[1], match[2], statement[match.end() :]
    column = offset + match.start(1) + 1
    if name in taken:
        hint = "write a second Script"
        raise ScriptError("BT-1206", f"'{name}' is set twice in one Script", column, hint)
    try:
        if len(sign) == 2 and sign != ":=":
            return name, column, f"{name} {sign[0]} ({from_script(right.strip())})"
        return name, column, _literal(right.strip())
    except ScriptError as error:
        at = offset + match.end() + error.column
        raise ScriptError(error.code, error.message, at, error.hint) from None


def _tokens(code: str) -> list[Token]:
    tokens: list[Token] = []
    at = 0
    while at < len(code):
        match = _TOKEN.match(code, at)
        if match is None:
            message = f"{quoted(code[at])} has no counterpart in mission expressions"
            hint = GLOBAL if code[at] == "@" else "use a leaf 'check' or 'set'"
            raise ScriptError("BT-1206", message, at + 1, hint)
        kind = match.lastgroup or ""
        if kind == "number" and match.group().isdigit() and int(match.group()) > _LARGEST:
            raise ScriptError("BT-304", f"the number {quoted(match.group())} is too large", at + 1)
        tokens.append(Token(kind, match.group(), at + 1))
        at = match.end()
    return tokens


def _refuse_ambiguity(tokens: list[Token]) -> None:
    """Refuse what BehaviorTree.CPP and Python read differently."""
    texts = ["", *(token.text for token in tokens), "", ""]
    logic = [""]
    for index, token in enumerate(tokens):
        before, behind = texts[index], texts[index + 2]
        if token.text == "(":
            logic.append("")
        elif token.text == ")" and len(logic) > 1:
            logic.pop()
        elif token.text in ("&&", "||"):
            if logic[-1] not in ("", token.text):
                message = (
                    "scripts evaluate '&&' and '||' from left to right, missions by precedence"
                )
                raise ScriptError(
                    "BT-1206", message, token.column, "put one of them in parentheses"
                )
            logic[-1] = token.text
        elif token.text == "!":
            _refuse_loose_not(texts[index + 2 :], token.column)
        elif token.text in ("*", "/") and before == token.text:
            raise ScriptError(
                "BT-1206", f"'{token.text * 2}' is not an operator of scripts", token.column
            )
        elif token.text in ("-", "+") and (not before or before in _BEFORE_SIGN):
            is_operand = behind == "(" or behind[:1].isalnum() or behind[:1] == "_"
            if token.text == "+" or not is_operand:
                raise ScriptError("BT-1206", f"unexpected '{token.text}'", token.column)


def _refuse_loose_not(behind: list[str], column: int) -> None:
    """Refuse a `!` whose operand does not end with a name or a closed parenthesis."""
    at, depth = 0, {"(": 1}.get(behind[0], 0)
    while depth > 0 and at + 1 < len(behind):
        at += 1
        depth += {"(": 1, ")": -1}.get(behind[at], 0)
    if not behind[0] or behind[at + 1 : at + 2] not in ([], [""], [")"], ["&&"], ["||"]):
        message = (
            "in scripts '!' applies to the next name only, in missions 'not' applies to the rest"
        )
        raise ScriptError("BT-1206", message, column, "use parentheses")
