"""Formulas evaluated step by step, against the definition of their semantics and a library."""

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
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.mission import Requirement
from bt_mission.requirements.language.formula import Formula
from bt_mission.requirements.language.syntax import SignalValue, Temporal, TimeWindow
from bt_mission.requirements.measures import MEASURED_VALUES as MEASURES
from bt_mission.requirements.monitor import Monitor
from tests.support.played_signals import PlayedSignals
from tests.support.temporal_logic import Definition, verdict
from tests.support.thorough import sample

STEP_S = 0.05
BATCHES = 16
FORMULAS = 125


def _time(draw: random.Random) -> str:
    return f"{draw.choice((0.05, 0.1, 0.15, 0.3, 0.5))} s"


def _window(draw: random.Random, word: str) -> str:
    if draw.random() < 0.3:
        start = draw.choice((0.05, 0.1, 0.2))
        return f"between {start} s and {start + draw.choice((0.05, 0.1, 0.3))} s"
    return f"{word} {_time(draw)}"


def _measure(draw: random.Random, so_far: float) -> str:
    """A condition over what was so far."""
    symbol = draw.choice(("<", "<=", ">", ">="))
    back = " so far" if draw.random() < so_far else ""
    edge = f"{draw.choice(('starts', 'ends'))}({_atom(draw)})"
    within = draw.choice(("", f"within {_time(draw)}{back}"))
    forms = (
        f"count({edge}) {within} {symbol} {draw.randint(1, 3)}",
        f"mean({draw.choice(('x', 'x - y'))}) over {_time(draw)}{back} {symbol} 0.5",
        f"rate({draw.choice(('x', 'y'))}) {symbol} {draw.randint(-40, 40)}",
        f"abs(x - value(y) at last {edge}) {symbol} 2",
        f"mean(abs(rate(x))) over {_time(draw)}{back} {symbol} 40",
        f"rate(count({edge})) {symbol} 10",
        edge,
    )
    return draw.choice(forms)


def _atom(draw: random.Random) -> str:
    if draw.random() < 0.2:
        return "running('a')"
    symbol = draw.choice(("<", "<=", ">", ">="))
    left, right = draw.choice((("x", "y"), ("x", f"{draw.randint(-3, 3)}"), ("y", "0.5")))
    return f"{left} {symbol} {right}"


def _inner(draw: random.Random, depth: int, so_far: float, measures: float = 0.0) -> str:
    if not depth:
        return _measure(draw, so_far) if draw.random() < measures else _atom(draw)
    first, other = (_inner(draw, depth - 1, so_far, measures) for _ in range(2))

    def back(window: str) -> str:
        """Have a window that looks back count before it is full, as often as that is wanted."""
        return f"{window} so far" if draw.random() < so_far else window

    forms = (
        _atom(draw),
        f"not ({first})",
        f"({first}) {draw.choice(('and', 'or', 'implies'))} ({other})",
        f"(always {_window(draw, 'for')}: {first})",
        f"(eventually {_window(draw, 'within')}: {first})",
        f"(previously {draw.choice(('', back(_window(draw, 'within'))))} {first})",
        f"(historically {draw.choice(('', back(_window(draw, 'for'))))} {first})",
        f"(({first}) until ({other}) within {_time(draw)})",
        f"(({first}) since ({other}) {draw.choice(('', back(f'within {_time(draw)}')))})",
    )
    return draw.choice(forms)


def drawn_formula(
    draw: random.Random, depth: int = 3, so_far: float = 0.5, measures: float = 0.0
) -> str:
    """A requirement chosen at random.

    Args:
        so_far: How probably a window that looks back has a value before it is full.
        measures: How probably a condition is an edge, a count, a mean, a rate or an earlier value.
    """
    first, other = (_inner(draw, level, so_far, measures) for level in (depth, depth - 1))
    match draw.randrange(9):
        case 0 | 1 | 2:
            return f"always {draw.choice(('', _window(draw, 'for')))} {first}"
        case 3:
            return f"never {first}"
        case 4:
            return f"eventually {draw.choice(('', _window(draw, 'within')))} {first}"
        case 5:
            return f"whenever {first}: {other} within {_time(draw)}"
        case 6:
            return f"({first}) until ({other}) {draw.choice(('', f'within {_time(draw)}'))}"
        case 7:
            return f"whenever {first}: always {_window(draw, 'for')}: {other}"
    return f"(always {first}) {draw.choice(('and', 'or'))} not (eventually {other})"


