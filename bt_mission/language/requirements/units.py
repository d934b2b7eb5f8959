"""Units of numbers in requirements: those of signals, and of what is computed with them."""

from __future__ import annotations

from bt_mission.core.units import Dimension
from bt_mission.language.expressions.syntax import SyntaxNode
from bt_mission.language.expressions.units import dimension_of
from bt_mission.language.requirements.signals import SIGNALS
from bt_mission.language.requirements.syntax import SignalValue


def unit_of(node: SyntaxNode) -> Dimension | None:
    """Return the unit of a number; None where it is not known, or any unit will do.

    Raises:
        ExpressionError: Where metres are compared with, or added to, seconds, and the like.
    """
    return dimension_of(node, _of_signal)


def _of_signal(node: SyntaxNode) -> Dimension | None:
    if isinstance(node, SignalValue) and node.name in SIGNALS:
        return SIGNALS[node.name].unit
    return None
