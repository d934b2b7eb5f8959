"""Units of numbers in requirements: those of signals, and of what is computed with them."""

from __future__ import annotations

from bt_mission.core.units import Dimension
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.expressions.units import dimension_of
from bt_mission.language.requirements.signals import SIGNALS
from bt_mission.language.requirements.syntax import Measure, SignalValue


def unit_of(node: SyntaxNode) -> Dimension | None:
    """Return the unit of a number; None where it is not known, or any unit will do.

    Raises:
        ExpressionError: Where metres are compared with, or added to, seconds, and the like.
    """
    return dimension_of(node, _of_value)


def _of_value(node: SyntaxNode) -> Dimension | None:
    if isinstance(node, Measure):
        return _of_measure(node)
    if isinstance(node, SignalValue) and node.name in SIGNALS:
        return SIGNALS[node.name].unit
    return None


def _of_measure(node: Measure) -> Dimension | None:
    if node.operand is None:
        return (0, 0, 0)
    unit = unit_of(node.operand)
    if node.word != "rate" or unit is None:
        return unit
    m, s, rad = unit
    return m, s - 1, rad
