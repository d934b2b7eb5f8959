"""From a formula to the operators that evaluate it while a mission runs."""

from __future__ import annotations

from typing_extensions import override

from bt_mission.language.expressions.syntax import (
    Logic,
    Not,
    SyntaxNode,
)
from bt_mission.language.requirements.formula import filling, full_after, walk
from bt_mission.language.requirements.syntax import (
    FUTURE,
    Chain,
    Edge,
    Measure,
    Temporal,
)
from bt_mission.language.requirements.syntax import TimeWindow as WrittenWindow
from bt_mission.requirements.comparisons import ComparisonCompiler, values_in
from bt_mission.requirements.looking_ahead import Ahead, Future, LateCombined, Present, Until
from bt_mission.requirements.looking_back import (
    Atom,
    Combinator,
    Combined,
    EdgeOf,
    Ever,
    Filled,
    Historically,
    Joint,
    Past,
    Since,
)
from bt_mission.requirements.measures import MEASURED_VALUES, Measured, MeasuredValue
from bt_mission.requirements.roots import Root, RootJoint, Throughout, Up
from bt_mission.requirements.sparing_roots import Answered, Kept, Steady


class Compiler(ComparisonCompiler):
    """Builds the operators of formulas."""

    def root(self, node: SyntaxNode, *, positive: bool = True) -> Root:
        """Return a formula at the start of a run, or what it is where it does not hold."""
        match node:
            case Not(operand=operand):
                return self.root(operand, positive=not positive)
            case Logic(symbol=symbol, left=left, right=right):
                parts = [self.root(part, positive=positive) for part in (left, right)]
                return RootJoint(parts, all_of=(symbol == "and") is positive)
            case Temporal(word=word, operand=operand, window=window):
                all_of = (word == "always") is positive
                return self._throughout(operand, window, all_of=all_of, positive=positive)
            case Chain(left=left, right=right, window=window):
                first, second = (self._future(part, positive=positive) for part in (left, right))
                return Up(first, second, *_ns(window), dual=not positive)
        raise AssertionError("a formula was checked to speak of more than the start")

    def condition(self, node: SyntaxNode) -> Past:
        """Return a condition on the present and what was before."""
        return self._past(node, positive=True)

    def _throughout(
        self, operand: SyntaxNode, window: WrittenWindow, *, all_of: bool, positive: bool
    ) -> Root:
        """Return `always` or `eventually`, with what looks ahead turned round where it can be.

        A window ahead of each instant is one behind each later instant: so a violation is seen
        when it happens, and not when the window is over.
        """
        if all_of and window.is_everything:
            parts = _parts(operand, "and", positive=positive)
            has_value = not full_after(operand)  # where a part has none, neither has the whole
            if len(parts) > 1 and has_value and any(_looks_ahead(part) for part, _ in parts):
                roots = [
                    self._throughout(part, window, all_of=True, positive=sign)
                    for part, sign in parts
                ]
                return RootJoint(roots, all_of=True)
            answered = self._answered(operand, positive=positive)
            if answered is not None:
                return answered
        future = self._future(operand, positive=positive)
        if isinstance(future, Present):
            if isinstance(future.past, Atom):
                return Steady(future.past, *_ns(window), all_of=all_of)
            if all_of:
                return Kept(future.past, *_ns(window))
        return Throughout(future, *_ns(window), all_of=all_of)

    def _answered(self, operand: SyntaxNode, *, positive: bool) -> Root | None:
        """Return `always` of `x or eventually[a,b] y`, and of `x or always[0,b] y`.

        The latter is `historically[0,b] x or y`. None for another formula.
        """
        parts = _parts(operand, "or", positive=positive)
        ahead = [part for part in parts if _looks_ahead(part[0])]
        if len(ahead) != 1 or len(parts) == 1:
            return None
        node, sign = ahead[0]
        if not isinstance(node, Temporal) or _looks_ahead(node.operand):
            return None
        start, end = _ns(node.window)
        assert end is not None, "a window inside another formula was checked to end"
        is_always = (node.word == "always") is sign
        if node.word not in FUTURE or (is_always and start > 0):
            return None
        rest = [self._past(part, positive=sign) for part, sign in parts if (part, sign) != ahead[0]]
        answer = self._past(node.operand, positive=sign)
        if not is_always:
            return Answered(rest, answer, (start, end))
        either = Combined(rest, Joint(all_of=False))
        before = Combined([either], Historically((start, end), all_of=True))
        return Kept(Combined([before, answer], Joint(all_of=False)), 0, None)

    def _future(self, node: SyntaxNode, *, positive: bool) -> Future:
        if not _looks_ahead(node):
            return Present(self._past(node, positive=positive))
        match node:
            case Not(operand=operand):
                return self._future(operand, positive=not positive)
            case Temporal(word=word) | Chain(symbol=word) if word not in FUTURE:
                return self._late(node, positive=positive)
            case Logic():
                return self._late(node, positive=positive)
            case Temporal(word=word, operand=operand, window=window):
                start, end = _ns(window)
                assert end is not None, "a window inside another formula was checked to end"
                inner = self._future(operand, positive=positive)
                return Ahead(inner, start, end, all_of=(word == "always") is positive)
            case Chain(left=left, right=right, window=window):
                start, end = _ns(window)
                assert end is not None, "a window inside another formula was checked to end"
                first, second = (self._future(part, positive=positive) for part in (left, right))
                return Until(first, second, start, end, dual=not positive)
        raise AssertionError("what looks ahead is one of these")

    def _late(self, node: SyntaxNode, *, positive: bool) -> Future:
        parts = [self._future(part, positive=positive) for part in node.parts]
        return LateCombined(parts, _combinator(node, positive=positive))

    @override
    def atom(self, node: SyntaxNode, *, positive: bool) -> Past:
        """Return a condition without words of time, or its negation; measures may be in it."""
        measures = [one for one in values_in(node) if isinstance(one, Measure)]
        made: dict[str, MeasuredValue] = {}
        for one in measures:
            self._add_measure(one, made)
        condition = super().atom(node, positive=positive)
        if not made:
            return condition
        inner = [one for one in walk(node) if isinstance(one, Measure)]
        moves = any(one.word in ("mean", "rate") or one.window.is_bounded for one in inner)
        assert isinstance(condition, Atom)
        return Measured(condition, tuple(made.values()), moves=moves)

    def _add_measure(self, node: Measure, made: dict[str, MeasuredValue]) -> None:
        """Make a measure, and those inside it before, and have it read by its key."""
        if node.key in made:
            return
        operand, edge = node.operand, None
        for one in values_in(operand) if operand is not None else ():
            if isinstance(one, Measure):
                self._add_measure(one, made)
        if node.edge is not None:
            edge = self._past(node.edge, positive=True)
        _, window_ns = _ns(node.window)
        read = self.reader_of(operand) if operand is not None else lambda: None
        kind = MEASURED_VALUES[node.word]
        full_ns = round(full_after(node) * 1e9) if filling(node) else 0
        made[node.key] = kind(read, edge, window_ns, full_ns)
        self.readers = {**self.readers, node.key: made[node.key].read}

    def _past(self, node: SyntaxNode, *, positive: bool) -> Past:
        match node:
            case Edge(word=word, operand=operand):
                edge = EdgeOf(ends=word == "ends", positive=positive)
                return Combined([self._past(operand, positive=True)], edge)
            case Not(operand=operand):
                return self._past(operand, positive=not positive)
            case Temporal(word=word, operand=operand, window=window) if window.is_everything:
                inner = self._past(operand, positive=positive)
                return Ever(inner, all_of=(word == "historically") is positive)
            case Logic() | Temporal() | Chain():
                parts = [self._past(part, positive=positive) for part in node.parts]
                return Combined(parts, _combinator(node, positive=positive))
        return self.atom(node, positive=positive)


