"""A requirement as it is written, parsed and checked as far as no mission is needed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Literal

from bt_mission.language.expressions.outcomes import Range, outcomes, range_of
from bt_mission.language.expressions.syntax import Logic, Not, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.requirements.parser import parse_requirement
from bt_mission.language.requirements.signals import SIGNALS
from bt_mission.language.requirements.syntax import (
    FUTURE,
    Chain,
    Edge,
    Measure,
    SignalValue,
    Temporal,
)
from bt_mission.language.requirements.units import unit_of

CONTROL_STEP_S = 0.05
"""How often the executive looks; a shorter window may hold no sample at all."""

OnViolation = Literal["report", "fail", "halt"]


@dataclass(frozen=True)
class Formula:
    """A formula of temporal logic. Raises ExpressionError where its text is none."""

    text: str
    root: SyntaxNode = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        root = parse_requirement(self.text)
        check_formula(root)
        object.__setattr__(self, "root", root)


@dataclass(frozen=True)
class Clause:
    """A part of a requirement that is written in several: no whole formula yet."""

    text: str
    root: SyntaxNode = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "root", parse_requirement(self.text))


@dataclass(frozen=True)
class Condition:
    """A condition at one instant, over the present and what was before.

    Raises:
        ExpressionError: Where its text is none, speaks of what comes, or compares what does not
            fit.
    """

    text: str
    root: SyntaxNode = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        root = parse_requirement(self.text)
        check_condition(root)
        object.__setattr__(self, "root", root)


@dataclass(frozen=True)
class Requirement:
    """A requirement with its name: what must hold, and what is done when it does not."""

    name: str
    text: str
    root: SyntaxNode = field(repr=False, compare=False)
    on_violation: OnViolation = "report"


def check_formula(root: SyntaxNode) -> None:
    """Refuse what is no formula about a whole run.

    Raises:
        ExpressionError: For types and units that do not fit, for what speaks of the start alone,
            for windows that are missing or too short, and for what can only come to one verdict.
    """
    root.expect(lambda _: None, "bool")
    for node in walk(root):
        if not isinstance(node, Temporal | Chain | Edge):
            unit_of(node)
    _check_times(root, outer=None)
    verdicts = _outcomes(root)
    if len(verdicts) == 1:
        what = "cannot be violated" if True in verdicts else "cannot hold"
        reach = ", ".join(
            f"'{name}' is {_words(SIGNALS[name].range)}"
            for name in dict.fromkeys(one.name for one in signals_in(root))
            if name in SIGNALS and SIGNALS[name].range != _ANY
        )
        raise ExpressionError(f"this {what}" + (f": {reach}" if reach else ""), root.column)


def check_condition(root: SyntaxNode) -> None:
    """Refuse what is no condition on the present and what was before.

    Raises:
        ExpressionError: For types and units that do not fit, for windows that are too short, for
            words that look ahead, and for what is always or never true.
    """
    root.expect(lambda _: None, "bool")
    for node in walk(root):
        match node:
            case Temporal(word=word) | Chain(symbol=word) if word in FUTURE:
                message = f"'{word}' looks ahead; a condition is about now and before"
                raise ExpressionError(message, node.column, _BACK.get(word))
            case Temporal() | Chain() | Edge():
                pass
            case _:
                unit_of(node)
    _check_times(root, outer="when")
    verdicts = _outcomes(root)
    if len(verdicts) == 1:
        what = "is always true" if True in verdicts else "is never true"
        raise ExpressionError(f"this {what}", root.column)


_BACK = {
    "always": "write 'historically ...', or the condition alone",
    "eventually": "write 'previously ...', or the condition alone",
    "until": "write '... since ...'",
}
_ANY = (float("-inf"), float("inf"))


def _words(ends: Range) -> str:
    low, high = ends
    return f"{low:g} or more" if high == float("inf") else f"{low:g} to {high:g}"


def walk(root: SyntaxNode) -> Iterator[SyntaxNode]:
    """Yield every part of a formula, outer parts first."""
    yield root
    for part in root.parts:
        yield from walk(part)


def signals_in(root: SyntaxNode) -> Iterator[SignalValue]:
    """Yield the signals of a formula, in the order of its text."""
    for node in walk(root):
        if isinstance(node, SignalValue):
            yield node


def full_after(root: SyntaxNode) -> float:
    """Return when the windows of a formula that look back are full at the latest, s.

    Windows with `so far`, and those without an end, count from the start on.
    """
    below = max(map(full_after, root.parts), default=0.0)
    return below + filling(root)


def filling(node: SyntaxNode) -> float:
    """Return how long the window of a part takes to be full, s; 0 for one that need not be."""
    match node:
        case Temporal(word=word, window=window) | Chain(symbol=word, window=window):
            has_to = word not in FUTURE and window.is_bounded and not window.so_far
            return window.end if has_to else 0.0
        case Measure(window=window):
            return window.end if window.is_bounded and not window.so_far else 0.0
    return 0.0


def _check_times(node: SyntaxNode, outer: str | None) -> None:
    """Refuse words of time where they cannot stand; `outer` is the one around this part."""
    match node:
        case Temporal(word=word) | Chain(symbol=word):
            if not outer and word not in FUTURE:
                message = f"'{word}' looks back from the start alone"
                raise ExpressionError(message, node.column, f"write 'always {word} ...'")
            if outer and word in FUTURE and not node.window.is_bounded:
                message = f"'{word}' inside '{outer}' needs a window"
                raise ExpressionError(message, node.column, _windowed(word))
            if node.window.end < CONTROL_STEP_S:
                message = f"the window is shorter than a control step of {CONTROL_STEP_S:g} s"
                raise ExpressionError(message, node.column)
            for part in node.parts:
                _check_times(part, word)
        case Logic() | Not():
            for part in node.parts:
                _check_times(part, outer)
        case Edge():
            _check_edge(node, outer)
        case _:
            _refuse_times(node)
            if not outer:
                message = "this speaks of the start alone"
                raise ExpressionError(
                    message, node.column, "write 'always ...' or 'eventually ...'"
                )


def _check_edge(node: Edge, outer: str | None) -> None:
    if not outer:
        message = f"'{node.word}' compares the start with what was before"
        raise ExpressionError(message, node.column, f"write 'eventually {node.word}(...)'")
    for inner in walk(node.operand):
        if isinstance(inner, Temporal | Chain) and _word(inner) in FUTURE:
            message = f"'{_word(inner)}' looks ahead, which '{node.word}' cannot"
            raise ExpressionError(message, inner.column)
    _check_times(node.operand, node.word)


def _windowed(word: str) -> str:
    return {
        "always": "such as 'always for 5 s ...'",
        "eventually": "such as 'eventually within 5 s ...'",
    }.get(word, "such as '... until ... within 5 s'")


def _word(node: Temporal | Chain | Edge) -> str:
    return node.symbol if isinstance(node, Chain) else node.word


def _refuse_times(node: SyntaxNode) -> None:
    """Refuse words of time inside a calculation, but for those of what is measured in it."""
    if isinstance(node, Temporal | Chain | Edge):
        message = f"'{_word(node)}' cannot stand inside a calculation or an 'if'"
        raise ExpressionError(message, node.column)
    if isinstance(node, Measure):
        if node.window.end < CONTROL_STEP_S:
            message = f"the window is shorter than a control step of {CONTROL_STEP_S:g} s"
            raise ExpressionError(message, node.column)
        if node.edge is not None:
            _check_times(node.edge, node.word)
        if node.operand is not None:
            _refuse_times(node.operand)
        return
    for part in node.parts:
        _refuse_times(part)


def _range(node: SyntaxNode) -> Range | None:
    if isinstance(node, Measure) and node.word != "rate":
        return (0.0, float("inf")) if node.operand is None else range_of(node.operand, _range)
    if isinstance(node, SignalValue) and node.name in SIGNALS:
        return SIGNALS[node.name].range
    return None


def _outcomes(node: SyntaxNode) -> frozenset[bool]:
    """Return the verdicts that a formula can come to, by the ranges of its signals."""
    joins: dict[str, Callable[[list[bool]], bool]] = {"and": all, "or": any}
    match node:
        case Temporal(operand=operand):
            return _outcomes(operand)
        case Chain():
            return frozenset((True, False))
        case Not(operand=operand):
            return frozenset(not one for one in _outcomes(operand))
        case Logic(symbol=symbol, left=left, right=right):
            join = joins[symbol]
            return frozenset(join([a, b]) for a in _outcomes(left) for b in _outcomes(right))
    return outcomes(node, _range)
