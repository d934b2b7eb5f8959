"""What is known of an expression before the run: its constant parts, and ranges of its value."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from itertools import pairwise, product

from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Comparison,
    Conditional,
    Constant,
    EvaluationScope,
    FunctionCall,
    Logic,
    Name,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.language.expressions.values import (
    ExpressionError,
    Plain,
    Type,
    fits,
    mismatch,
    type_of,
)

Range = tuple[float, float]
FindRange = Callable[[SyntaxNode], Range | None]
"""The range of the number behind a name or signal; None where it is not known, or is no number."""

ANYTHING: Range = (-math.inf, math.inf)
BOTH = frozenset((True, False))

_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
}
_SMALLEST_LARGEST: dict[str, Callable[..., float]] = {"min": min, "max": max}


def outcomes(node: SyntaxNode, find: FindRange) -> frozenset[bool]:
    """Return the truth values that a condition can have; both where that is not known."""
    match node:
        case Constant(value=bool(value)):
            return frozenset((value,))
        case Not(operand=operand):
            return frozenset(not value for value in outcomes(operand, find))
        case Logic(symbol=symbol, left=left, right=right):
            join = any if symbol == "or" else all
            pairs = product(outcomes(left, find), outcomes(right, find))
            return frozenset(join(pair) for pair in pairs)
        case Comparison():
            return _compared(node, find)
        case Conditional(value=value, otherwise=otherwise):
            return outcomes(value, find) | outcomes(otherwise, find)
    return BOTH


def _compared(node: Comparison, find: FindRange) -> frozenset[bool]:
    sides = [node.first, *(side for _, _, side in node.rest)]
    constants = [side.value for side in sides if isinstance(side, Constant)]
    if any(type_of(value) not in ("integer", "number") for value in constants):
        return BOTH
    ranges = [range_of(side, find) for side in sides]
    pairs = zip(pairwise(ranges), node.rest, strict=True)
    results = [_compare(left, right, symbol) for (left, right), (symbol, _, _) in pairs]
    if any(result == {False} for result in results):
        return frozenset((False,))
    return frozenset((True,)) if all(result == {True} for result in results) else BOTH


def _compare(left: Range, right: Range, symbol: str) -> frozenset[bool]:
    """Return what the comparison of two numbers in these ranges can come to."""
    if symbol in (">", ">="):
        return _compare(right, left, "<" if symbol == ">" else "<=")
    if symbol == "!=":
        return frozenset(not value for value in _compare(left, right, "=="))
    if symbol == "==":
        apart = left[1] < right[0] or right[1] < left[0]
        same = left[0] == left[1] == right[0] == right[1]
        return frozenset((False,)) if apart else frozenset((True,)) if same else BOTH
    if symbol == "<":
        always, never = left[1] < right[0], left[0] >= right[1]
    else:
        always, never = left[1] <= right[0], left[0] > right[1]
    return frozenset((True,)) if always else frozenset((False,)) if never else BOTH


def range_of(node: SyntaxNode, find: FindRange) -> Range:
    """Return from where to where the number can go that an expression gives."""
    match node:
        case Constant(value=int() | float() as value):
            return (float(value), float(value))
        case Negation(sign=sign, operand=operand):
            low, high = range_of(operand, find)
            return (-high, -low) if sign < 0 else (low, high)
        case Arithmetic(symbol=symbol, left=left, right=right) if symbol in _ARITHMETIC:
            apply = _ARITHMETIC[symbol]
            ends = product(range_of(left, find), range_of(right, find))
            return _spanned([apply(*pair) for pair in ends])
        case Conditional(value=value, otherwise=otherwise):
            return _spanned([*range_of(value, find), *range_of(otherwise, find)])
        case FunctionCall(name="abs", arguments=(operand,)):
            low, high = range_of(operand, find)
            least = 0.0 if low <= 0.0 <= high else min(abs(low), abs(high))
            return (least, max(abs(low), abs(high)))
        case FunctionCall(name="min" | "max" as name, arguments=arguments) if len(arguments) > 1:
            pick = _SMALLEST_LARGEST[name]
            lows, highs = zip(*(range_of(argument, find) for argument in arguments), strict=True)
            return (pick(lows), pick(highs))
    return find(node) or ANYTHING


def _spanned(ends: list[float]) -> Range:
    """Return the range of these numbers; of what is not a number nothing is known."""
    return ANYTHING if any(map(math.isnan, ends)) else (min(ends), max(ends))


# ---- parts that have the same value in every run ---------------------------------------------

_DIVIDES = frozenset(("/", "//", "%"))


def evaluate_constants(
    root: SyntaxNode,
    values: Mapping[str, Plain],
    is_constant: Callable[[Name], bool],
    wanted: Type | None = None,
) -> None:
    """Evaluate what can be evaluated before the run. Raises ExpressionError.

    `values` are those of the names that are constant. The operands that `and` and `or` skip are
    omitted. Where the whole expression is constant it must be of the wanted type.
    """
    scope = EvaluationScope(values, {}, random.Random(0))
    if _is_constant(root, scope, is_constant):
        value = root.evaluate(scope)
        if wanted is not None and not fits(type_of(value), wanted):
            raise mismatch(value, wanted, root.column)


def _is_constant(
    node: SyntaxNode,
    scope: EvaluationScope,
    is_constant: Callable[[Name], bool],
) -> bool:
    """Return whether a part is constant; if not, evaluate the largest parts in it that are."""
    if isinstance(node, Name):
        return is_constant(node)
    if isinstance(node, Conditional):
        # Of the two values only one is evaluated; which one, a constant condition tells.
        is_settled = _is_constant(node.condition, scope, is_constant)
        return is_settled and _is_constant(node.selected(scope), scope, is_constant)
    return _has_constant_parts(node, scope, is_constant)


def _has_constant_parts(
    node: SyntaxNode,
    scope: EvaluationScope,
    is_constant: Callable[[Name], bool],
) -> bool:
    constant = []
    for part in node.parts:
        if _is_constant(part, scope, is_constant):
            constant.append(part)
        if isinstance(node, Logic) and part is node.left and constant:
            left: bool = part.need(scope, "bool")
            if left == (node.symbol == "or"):
                return False
    if len(constant) == len(node.parts) and not (isinstance(node, FunctionCall) and node.draws):
        return True
    for part in constant:
        value = part.evaluate(scope)
        divides = isinstance(node, Arithmetic) and node.symbol in _DIVIDES and part is node.right
        if divides and value == 0:
            raise ExpressionError("BT-406", "division by zero", node.column)
    return False
