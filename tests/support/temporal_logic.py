"""Signal temporal logic by its definition: slow, over a whole run, sample by sample.

Quantitative semantics of Donzé and Maler (2010) over the samples that there are, with the negation
pushed down to the comparisons, and with windows that the end of the run cuts off. A window that
looks back has no value until it is full, unless it is one of `so far`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeGuard

from bt_mission.base.verdicts import Verdict
from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Constant,
    FunctionCall,
    Logic,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.requirements.language.syntax import Implies, Measure, SignalValue, Temporal
from bt_mission.requirements.samples import Truncation

Rated = tuple[float, bool]
"""Margin, and whether it holds."""


@dataclass(frozen=True)
class Definition:
    """A run: instants (s), and the values of each signal at each of them."""

    times: Sequence[float]
    signals: Mapping[str, Sequence[float | bool]]
    truncation: Truncation = Truncation.NEUTRAL
    rated: dict[tuple[int, int, bool], Rated | None] = field(default_factory=dict, repr=False)

    def instants(self) -> list[dict[str, float | bool]]:
        """Return the values of the signals at each instant."""
        names, columns = self.signals.keys(), self.signals.values()
        return [dict(zip(names, row, strict=True)) for row in zip(*columns, strict=True)]

    def rate(self, node: SyntaxNode, at: int = 0, *, positive: bool = True) -> Rated | None:
        """Return what a formula is worth at an instant; None where its window has no sample."""
        key = (id(node), at, positive)
        if key not in self.rated:
            is_early = _has_to_fill(node) and self.times[at] < needs(node) - 1e-9
            self.rated[key] = None if is_early else self._rate(node, at, positive=positive)
        return self.rated[key]

    def _rate(self, node: SyntaxNode, at: int, *, positive: bool) -> Rated | None:
        match node:
            case Not(operand=operand):
                return self.rate(operand, at, positive=not positive)
            case Logic(symbol=symbol, left=left, right=right):
                pair = [self.rate(part, at, positive=positive) for part in (left, right)]
                return _kleene(pair, all_of=(symbol == "and") is positive)
            case Temporal(word="starts" | "ends" | "until" | "since" as word):
                kinds = {"until": self._until, "since": self._since_value}
                return kinds.get(word, self._edge)(node, at, positive=positive)
            case Temporal(word="always" | "eventually" as word, operands=(operand,)):
                all_of = (word == "always") is positive
                return self._ahead(node, operand, at, all_of=all_of, positive=positive)
            case Temporal(word=word, operands=(operand,)):
                all_of = (word == "historically") is positive
                inside = [k for k in range(at + 1) if self.is_in(node, at, k)]
                old = [k for k in range(at + 1) if self._since(k, at) >= node.window.start - 1e-9]
                if not old:
                    return _vacuous(holds=all_of)
                ratings = [self.rate(operand, k, positive=positive) for k in inside]
                return _over_time(ratings, all_of=all_of)
        return self._compared(node, at, positive=positive)

    def _compared(self, node: SyntaxNode, at: int, *, positive: bool) -> Rated | None:
        margin = self._margin(node, at)
        if margin is None:
            return None
        holds = margin > 0 or (margin == 0 and _is_weak(node))
        return (margin, holds) if positive else (-margin, not holds)

    def _since(self, earlier: int, other: int) -> float:
        return self.times[other] - self.times[earlier]

    def is_in(self, node: Temporal, at: int, k: int) -> bool:
        """Return whether an instant is in the window of another."""
        apart = abs(self.times[k] - self.times[at])
        return node.window.start - 1e-9 <= apart <= node.window.end + 1e-9

    def _is_cut(self, node: Temporal, at: int) -> bool:
        return self.times[at] + node.window.end > self.times[-1] + 1e-9

    def _is_settled(self, node: Temporal) -> bool:
        is_moving = any(
            (_looks_back(part) and part.window.is_bounded)
            or (isinstance(part, Measure) and part.word in ("mean", "rate"))
            for part in _walk(node)
        )
        settled = all("running" in name for name in _names(node)) and not is_moving
        return settled or not node.window.is_bounded

    def _may_come(self, node: Temporal, at: int) -> bool:
        is_settled = self._is_settled(node)
        return self._is_cut(node, at) and self.truncation.fulfils(is_settled_by_end=is_settled)

    def _may_be_refuted(self, node: Temporal, at: int, rating: Rated | None) -> bool:
        is_refuted = rating is not None and not rating[1]
        can_be = self.truncation.refutes(is_settled_by_end=self._is_settled(node))
        return can_be and self._is_cut(node, at) and not is_refuted

    def _ahead(
        self, node: Temporal, operand: SyntaxNode, at: int, *, all_of: bool, positive: bool
    ) -> Rated | None:
        inside = [k for k in range(at, len(self.times)) if self.is_in(node, at, k)]
        rating = _over_time(
            [self.rate(operand, k, positive=positive) for k in inside], all_of=all_of
        )
        if all_of and self._may_be_refuted(node, at, rating):
            return _vacuous(holds=False)
        if all_of or not self._is_cut(node, at) or (rating is not None and rating[1]):
            return rating
        if self._may_come(node, at):
            return _vacuous(holds=True)
        return _vacuous(holds=False) if rating is None and node.window.is_bounded else rating

    def _until(self, node: Temporal, at: int, *, positive: bool) -> Rated | None:
        pick, outer = (min, max) if positive else (max, min)
        kept = _vacuous(holds=positive)
        ratings: list[Rated] = []
        is_empty = True
        for k in range(at, len(self.times)):
            if self.times[k] > self.times[at] + node.window.end + 1e-9:
                break
            right = self.rate(node.operands[1], k, positive=positive)
            is_empty = is_empty and not self.is_in(node, at, k)
            if self.is_in(node, at, k) and right is not None:
                ratings.append(pick(kept, right))
            left = self.rate(node.operands[0], k, positive=positive)
            kept = kept if left is None else pick(kept, left)
        value = outer(ratings) if ratings else _vacuous(holds=not positive) if is_empty else None
        fails = value is None or not value[1]
        if positive and fails and kept[1] and self._may_come(node, at):
            return _vacuous(holds=True)
        if not positive and not kept[1] and self._may_be_refuted(node, at, value):
            return _vacuous(holds=False)
        return value

    def _since_value(self, node: Temporal, at: int, *, positive: bool) -> Rated | None:
        pick, outer = (min, max) if positive else (max, min)
        ratings: list[Rated] = []
        is_empty = True
        for k in range(at + 1):
            if self.is_in(node, at, k):
                right = self.rate(node.operands[1], k, positive=positive)
                lefts = [
                    self.rate(node.operands[0], j, positive=positive) for j in range(k + 1, at + 1)
                ]
                if right is not None:
                    ratings.append(
                        pick(right, *(rating for rating in (right, *lefts) if rating is not None))
                    )
                is_empty = False
        if not ratings and not is_empty:
            return None
        return outer(ratings) if ratings else _vacuous(holds=not positive)

    def _edge(self, node: Temporal, at: int, *, positive: bool) -> Rated | None:
        new = self.rate(node.operands[0], at)
        known = [
            rating for k in range(at) if (rating := self.rate(node.operands[0], k)) is not None
        ]
        if new is None:
            return None
        old = known[-1] if known else _vacuous(holds=False)
        value = min(new, _not(old)) if node.word == "starts" else min(_not(new), old)
        return value if positive else _not(value)

    def _measure(self, node: Measure, at: int) -> float | None:
        """Return the value of a measure at an instant; None without one."""
        if _has_to_fill(node) and self.times[at] < needs(node) - 1e-9:
            return None
        inside = [k for k in range(at + 1) if self._since(k, at) <= node.window.end + 1e-9]
        if node.edge is not None:
            edges = [
                k for k in inside if (rating := self.rate(node.edge, k)) is not None and rating[1]
            ]
            if node.operand is None:
                return len(edges)
            return self._number(node.operand, edges[-1]) if edges else None
        assert node.operand is not None
        numbers = {k: self._number(node.operand, k) for k in inside}
        known = {k: number for k, number in numbers.items() if number is not None}
        if node.word == "mean":
            return sum(known.values()) / len(known) if known else None
        earlier = [k for k in known if k < at]
        if at not in known or not earlier:
            return None
        return (known[at] - known[earlier[-1]]) / round(self._since(earlier[-1], at), 9)

    def _margin(self, node: SyntaxNode, at: int) -> float | None:
        if isinstance(node, SignalValue):
            return math.inf if self.signals[node.key][at] else -math.inf
        assert isinstance(node, Comparison)
        symbol, _, right = node.rest[0]
        first, second = self._number(node.first, at), self._number(right, at)
        if first is None or second is None:
            return None
        return second - first if symbol in ("<", "<=") else first - second

    def _number(self, node: SyntaxNode, at: int) -> float | None:
        if isinstance(node, SignalValue):
            return self.signals[node.key][at]
        if isinstance(node, Measure):
            return self._measure(node, at)
        if isinstance(node, Negation | FunctionCall):
            operand = self._number(node.parts[0], at)
            if operand is None:
                return None
            return node.sign * operand if isinstance(node, Negation) else abs(operand)
        if isinstance(node, Arithmetic):
            left, right = self._number(node.left, at), self._number(node.right, at)
            return None if left is None or right is None else left - right
        assert isinstance(node, Constant)
        assert isinstance(node.value, int | float)
        return node.value


def verdict(root: SyntaxNode, run: Definition, *, is_complete: bool) -> tuple[Verdict, float]:
    """Return the verdict of a formula about a whole run, and its margin."""
    weak = Truncation.WEAK_AFTER_MISSION if is_complete else Truncation.WEAK
    least = Definition(run.times, run.signals).rate(root)
    best = Definition(run.times, run.signals, weak).rate(root)
    strong = Truncation.STRONG_AFTER_MISSION if is_complete else Truncation.STRONG
    worst = Definition(run.times, run.signals, strong).rate(root)
    if least is None or best is None:
        if not is_exercised(root, run, by_windows_alone=True):
            return "not exercised", math.nan
        return "open" if run.times[-1] < needs(root) - 1e-9 else "unknown", math.nan
    if not best[1]:
        return "violated", best[0]
    if worst is None or not worst[1]:
        return "open", best[0]
    return "holds" if is_exercised(root, run) else "not exercised", least[0]


def is_exercised(root: SyntaxNode, run: Definition, *, by_windows_alone: bool = False) -> bool:
    """Return whether every premise of a formula comes true where the formula asks for it."""
    neutral = Definition(run.times, run.signals)

    def holds(node: SyntaxNode, at: int) -> bool:
        rating = neutral.rate(node, at)
        return rating is not None and rating[1]

    def asked(node: SyntaxNode, instants: set[int], *, positive: bool) -> bool:
        """Return the same of a part that is asked for at some instants."""
        match node:
            case Not(operand=operand):
                return asked(operand, instants, positive=not positive)
            case Implies(left=Not(operand=premise), right=right) if positive:
                true = {at for at in instants if holds(premise, at)}
                is_met = by_windows_alone or bool(true)
                return (
                    is_met
                    and asked(right, true, positive=True)
                    and asked(premise, instants, positive=False)
                )
            case Temporal(word="starts" | "ends"):
                return True
            case Temporal(word=word, operands=operands, window=window):
                is_ahead = word in ("always", "eventually", "until")
                inside = {
                    k
                    for at in instants
                    for k in range(len(run.times))
                    if (k >= at if is_ahead else k <= at) and neutral.is_in(node, at, k)
                }
                if is_ahead and window.start > 0 and not inside:
                    return False
                return all(asked(part, inside, positive=positive) for part in operands)
            case Logic(left=left, right=right):
                return all(asked(part, instants, positive=positive) for part in (left, right))
        return True

    return asked(root, {0}, positive=True)


def needs(node: SyntaxNode) -> float:
    """For how long a run must have gone on until the windows that look back are full, s."""
    below = max(map(needs, node.parts), default=0.0)
    return below + node.window.end if _has_to_fill(node) else below


def _has_to_fill(node: SyntaxNode) -> TypeGuard[Temporal | Measure]:
    return _looks_back(node) and node.window.is_bounded and not node.window.so_far


def _looks_back(node: SyntaxNode) -> TypeGuard[Temporal | Measure]:
    words = ("previously", "historically", "since")
    return isinstance(node, Measure) or (isinstance(node, Temporal) and node.word in words)


def _walk(node: SyntaxNode) -> Iterator[SyntaxNode]:
    yield node
    for part in node.parts:
        yield from _walk(part)


def _names(node: SyntaxNode) -> list[str]:
    own = [node.key] if isinstance(node, SignalValue) else []
    return own + [name for part in node.parts for name in _names(part)]


def _is_weak(node: SyntaxNode) -> bool:
    return isinstance(node, Comparison) and node.rest[0][0] in ("<=", ">=")


def _not(rating: Rated) -> Rated:
    return -rating[0], not rating[1]


def _vacuous(*, holds: bool) -> Rated:
    return (math.inf, True) if holds else (-math.inf, False)


def _over_time(values: Sequence[Rated | None], *, all_of: bool) -> Rated | None:
    known = [value for value in values if value is not None]
    if not known:
        return None
    return min(known) if all_of else max(known)


def _kleene(values: Sequence[Rated | None], *, all_of: bool) -> Rated | None:
    rating = _over_time(values, all_of=all_of)
    if None in values and (rating is None or rating[1] is all_of):
        return None
    return rating
