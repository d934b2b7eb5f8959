"""A requirement as it is written, parsed and checked as far as no mission is needed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from typing_extensions import override

from bt_mission.base.units import Dimension
from bt_mission.base.verdicts import Verdict
from bt_mission.language.expressions.outcomes import Range, outcomes, range_of
from bt_mission.language.expressions.syntax import Logic, Not, SyntaxNode
from bt_mission.language.expressions.units import dimension_of
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Requirement
from bt_mission.requirements.language.parser import parse_requirement
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.syntax import (
    EDGES,
    FUTURE,
    Measure,
    SignalValue,
    Temporal,
)

CONTROL_STEP_S = 0.05
"""The period of the control steps; a shorter window may hold no sample at all."""


@dataclass(frozen=True)
class Clause:
    """A part of a requirement that is written in several. Raises ExpressionError if invalid."""

    text: str
    root: SyntaxNode = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        root = parse_requirement(self.text)
        self._check(root)
        object.__setattr__(self, "root", root)

    def _check(self, root: SyntaxNode) -> None:
        """Refuse what is not valid. Raises ExpressionError."""


@dataclass(frozen=True)
class Formula(Clause):
    """A formula of temporal logic about a whole run. Raises ExpressionError if invalid."""

    @override
    def _check(self, root: SyntaxNode) -> None:
        check_formula(root)


@dataclass(frozen=True)
class Condition(Clause):
    """A condition at one instant, over the present and the past.

    Raises:
        ExpressionError: If it is invalid, looks ahead, or compares what does not fit.
    """

    @override
    def _check(self, root: SyntaxNode) -> None:
        root.expect(lambda _: None, "bool")
        for node in walk(root):
            if isinstance(node, Temporal) and node.word in FUTURE:
                message = f"'{node.word}' looks ahead; a condition covers only present and past"
                raise ExpressionError("BT-604", message, node.column, _BACK.get(node.word))
        value = _only_value(root, outer="when")
        if value is not None:
            raise ExpressionError(
                "BT-606", f"this is {'always' if value else 'never'} true", root.column
            )


def root_of(requirement: Requirement) -> SyntaxNode:
    """Return the formula of a requirement. Raises ExpressionError if it is invalid."""
    return parse_requirement(requirement.text)


def vacuous_verdict(requirement: Requirement) -> Verdict:
    """Return the verdict of a run in which a premise never came true."""
    return "not applicable" if may_not_apply(requirement.text) else "not exercised"


MAY_NOT_APPLY = "may not apply:"
"""The beginning of a formula whose premises may never come true."""
_MAY_NOT_APPLY = re.compile(r"\s*may\s+not\s+apply\b")


def may_not_apply(text: str) -> bool:
    """Return whether a formula says that its premises may never come true."""
    return _MAY_NOT_APPLY.match(text) is not None


def check_formula(root: SyntaxNode) -> None:
    """Refuse an invalid formula about a whole run.

    Raises:
        ExpressionError: For types and units that do not fit, for a formula about the start alone,
            for windows that are missing or too short, and for a formula with only one possible
            verdict.
    """
    value = _only_value(root, outer=None)
    if value is not None:
        what = "cannot be violated" if value else "cannot hold"
        reach = ", ".join(
            f"'{name}' is {_words(SIGNALS[name].range)}"
            for name in dict.fromkeys(signal.name for signal in signals_in(root))
            if name in SIGNALS and SIGNALS[name].range != _ANY
        )
        raise ExpressionError(
            "BT-606", f"this {what}" + (f": {reach}" if reach else ""), root.column
        )


_BACK = {
    "always": "write 'historically ...', or only the condition",
    "eventually": "write 'previously ...', or only the condition",
    "until": "write '... since ...'",
}
_WINDOWED = {
    "always": "such as 'always for 5 s ...'",
    "eventually": "such as 'eventually within 5 s ...'",
    "until": "such as '... until ... within 5 s'",
}
_ANY = (float("-inf"), float("inf"))


def _words(ends: Range) -> str:
    low, high = ends
    return f"{low:g} or more" if high == float("inf") else f"{low:g} to {high:g}"


# ---- parts -----------------------------------------------------------------------------------


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


def looks_ahead(root: SyntaxNode) -> bool:
    """Return whether a formula depends on later instants."""
    return any(isinstance(node, Temporal) and node.word in FUTURE for node in walk(root))


def full_after(root: SyntaxNode) -> float:
    """Return when the windows of a formula that look back are full at the latest, s.

    Windows with `so far`, and those without an end, count from the start on.
    """
    return max(map(full_after, root.parts), default=0.0) + filling(root)


def filling(node: SyntaxNode) -> float:
    """Return how long the window of a part takes to be full, s; 0 for one that need not be."""
    if not isinstance(node, Temporal | Measure) or node.word in FUTURE:
        return 0.0
    return node.window.end if node.window.is_bounded and not node.window.so_far else 0.0


# ---- units -----------------------------------------------------------------------------------


def unit_of(node: SyntaxNode) -> Dimension | None:
    """Return the unit of a number; None where it is not known, or any unit will do.

    Raises:
        ExpressionError: Where metres are compared with, or added to, seconds, and the like.
    """
    return dimension_of(node, _unit_of_value)


def _unit_of_value(node: SyntaxNode) -> Dimension | None:
    if isinstance(node, SignalValue) and node.name in SIGNALS:
        return SIGNALS[node.name].unit
    if not isinstance(node, Measure):
        return None
    if node.operand is None:
        return (0, 0, 0)
    unit = unit_of(node.operand)
    if node.word != "rate" or unit is None:
        return unit
    m, s, rad = unit
    return m, s - 1, rad


# ---- checks ----------------------------------------------------------------------------------


def _only_value(root: SyntaxNode, outer: str | None) -> bool | None:
    """Return the one value that a formula can have by the ranges of its signals, None for both.

    Raises:
        ExpressionError: For types, units and words of time that do not fit.
    """
    root.expect(lambda _: None, "bool")
    for node in walk(root):
        if not isinstance(node, Temporal):
            unit_of(node)
    _check_times(root, outer)
    values = _values(root)
    return next(iter(values)) if len(values) == 1 else None


def _check_times(node: SyntaxNode, outer: str | None) -> None:
    """Refuse words of time that are out of place; `outer` is the one around this part."""
    match node:
        case Temporal():
            _check_place(node, outer)
            _check_window(node)
            for part in node.parts:
                _check_times(part, node.word)
        case Logic() | Not():
            for part in node.parts:
                _check_times(part, outer)
        case _:
            _refuse_times(node)
            if not outer:
                message = "this covers only the start"
                hint = "write 'always ...' or 'eventually ...'"
                raise ExpressionError("BT-604", message, node.column, hint)


def _check_place(node: Temporal, outer: str | None) -> None:
    word = node.word
    if not outer and word in EDGES:
        message = f"'{word}' compares the start with the instant before it"
        raise ExpressionError("BT-604", message, node.column, f"write 'eventually {word}(...)'")
    if not outer and word not in FUTURE:
        message = f"'{word}' looks back only from the start"
        raise ExpressionError("BT-604", message, node.column, f"write 'always {word} ...'")
    if outer and word in FUTURE and not node.window.is_bounded:
        message = f"'{word}' inside '{outer}' needs a window"
        raise ExpressionError("BT-605", message, node.column, _WINDOWED[word])
    for inner in walk(node) if word in EDGES else ():
        if isinstance(inner, Temporal) and inner.word in FUTURE:
            message = f"'{inner.word}' looks ahead, which '{word}' cannot"
            raise ExpressionError("BT-604", message, inner.column)


def _check_window(node: Temporal | Measure) -> None:
    if node.window.end < CONTROL_STEP_S:
        message = f"the window is shorter than a control step of {CONTROL_STEP_S:g} s"
        raise ExpressionError("BT-605", message, node.column)


def _refuse_times(node: SyntaxNode) -> None:
    """Refuse words of time inside a calculation, but for those of what is measured in it."""
    if isinstance(node, Temporal):
        message = f"'{node.word}' is not allowed inside a calculation or an 'if'"
        raise ExpressionError("BT-604", message, node.column)
    parts = node.parts
    if isinstance(node, Measure):
        _check_window(node)
        if node.edge is not None:
            _check_times(node.edge, node.word)
        parts = () if node.operand is None else (node.operand,)
    for part in parts:
        _refuse_times(part)


def _range(node: SyntaxNode) -> Range | None:
    if isinstance(node, Measure) and node.word != "rate":
        return (0.0, float("inf")) if node.operand is None else range_of(node.operand, _range)
    if isinstance(node, SignalValue) and node.name in SIGNALS:
        return SIGNALS[node.name].range
    return None


def _values(node: SyntaxNode) -> frozenset[bool]:
    """Return the values that a formula can have, by the ranges of its signals."""
    match node:
        case Temporal(operands=(operand,), word=word) if word not in EDGES:
            return _values(operand)
        case Temporal(operands=(_, _)):
            return frozenset((True, False))
        case Not(operand=operand):
            return frozenset(not value for value in _values(operand))
        case Logic(symbol=symbol, left=left, right=right):
            join = all if symbol == "and" else any
            return frozenset(join((a, b)) for a in _values(left) for b in _values(right))
    return outcomes(node, _range)