def drawn_run(draw: random.Random) -> Definition:
    """Signals chosen at random, at every control step."""
    count = draw.randint(1, 30)
    return Definition(
        [round(STEP_S * k, 9) for k in range(count)],
        {
            "x": [draw.randint(-4, 4) for _ in range(count)],
            "y": [draw.randint(-4, 4) / 2 for _ in range(count)],
            "running('a')": [draw.random() < 0.5 for _ in range(count)],
        },
    )


def checked_formula(text: str) -> Formula | None:
    """Return a formula; None for one that can only come to one verdict."""
    try:
        return Formula(text)
    except ExpressionError as error:
        if "cannot be violated" in error.message or "cannot hold" in error.message:
            return None
        raise


@pytest.mark.parametrize("batch", sample(range(BATCHES), every=BATCHES))
def test_random_formulas_come_to_what_their_definition_says(batch: int) -> None:
    """Verdict and margin are those of the definition, for complete runs and for cut ones."""
    draw = random.Random(batch)
    reports = set()
    for _ in range(FORMULAS):
        measures = draw.choice((0.0, 0.4))
        text, run = drawn_formula(draw, measures=measures), drawn_run(draw)
        is_complete = draw.random() < 0.5
        formula = checked_formula(text)
        if formula is None:
            continue
        instants = run.instants()
        played = PlayedSignals(instants[0])
        monitor = Monitor(Requirement("r", text), played)
        for time_s, played.values in zip(run.times, instants, strict=True):
            monitor.step(round(time_s * 1e9))
        monitor.finish(is_complete=is_complete)
        result = monitor.result
        wanted, margin = verdict(formula.root, run, is_complete=is_complete)
        reports.add(wanted)
        assert result.verdict == wanted, (text, run, is_complete)
        if wanted in ("holds", "violated", "not exercised"):
            shown = float(f"{margin:.9g}") + 0.0 if math.isfinite(margin) else None
            assert result.margin == shown, (text, run, is_complete)
    assert reports >= {"holds", "violated", "open", "not exercised"}


# ---- by rtamt, a library of others for the same logic ----------------------------------------

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


def by_rtamt(root: SyntaxNode, columns: dict[str, list[float]]) -> float | None:
    """Return the margin at the start, by rtamt."""
    rtamt = pytest.importorskip("rtamt", reason="rtamt is not installed; it refuses Python 3.13")
    spec = rtamt.StlDiscreteTimeSpecification()
    for name in columns:
        spec.declare_var(name, "float")
    spec.set_sampling_period(STEP_MS, "ms", 0.1)
    spec.unit = "ms"
    spec.spec = translated(root)
    spec.parse()
    result = spec.evaluate({"time": [STEP_MS * k for k in range(STEPS)], **columns})
    margin = float(result[0][1])
    return margin if math.isfinite(margin) else None


def by_us(formula: Formula, columns: dict[str, list[float]]) -> float | None:
    """Return the margin by what is tested here."""
    played = PlayedSignals({name: values[0] for name, values in columns.items()})
    monitor = Monitor(Requirement("r", formula.text), played)
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


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("seed", "formulas", "measures"), sample([(1000, 250, 0.0), (3, 50, 0.5)], 4)
)
def test_margins_are_those_of_rtamt(seed: int, formulas: int, measures: float) -> None:
    """Every digit of them. Of edges, `starts` alone: rtamt has all true before the first instant.

    It has no truth without a measure and no verdicts, so the formulas compare numbers, and the
    runs are long enough for every window.
    """
    draw = random.Random(seed)
    for _ in range(formulas):
        formula = _compared(draw, measures)
        columns = {"x": [float(draw.randint(-4, 4)) for _ in range(STEPS)]}
        columns["y"] = [draw.randint(-4, 4) / 2 for _ in range(STEPS)]
        assert by_us(formula, columns) == by_rtamt(formula.root, columns), formula.text
