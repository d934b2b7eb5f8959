"""The premises of a requirement: what must come true in a run for its verdict to show anything.

A premise is the left side of `whenever` or `implies`, and the beginning of a window that lies
ahead. One that is nested must come true under those around it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from bt_mission.language.expressions.syntax import Constant, Logic, Not, SyntaxNode
from bt_mission.requirements.language.syntax import EDGES, FUTURE, Implies, Temporal


@dataclass(frozen=True)
class Premise:
    """A premise.

    Attributes:
        root: That it comes true: a formula of the run where it is a premise of the whole formula,
            else of one instant.
        why_not: The message while it has not come true.
        is_window: Is it that a window begins?
    """

    root: SyntaxNode
    why_not: str
    is_window: bool = False


def premises_of(root: SyntaxNode) -> tuple[Premise, ...]:
    """Return the premises of a formula, outer ones first."""
    return tuple(_premises(root, positive=True, outer=""))


def _premises(node: SyntaxNode, *, positive: bool, outer: str) -> Iterator[Premise]:
    """Yield the premises of a part.

    Args:
        outer: The word of time around it; empty at the start of a run.
    """
    match node:
        case Not(operand=operand):
            yield from _premises(operand, positive=not positive, outer=outer)
        case Implies(left=left, right=right, premise=text) if positive:
            assert isinstance(left, Not)
            yield Premise(left.operand, f"'{text}' never came true")
            yield from _premises(left, positive=True, outer=outer)
            for inner in _premises(right, positive=True, outer=outer):
                both = Logic(node.column, "and", left.operand, inner.root)
                yield replace(inner, root=both, why_not=f"{inner.why_not} under '{text}'")
        case Temporal(word=word) if word not in EDGES:
            yield from _within(node, positive=positive, outer=outer)
        case Logic():
            for part in node.parts:
                yield from _premises(part, positive=positive, outer=outer)


def _within(node: Temporal, *, positive: bool, outer: str) -> Iterator[Premise]:
    """Yield the premises at any instant of a window, and that it begins."""
    looks_ahead, window = node.word in FUTURE, node.window
    word = "eventually" if looks_ahead else "previously"
    if not looks_ahead:
        window = replace(window, so_far=window.is_bounded)
    if looks_ahead and window.start > 0:
        began = Temporal(node.column, word, (Constant(node.column, value=True),), window)
        begins = f"begins {window.start:g} s later" if outer else f"begins at {window.start:g} s"
        yield Premise(began, f"the run ended before its window, which {begins}", is_window=True)
    for operand in node.operands:
        for premise in _premises(operand, positive=positive, outer=node.word):
            root = Temporal(node.column, word, (premise.root,), window)
            yield replace(premise, root=root)