def _combinator(node: SyntaxNode, *, positive: bool) -> Combinator:
    """Return what `and`, `or`, and the words that look back, make of the values of their parts."""
    match node:
        case Logic(symbol=symbol):
            return Joint(all_of=(symbol == "and") is positive)
        case Temporal(word=word, window=window):
            past: Combinator
            past = Historically(_ns(window), all_of=(word == "historically") is positive)
        case Chain(window=window):
            past = Since(_ns(window), dual=not positive)
        case _:
            raise AssertionError("what joins formulas is one of these")
    return Filled(past, round(full_after(node) * 1e9)) if filling(node) else past


def _ns(window: WrittenWindow) -> tuple[int, int | None]:
    return round(window.start * 1e9), round(window.end * 1e9) if window.is_bounded else None


def _looks_ahead(node: SyntaxNode) -> bool:
    return any(
        (isinstance(part, Temporal) and part.word in FUTURE)
        or (isinstance(part, Chain) and part.symbol in FUTURE)
        for part in walk(node)
    )


def _parts(node: SyntaxNode, symbol: str, *, positive: bool) -> list[tuple[SyntaxNode, bool]]:
    """Return the parts of an `and` or `or`, each with whether it holds or its negation does."""
    match node:
        case Not(operand=operand):
            return _parts(operand, symbol, positive=not positive)
        case Logic(symbol=found, left=left, right=right) if (found == symbol) is positive:
            return [
                *_parts(left, symbol, positive=positive),
                *_parts(right, symbol, positive=positive),
            ]
    return [(node, positive)]
