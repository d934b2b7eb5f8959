"""Margins of random formulas are those that rtamt computes, a library of others for the same logic.

It has no truth without a measure and no verdicts, so the formulas compare numbers, and the runs are
long enough for every window.
"""

from __future__ import annotations

import math
import random

import pytest

from bt_mission.language.expressions.syntax import (
    Comparison,
    Constant,
    Logic,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.language.requirements.formula import Formula, Requirement
from bt_mission.language.requirements.syntax import (
    SignalValue,
    Temporal,
    TimeWindow,
)
from bt_mission.requirements.measures import MEASURED_VALUES as MEASURES
from bt_mission.requirements.monitor import Monitor
from tests.requirements.test_semantics import checked_formula, drawn_formula
from tests.support.played_signals import PlayedSignals

rtamt = pytest.importorskip("rtamt", reason="rtamt is not installed; it refuses Python 3.13")

FORMULAS = 250
STEP_MS, STEPS = 50, 120
WORDS = {
    "always": "always",
    "eventually": "eventually",
    "historically": "historically",
    "previously": "once",
}


def translated(node: SyntaxNode) -> str:
    """Return a formula in the words of rtamt."""
    match node:
        case Not(operand=operand) | Temporal(word="starts", operands=(operand,)):
            return f"{'not' if isinstance(node, Not) else 'rise'}({translated(operand)})"
        case Logic(symbol=symbol, left=left, right=right):
            return f"({translated(left)}) {symbol} ({translated(right)})"
        case Temporal(word=word, operands=(operand,), window=window):
            return f"{WORDS[word]}{_span(window)}({translated(operand)})"
        case Temporal(word=word, operands=(left, right), window=window):
            return f"({translated(left)}) {word}{_span(window)} ({translated(right)})"
        case Comparison(first=first, rest=((symbol, _, right),)):
            return f"({translated(first)} {symbol} {translated(right)})"
        case SignalValue(name=name):
            return name
        case Constant(value=value):
            return f"{value}"
        case Negation(operand=Constant(value=float() | int() as value), sign=sign):
            return f"{sign * value}"
    raise AssertionError(f"the generator makes no {node}")


def _span(window: TimeWindow) -> str:
    if not window.is_bounded:
        return ""
    return f"[{round(window.start * 1000)}ms:{round(window.end * 1000)}ms]"


def by_rtamt(root: SyntaxNode, columns: dict[str, list[float]]) -> float:
    """Return the margin at the start, by rtamt."""
    spec = rtamt.StlDiscreteTimeSpecification()
    for name in columns:
        spec.declare_var(name, "float")
    spec.set_sampling_period(STEP_MS, "ms", 0.1)
    spec.unit = "ms"
    spec.spec = translated(root)
    spec.parse()
    result = spec.evaluate({"time": [STEP_MS * k for k in range(STEPS)], **columns})
    return float(result[0][1])


def by_us(formula: Formula, columns: dict[str, list[float]]) -> float | None:
    """Return the margin by what is tested here."""
    played = PlayedSignals({name: values[0] for name, values in columns.items()})
    monitor = Monitor(Requirement("r", formula.text, formula.root), played)
    for k in range(STEPS):
        played.values = {name: values[k] for name, values in columns.items()}
        monitor.step(k * STEP_MS * 1_000_000)
    monitor.finish()
    return monitor.result.margin


def _compared(draw: random.Random, measures: float = 0.0) -> Formula:
    """Return a random formula over numbers whose window at the start ends.

    Args:
        measures: How probably a condition is `starts(...)`.
    """
    while True:
        text = drawn_formula(draw, depth=2, so_far=1.0, measures=measures)
        is_known = not any(word in text for word in ("running", "ends(", *MEASURES))
        formula = checked_formula(text) if is_known else None
        if formula is not None and (not measures or "starts" in text):
            root = formula.root
            if isinstance(root, Temporal) and root.window.is_bounded:
                return formula


def test_margins_of_edges_are_those_of_rtamt() -> None:
    """Before the first instant nothing is true, so `ends`, of which rtamt has all true, differs."""
    draw = random.Random(3)
    for _ in range(FORMULAS // 5):
        formula = _compared(draw, measures=0.5)
        columns = {"x": [float(draw.randint(-4, 4)) for _ in range(STEPS)]}
        columns["y"] = [draw.randint(-4, 4) / 2 for _ in range(STEPS)]
        theirs = by_rtamt(formula.root, columns)
        assert by_us(formula, columns) == (theirs if math.isfinite(theirs) else None), formula.text


def test_margins_are_those_of_rtamt() -> None:
    """Every digit of them."""
    draw = random.Random(1000)
    for _ in range(FORMULAS):
        formula = _compared(draw)
        columns = {
            "x": [float(draw.randint(-4, 4)) for _ in range(STEPS)],
            "y": [draw.randint(-4, 4) / 2 for _ in range(STEPS)],
        }
        theirs = by_rtamt(formula.root, columns)
        ours = by_us(formula, columns)
        assert ours == (theirs if math.isfinite(theirs) else None), formula.text
