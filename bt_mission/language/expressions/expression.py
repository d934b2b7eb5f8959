"""Expressions and templates: parsed once when a mission is loaded, evaluated without `eval`.

An `Expression` is a formula, "-sign($obstacle) * uniform(60, 120)"; a `Template` is a text with
values in it, "obstacle at ${obstacle} deg"; a `Text` may be either, and its ROS field decides.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from bt_mission.base.diagnostics import quoted
from bt_mission.language.expressions.parser import parse
from bt_mission.language.expressions.syntax import EvaluationScope, Name, SyntaxNode, Types
from bt_mission.language.expressions.units import UnitOfName, settled
from bt_mission.language.expressions.values import ExpressionError, Plain, Type, show

MAX_TEMPLATE = 10_000
"""Characters of a text with holes."""

_NOTHING: Mapping[str, Plain] = MappingProxyType({})
_HOLE = re.compile(r"\$(?:(?P<escaped>\$)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<open>\{))")
_FORMAT = re.compile(r"\+?0?[0-9]{0,2}(\.[0-9]{1,2})?[dfeg%]?")
_CLOSE = re.compile(r"""(?:[^'"}]|'[^']*'|"[^"]*")*\}""")


@dataclass(frozen=True)
class Expression:
    """A formula. Raises ExpressionError if its text is invalid.

    `references` are the names in the order of the text; `draws` is true if it uses random numbers.
    Two expressions of the same text are equal.
    """

    text: str
    root: SyntaxNode = field(init=False, repr=False, compare=False)
    references: tuple[Name, ...] = field(init=False, repr=False, compare=False)
    draws: bool = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        root, references, draws = parse(self.text)
        object.__setattr__(self, "root", root)
        object.__setattr__(self, "references", references)
        object.__setattr__(self, "draws", draws)

    @property
    def names(self) -> frozenset[str]:
        """The names it reads, without the `$`."""
        return frozenset(reference.name for reference in self.references)

    @property
    def variable(self) -> str | None:
        """The variable that it is, if it is nothing more."""
        return self.root.name if isinstance(self.root, Name) else None

    @classmethod
    def of(cls, text: str, root: SyntaxNode, like: Expression | None = None) -> Expression:
        """Return an expression with other parts than its text has alone.

        Args:
            text: As it is shown.
            root: Its parts.
            like: Has its names and its random numbers.
        """
        expression = replace(like) if like is not None else cls("0")
        object.__setattr__(expression, "text", text)
        object.__setattr__(expression, "root", root)
        return expression

    def in_unit(self, unit: str, of_name: UnitOfName = lambda _: "") -> Expression:
        """Return the expression with its quantities as numbers in the unit of a field.

        Raises:
            ExpressionError: Where units do not fit, as `settled` does.
        """
        root = settled(self.root, unit, of_name)
        return self if root is self.root else Expression.of(self.text, root, self)

    def evaluate(
        self, names: Mapping[str, Plain], rng: random.Random, fields: Mapping[str, Plain] = _NOTHING
    ) -> Plain:
        """Return the value for these variables. Raises ExpressionError.

        A bare name that is in `fields` (the feedback, in a `cancel_when`) is that field;
        `$name` always is the variable.
        """
        return self.root.evaluate(EvaluationScope(names, fields, rng))

    def infer(self, types: Types) -> Type | None:
        """Return the type, or None where it is not known. Raises ExpressionError on a clash."""
        return self.root.infer(types)


@dataclass(frozen=True)
class Hole:
    """An expression in a text, at an offset (from 0), and how its number is formatted, if it is."""

    offset: int
    expression: Expression
    format: str = ""

    @property
    def wanted(self) -> Type | None:
        """The type that it must have; None where every type will do."""
        if not self.format:
            return None
        return "integer" if self.format.endswith("d") else "number"

    def evaluate(self, names: Mapping[str, Plain], rng: random.Random) -> str:
        """Return the text that fills it. Raises ExpressionError."""
        with _errors_moved(self.offset):
            if self.wanted is None:
                return show(self.expression.evaluate(names, rng))
            value = self.expression.root.need(EvaluationScope(names, _NOTHING, rng), self.wanted)
            return f"{value:{self.format}}"


@dataclass(frozen=True)
class Template:
    """A text with holes: `$name`, `${expression}`, `${number:.2f}`; `$$` is a dollar sign."""

    text: str
    parts: tuple[str | Hole, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if "$" in self.text and len(self.text) > MAX_TEMPLATE:
            message = f"a text with '$' has {len(self.text):,} characters"
            raise ExpressionError("BT-409", f"{message}; the limit is {MAX_TEMPLATE:,}")
        object.__setattr__(self, "parts", tuple(_parts(self.text)))

    @property
    def holes(self) -> tuple[Hole, ...]:
        """The holes, the first one of those that are equal."""
        holes: dict[tuple[str, str], Hole] = {}
        for part in self.parts:
            if not isinstance(part, str):
                holes.setdefault((part.expression.text, part.format), part)
        return tuple(holes.values())

    @property
    def references(self) -> tuple[Name, ...]:
        """The names read, with columns in the whole text."""
        return tuple(
            Name(reference.column + hole.offset, reference.name, reference.variable)
            for hole in self.holes
            for reference in hole.expression.references
        )

    @property
    def draws(self) -> bool:
        """Whether it uses random numbers."""
        return any(hole.expression.draws for hole in self.holes)

    @property
    def names(self) -> frozenset[str]:
        """The names it reads, without the `$`."""
        return frozenset(reference.name for reference in self.references)

    def evaluate(self, names: Mapping[str, Plain], rng: random.Random) -> str:
        """Return the text with its holes filled. Raises ExpressionError."""
        return "".join(
            part if isinstance(part, str) else part.evaluate(names, rng) for part in self.parts
        )


@dataclass(frozen=True)
class Text:
    """A text in a goal: a template where the ROS field is a text, else an expression.

    Which one it is, only the type of the goal can say. A reading that is impossible is kept
    as its error, and raised where that reading turns out to be the wanted one.
    """

    text: str
    template: Template | ExpressionError = field(init=False, repr=False, compare=False)
    expression: Expression | ExpressionError = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for reading, kind in (("template", Template), ("expression", Expression)):
            try:
                object.__setattr__(self, reading, kind(self.text))
            except ExpressionError as error:
                # Without the frames that it came through, and all that these hold.
                object.__setattr__(self, reading, error.with_traceback(None))

    def in_unit(self, unit: str) -> Text:
        """Return the text with the quantities of its expression as numbers in a field's unit."""
        if isinstance(self.expression, ExpressionError):
            return self
        expression: Expression | ExpressionError
        try:
            expression = self.expression.in_unit(unit)
        except ExpressionError as error:
            expression = error.with_traceback(None)
        return self if expression is self.expression else self.reading(expression)

    def reading(self, expression: Expression | ExpressionError) -> Text:
        """Return the text with another reading as an expression."""
        copy = replace(self)
        object.__setattr__(copy, "expression", expression)
        return copy


@dataclass(frozen=True)
class Late:
    """A `Text` with its readings; the field decides which applies.

    No text draws random numbers in both readings: one with `${...}` is no expression.
    """

    text: Text
    names: Mapping[str, Plain]
    rng: random.Random

    def as_text(self) -> str:
        """Return the value for a text field. Raises ExpressionError."""
        if isinstance(self.text.template, ExpressionError):
            raise self.text.template
        return self.text.template.evaluate(self.names, self.rng)

    def as_value(self) -> Plain:
        """Return the value for any other field. Raises ExpressionError."""
        if isinstance(self.text.expression, ExpressionError):
            raise self.text.expression
        return self.text.expression.evaluate(self.names, self.rng)


Value = (
    bool | int | float | Expression | Template | Text | Sequence["Value"] | Mapping[str, "Value"]
)
"""A constant, or what is computed when it is needed."""


def resolve(value: Any, names: Mapping[str, Plain], rng: random.Random) -> Any:
    """Return a value with everything in it computed. Raises ExpressionError.

    A `Text` becomes a `Late`, which is evaluated as its field wants it.
    """
    match value:
        case Expression() | Template():
            return value.evaluate(names, rng)
        case Text():
            return Late(value, names, rng)
        case Mapping():
            return {key: resolve(part, names, rng) for key, part in value.items()}
        case list() | tuple():
            return [resolve(part, names, rng) for part in value]
    return value


def _formulas(value: Any) -> Iterator[Expression | Template]:
    """Yield what is computed in a value, nested parts and both readings of texts included."""
    match value:
        case Expression() | Template():
            yield value
        case Text():
            for reading in (value.template, value.expression):
                if not isinstance(reading, ExpressionError):
                    yield reading
        case Mapping():
            for part in value.values():
                yield from _formulas(part)
        case list() | tuple():
            for part in value:
                yield from _formulas(part)


def draws(value: Any) -> bool:
    """Return whether a value, nested parts included, uses random numbers."""
    if isinstance(value, Expression):
        return value.draws
    return any(formula.draws for formula in _formulas(value))


def names_in(value: Any) -> frozenset[str]:
    """Return the variables that a value may read, nested parts included."""
    return frozenset().union(*(formula.names for formula in _formulas(value)))


def written_text(value: Any) -> str:
    """Return a value as its author wrote it."""
    match value:
        case Expression() | Template() | Text():
            return value.text
        case Mapping():
            parts = (f"{name}: {written_text(part)}" for name, part in value.items())
            return f"{{{', '.join(parts)}}}"
        case list() | tuple():
            return f"[{', '.join(written_text(part) for part in value)}]"
    return show(value)


def _parts(text: str) -> list[str | Hole]:
    parts: list[str | Hole] = []
    at = 0
    while (dollar := text.find("$", at)) >= 0:
        parts.append(text[at:dollar])
        hole = _HOLE.match(text, dollar)
        if hole is None:
            hint = "write '$$' for a dollar sign"
            raise ExpressionError("BT-407", "expected a name or '{' after '$'", dollar + 1, hint)
        at = hole.end()
        if hole["escaped"]:
            parts.append("$")
        elif hole["name"]:
            parts.append(Hole(dollar, _expression(hole.group())))
        else:
            close = _CLOSE.match(text, at)
            if close is None:
                raise ExpressionError("BT-407", "this '${' is never closed with '}'", dollar + 1)
            with _errors_moved(at):
                parts.append(_hole(at, text[at : close.end() - 1]))
            at = close.end()
    parts.append(text[at:])
    return [part for part in parts if part != ""]


def _hole(at: int, text: str) -> Hole:
    """Return the hole of a text such as `x + 1` or `x:.2f`; quoted texts may have a colon, too."""
    colon = text.rfind(":")
    if colon < 0 or "'" in text[colon:] or '"' in text[colon:]:
        return Hole(at, _expression(text))
    form = text[colon + 1 :].strip()
    if not form or not _FORMAT.fullmatch(form):
        message = f"expected a number format such as '.2f' behind ':', got {quoted(form)}"
        raise ExpressionError(
            "BT-407", message, colon + 2, "'.2f' gives two decimals, '03d' three digits"
        )
    return Hole(at, _expression(text[:colon]), form)


@contextmanager
def _errors_moved(offset: int) -> Iterator[None]:
    """Let columns of errors count in the whole text, where an expression begins at an offset."""
    try:
        yield
    except ExpressionError as error:
        raise ExpressionError(
            error.code, error.message, error.column + offset, error.hint
        ) from None


def _expression(text: str) -> Expression:
    """Return the expression of a hole, its quantities as plain numbers."""
    return Expression(text).in_unit("")
