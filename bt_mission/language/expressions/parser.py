"""The grammar of expressions: from a text to its parts, by precedence climbing.

either      = any ("if" any "else" either)?
any         = both ("or" both)*
both        = inverted ("and" inverted)*
inverted    = "not" inverted | comparison
comparison  = sum (("<" | "<=" | ">" | ">=" | "==" | "!=") sum)*      chained as in Python
sum         = product (("+" | "-") product)*
product     = signed (("*" | "/" | "//" | "%") signed)*
signed      = ("-" | "+") signed | power
power       = element ("**" signed)?
element     = atom ("[" either "]")*
atom        = number unit? | text | "true" | "false" | "pi" | name | "$" name
            | function "(" either ("," either)* ")" | "(" either ")"
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from functools import lru_cache

from bt_mission.base.diagnostics import CUT, did_you_mean, listed, quoted
from bt_mission.base.units import COMPUTED, near_unit
from bt_mission.language.expressions import syntax
from bt_mission.language.expressions.functions import FUNCTIONS
from bt_mission.language.expressions.units import Quantity
from bt_mission.language.expressions.values import MAX_MAGNITUDE, ExpressionError, LooseText, Plain

MAX_LENGTH = 1_000
"""Characters of an expression."""

MAX_DEPTH = 32
"""Levels of parentheses, calls and signs, and operators in one chain."""

_TOKEN = re.compile(
    r"""(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)
      | (?P<text>'[^']*'|"[^"]*")
      | (?P<variable>\$[A-Za-z_][A-Za-z0-9_]*)
      | (?P<name>[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*)
      | (?P<symbol>\*\*|//|<=|>=|==|!=|&&|\|\||[-+*/%<>(),\[\]])
      | (?P<blank>[\ \n]+)""",
    re.VERBOSE,
)
_INSTEAD = {
    "&&": "and",
    "||": "or",
    "!": "not",
    "=": "==",
    "^": "**",
    "&": "and",
    "|": "or",
    "=>": ">=",
    "=<": "<=",
    "<>": "!=",
}
_CONSTANTS: dict[str, Plain] = {"true": True, "false": False, "pi": math.pi}
_LEVELS = {
    symbol: level
    for level, symbols in enumerate(("or", "and", "", "< <= > >= == !=", "+ -", "* / // %"))
    for symbol in symbols.split()
}
"""How tightly operators between two operands bind, from the loosest."""
_NOT, _COMPARISON = 2, 3
_KEYWORDS = ("and", "or", "not", "if", "else")
RESERVED = frozenset((*_CONSTANTS, *FUNCTIONS, *_KEYWORDS))
"""Names that cannot be variables."""


@dataclass(frozen=True)
class Token:
    """A piece of an expression: its kind, its text, its column (from 1)."""

    kind: str
    text: str
    column: int

    @property
    def end(self) -> int:
        """The column behind it."""
        return self.column + len(self.text)


Parsed = tuple[syntax.SyntaxNode, tuple[syntax.Name, ...], bool]


def parse(text: str) -> Parsed:
    """Return an expression's parts, the names in it, and whether it draws random numbers.

    Raises ExpressionError, with the column.
    """
    parsed_text = _tried(text)
    if isinstance(parsed_text, ExpressionError):
        raise type(parsed_text)(
            parsed_text.code, parsed_text.message, parsed_text.column, parsed_text.hint
        )
    return parsed_text


@lru_cache(maxsize=4096)
def _tried(text: str) -> Parsed | ExpressionError:
    """Return what `parse` returns or raises; errors are remembered, too."""
    try:
        return _parsed(text)
    except ExpressionError as error:
        return error.with_traceback(None)


def _parsed(text: str) -> Parsed:
    parser = ExpressionParser(tokenized(text))
    node = parser.either()
    parser.end()
    return node, tuple(parser.names), parser.draws


def tokenized(text: str, symbols: str = "") -> list[Token]:
    """Return the tokens of a text, the end as the last one; `symbols` are further characters.

    Raises ExpressionError, with the column.
    """
    if len(text) > MAX_LENGTH:
        message = f"the expression has {len(text):,} characters; the limit is {MAX_LENGTH:,}"
        raise ExpressionError("BT-409", message)
    if not text.strip():
        raise ExpressionError("BT-401", "the expression is empty")
    tokens = []
    at = 0
    while at < len(text):
        if text[at] in symbols and text[at : at + 2] not in (*_LEVELS, *_INSTEAD):
            tokens.append(Token("symbol", text[at], at + 1))
            at += 1
            continue
        match = _TOKEN.match(text, at)
        if match is None:
            raise _bad_character(text, at)
        kind = match.lastgroup or ""
        if match.group() in _INSTEAD or text[at : at + 2] in _INSTEAD:
            raise _bad_character(text, at)
        if kind != "blank":
            tokens.append(Token(kind, match.group(), at + 1))
        at = match.end()
    tokens.append(Token("end", "", len(text.rstrip()) + 1))
    return tokens


def _bad_character(text: str, at: int) -> ExpressionError:
    if text[at] in "'\"":
        return ExpressionError("BT-401", "this quote is never closed", at + 1)
    if text[at] == "$":
        return ExpressionError("BT-401", "expected a name after '$'", at + 1)
    symbol = text[at : at + 2] if text[at : at + 2] in _INSTEAD else text[at]
    instead = _INSTEAD.get(symbol)
    hint = f"write '{instead}'" if instead else None
    return ExpressionError("BT-401", f"unexpected token {quoted(symbol)}", at + 1, hint)


@dataclass
class ExpressionParser:
    """Takes tokens one after another; a larger grammar around expressions extends it."""

    tokens: list[Token]
    at: int = 0
    depth: int = 0
    names: list[syntax.Name] = field(default_factory=list)
    draws: bool = False

    @property
    def next(self) -> Token:
        """The token that comes next."""
        return self.tokens[self.at]

    def take(self) -> Token:
        """Take the next token."""
        token = self.tokens[self.at]
        self.at += 1
        return token

    def takes(self, *texts: str) -> Token | None:
        """Take the next token if it is one of these symbols or words."""
        token = self.next
        return self.take() if token.kind in ("symbol", "name") and token.text in texts else None

    def deeper(self) -> None:
        """Go one level deeper. Raises ExpressionError where that is too deep."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            message = f"the expression is nested too deeply; the limit is {MAX_DEPTH} levels"
            raise ExpressionError("BT-409", message, self.next.column)

    def end(self) -> None:
        """Refuse text after a complete formula."""
        token = self.next
        if token.kind != "end":
            message = f"expected an operator or the end, got {quoted(token.text)}"
            raise LooseText("BT-401", message, token.column, self.number_hint(token))

    def number_hint(self, token: Token) -> str | None:
        """Return the correct form of a number with a decimal comma or an unknown unit."""
        before = self.tokens[self.at - 1]
        if before.kind == "number" and token.kind == "name":
            return near_unit(token.text)
        if token.text != ",":
            return None
        after = self.tokens[self.at + 1]
        if before.kind != "number" or after.kind != "number":
            return None
        return f"decimals are written with a point: {before.text}.{after.text}"

    def either(self) -> syntax.SyntaxNode:
        """Parse a whole formula."""
        self.deeper()
        node = self.operation(0)
        if token := self.takes("if"):
            condition = self.operation(0)
            if not self.takes("else"):
                message = f"expected 'else' for the 'if' in {self._read_from(token)}"
                raise ExpressionError(
                    "BT-401", message, self.next.column, "write 'a if condition else b'"
                )
            node = syntax.Conditional(token.column, condition, node, self.either())
        self.depth -= 1
        return node

    def operation(self, least: int) -> syntax.SyntaxNode:
        """Parse operands with the operators between them that bind at least so tightly."""
        if least <= _NOT and (token := self.takes("not")):
            self.deeper()
            node: syntax.SyntaxNode = syntax.Not(token.column, self.operation(_NOT))
            self.depth -= 1
        else:
            node = self.signed()
        start, last = self.depth, -1
        while (level := _LEVELS.get(self.next.text, -1)) >= least:
            if level != last:
                self.depth, last = start, level
            if level == _COMPARISON:
                node = self.comparison(node)
                continue
            token = self.take()
            self.deeper()
            kind = syntax.Logic if level < _NOT else syntax.Arithmetic
            node = kind(token.column, token.text, node, self.operation(level + 1))
        self.depth = start
        return node

    def comparison(self, first: syntax.SyntaxNode) -> syntax.SyntaxNode:
        """Parse what a first side is compared with."""
        column = self.next.column
        rest = []
        while _LEVELS.get(self.next.text) == _COMPARISON:
            token = self.take()
            rest.append((token.text, token.column, self.operation(_COMPARISON + 1)))
        return syntax.Comparison(column, first, tuple(rest))

    def signed(self) -> syntax.SyntaxNode:
        """Parse a number with its signs."""
        token = self.takes("-", "+")
        if token is None:
            return self.power()
        self.deeper()
        node = syntax.Negation(token.column, self.signed(), -1 if token.text == "-" else 1)
        self.depth -= 1
        return node

    def power(self) -> syntax.SyntaxNode:
        """Parse an element, to the power of another."""
        base = self.atom()
        while opened := self.takes("["):
            base = syntax.Subscript(opened.column, base, self.either())
            self.close(opened, "]")
        token = self.takes("**")
        if token is None:
            return base
        self.deeper()
        node = syntax.Arithmetic(token.column, "**", base, self.signed())
        self.depth -= 1
        return node

    def atom(self) -> syntax.SyntaxNode:
        """Parse what has no parts outside of parentheses."""
        token = self.take()
        if token.kind == "number":
            return self.quantity(token)
        if token.kind == "text":
            return syntax.Constant(token.column, token.text[1:-1])
        if token.kind == "variable":
            return self.name(syntax.Name(token.column, token.text[1:], variable=True))
        if token.kind == "name" and token.text not in _KEYWORDS:
            if self.takes("("):
                return self.call(token)
            if token.text in _CONSTANTS:
                return syntax.Constant(token.column, _CONSTANTS[token.text])
            if token.text in FUNCTIONS:
                message = f"expected '(' after the function {token.text}"
                raise ExpressionError("BT-401", message, token.column + len(token.text))
            return self.name(syntax.Name(token.column, token.text, variable=False))
        if token.kind == "symbol" and token.text == "(":
            node = self.either()
            self.close(token)
            return node
        got = quoted(token.text) if token.text else "the end"
        message = f"expected a number, a name or a '(', got {got}"
        raise ExpressionError("BT-401", message, token.column)

    def quantity(self, token: Token) -> syntax.Constant:
        """Take the unit behind a number, if there is one."""
        number, unit = _number(token), self.next.text
        if unit not in COMPUTED or self.tokens[self.at + 1].text == "(":  # the function min
            return syntax.Constant(token.column, number)
        self.take()
        per_second = f"{unit}/s"
        if (
            per_second in COMPUTED
            and self.next.text == "/"
            and self.tokens[self.at + 1].text == "s"
        ):
            self.take()
            self.take()
            unit = per_second
        return Quantity.of(token.column, number, unit)

    def name(self, node: syntax.Name) -> syntax.SyntaxNode:
        """Return what a name stands for."""
        self.names.append(node)
        return node

    def close(self, opened: Token, closing: str = ")") -> None:
        """Take the parenthesis that closes another one."""
        if not self.takes(closing):
            message = f"expected '{closing}' for the '{opened.text}' in {self._read_from(opened)}"
            hint = CUT if self.next.kind == "end" else None
            raise ExpressionError("BT-401", message, self.next.column, hint)

    def _read_from(self, first: Token) -> str:
        """Return the text that was read from a token on, with the name directly before it."""
        start = self.tokens.index(first)
        before = self.tokens[start - 1]
        if start and before.kind in ("name", "variable") and before.end == first.column:
            start -= 1
        text = ""
        for token in self.tokens[start : self.at]:
            text = text.ljust(token.column - self.tokens[start].column) + token.text
        return quoted(text)

    def call(self, token: Token) -> syntax.SyntaxNode:
        """Parse the call of a function."""
        function = FUNCTIONS.get(token.text)
        if function is None:
            message = f"unknown function {quoted(token.text)} (known: {listed(FUNCTIONS)})"
            raise ExpressionError(
                "BT-405", message, token.column, did_you_mean(token.text, FUNCTIONS)
            )
        opened = self.tokens[self.at - 1]
        arguments = []
        if not self.takes(")"):
            arguments.append(self.either())
            while self.takes(","):
                arguments.append(self.either())
            self.close(opened)
        if not function.least <= len(arguments) <= function.most:
            message = f"expected {function.usage}, got {len(arguments)} arguments"
            raise ExpressionError("BT-405", message, token.column)
        self.draws = self.draws or function.random
        return syntax.FunctionCall(token.column, token.text, tuple(arguments), function.random)


def _number(token: Token) -> float:
    whole = token.text.isdigit()
    number: float = int(token.text) if whole else float(token.text)
    if abs(number) > MAX_MAGNITUDE and (whole or math.isinf(number)):
        raise ExpressionError(
            "BT-304", f"the number {quoted(token.text)} is too large", token.column
        )
    return number
