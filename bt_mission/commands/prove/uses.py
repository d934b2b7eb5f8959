"""Where a mission uses each of its values, and what it can tell of them there."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Literal, TypeAlias

from bt_mission.commands.prove.regions import (
    DRAW,
    FAILED,
    UnfollowedError,
    evaluated,
    is_literal,
    reads,
)
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.expressions.syntax import (
    Arithmetic,
    Conditional,
    Constant,
    FunctionCall,
    Logic,
    Name,
    Negation,
    Not,
    SyntaxNode,
)
from bt_mission.language.expressions.values import ExpressionError
from bt_mission.language.message_types import (
    LONGEST_DURATION_S,
    ListOf,
    MessageShape,
    Scalar,
    Shape,
    TypeMismatch,
    UnknownField,
    conform,
    field_at,
)
from bt_mission.language.mission import Mission, Requirement, Tree
from bt_mission.language.nodes.base import NodeModel, OutputsNode, Read
from bt_mission.language.nodes.decorators import ForEachNode
from bt_mission.language.nodes.fields import NumberRule
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.leaves import PythonNode, SetNode
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.requirements.language.formula import root_of
from bt_mission.requirements.language.syntax import Measure, SignalValue, Temporal
from bt_mission.ros.interface_types import shapes

Kind: TypeAlias = Literal["condition", "number", "flow", "elements", "sent", "plain"]
_TOTAL = frozenset(("abs", "sign", "min", "max", "degrees", "radians", "uniform", "copysign"))
"""Functions without errors."""
MOST_WHOLE = 2.0**64
"""No usual number, and no integer of a message, is beyond it."""
MOST_DEGREES = 60
"""By which a function makes a number larger at most: degrees of radians."""
_COORDINATE = Scalar("float64", "number")
"""A number in place of a part of a pose."""


@dataclass(frozen=True, eq=False)
class Use:
    """An expression that a mission evaluates.

    Attributes:
        root: Its parts; fields of messages have names such as `<percentage>`.
        text: As it is written.
        place: Where, for people.
        kind: What its value is for: a condition, a number such as a time, a variable that it is
            assigned to, the list of a loop, a field of a message that is sent, or for other
            things, which only errors change.
        rule: Of a number.
        target: The variable that gets it, or its elements.
        shape: Of the field that is sent.
    """

    root: SyntaxNode
    text: str
    place: str
    kind: Kind
    rule: NumberRule | None = None
    target: str = ""
    shape: Shape | None = None

    @property
    def shown(self) -> str:
        """The expression and its place."""
        return f"'{self.text}' ({self.place})"

    @property
    def is_whole(self) -> bool:
        """Is it the value as it is?"""
        return isinstance(self.root, Name)

    def is_sent(self, value: Any) -> bool:
        """Does the field take a value? Another one ends the mission."""
        assert self.shape is not None
        problems: list[TypeMismatch] = []
        conform(self.shape, value, lambda *_: None, problems.append)
        return not problems

    def takes(self, root: SyntaxNode) -> bool:
        """Does the field take a number, whichever usual numbers it is computed of?"""
        shape = self.shape
        if not isinstance(shape, Scalar) or shape.type != "number" or not _is_safe(root):
            return False
        return _magnitude(root) <= min(-shape.least, shape.most)

    @property
    def ends_of_field(self) -> tuple[float, ...]:
        """The least and the greatest number that the field takes; none of one without numbers."""
        most = sys.float_info.max
        if isinstance(self.shape, Scalar):
            return max(self.shape.least, -most), min(self.shape.most, most)
        return (
            (-LONGEST_DURATION_S, LONGEST_DURATION_S)
            if isinstance(self.shape, MessageShape)
            else ()
        )


def field_name(dotted: str) -> str:
    """Return the name of a field of a message in expressions here."""
    return f"<{dotted}>"


def names_in(root: SyntaxNode) -> frozenset[str]:
    """Return what an expression reads: variables, fields, signals, and whether it draws."""
    names = {name for part in root.parts for name in names_in(part)}
    match root:
        case Name():
            names.add(root.name)
        case SignalValue():
            names.add(f"{root.key}()")
        case FunctionCall() if root.draws:
            names.add(DRAW)
    return frozenset(names)


def texts_in(root: SyntaxNode) -> Iterator[str]:
    """Yield the constant texts of an expression."""
    if isinstance(root, Constant) and isinstance(root.value, str):
        yield root.value
    for part in root.parts:
        yield from texts_in(part)


def numbers_in(root: SyntaxNode) -> Iterator[float]:
    """Yield the constant numbers of an expression."""
    if isinstance(root, Constant) and type(root.value) in (int, float):
        yield float(root.value)  # type: ignore[arg-type]
    for part in root.parts:
        yield from numbers_in(part)


def atoms_of(use: Use, name: str, fixed: Mapping[str, Any]) -> list[SyntaxNode]:
    """Return the parts of an expression that depend on one value, and on nothing else that varies.

    Args:
        use: The expression.
        name: Of the value.
        fixed: Names with few known values.

    Raises:
        UnfollowedError: It is computed together with another value that varies.
    """
    return list(_atoms(use.root, use, name, fixed))


def _atoms(root: SyntaxNode, use: Use, name: str, fixed: Mapping[str, Any]) -> Iterator[SyntaxNode]:
    if not reads(root, name):
        return
    others = {other for other in names_in(root) if other != name and other not in fixed}
    is_formula = any(isinstance(part, Temporal | Measure) for part in _walk(root))
    is_total = use.kind == "plain" and _is_total(root)
    if not others and not is_formula and not is_total:
        yield root
        return
    parts: Iterable[SyntaxNode] = root.parts
    match root:
        case _ if is_total:
            pass
        case FunctionCall(name="copysign") if use.kind == "sent" and _is_safe(root.arguments[1]):
            parts = root.arguments[:1]  # a field takes a number with both signs, or with none
        case Arithmetic() if use.kind == "sent" and use.takes(root):
            pass  # what is not finite makes all of it so
        case Logic() | Not() | Temporal():
            pass
        case Conditional() if use.kind in ("condition", "plain"):
            pass
        case Measure() if root.operand is None or not reads(root.operand, name):
            pass
        case _:
            raise UnfollowedError
    for part in parts:
        yield from _atoms(part, use, name, fixed)


def _is_total(root: SyntaxNode) -> bool:
    """Does it compute a number of any usual ones without an error?"""
    match root:
        case Arithmetic():
            return root.symbol in ("+", "-", "*")
        case FunctionCall():
            return root.name in _TOTAL
    return isinstance(root, Negation)


def _is_safe(root: SyntaxNode) -> bool:
    """Is it computed of numbers without an error, whichever they are?"""
    return isinstance(root, Name | Constant) or (_is_total(root) and all(map(_is_safe, root.parts)))


def _magnitude(root: SyntaxNode) -> float:
    """Return what a number is never beyond that is safely computed of usual ones."""
    match root:
        case Constant():
            return abs(root.value) if isinstance(root.value, int | float) else math.inf
        case Name():
            return MOST_WHOLE
    parts = [_magnitude(part) for part in root.parts]
    match root:
        case Arithmetic() if root.symbol == "*":
            return math.prod(parts)
        case Arithmetic():
            return sum(parts)
    return MOST_DEGREES * max(parts)


def _walk(root: SyntaxNode) -> Iterator[SyntaxNode]:
    yield root
    for part in root.parts:
        yield from _walk(part)


def renamed(value: Any, name_of: Mapping[str, str] | None = None) -> Any:
    """Return an expression with signals such as `$x` as names, and bare fields renamed.

    Args:
        value: The expression, or a part of it.
        name_of: The new name of each bare name that is a field.
    """
    if isinstance(value, SignalValue) and value.name == "$":
        return Name(value.column, value.arguments[0], True)
    if isinstance(value, Name):
        new = (name_of or {}).get(value.name)
        return value if value.variable or new is None else replace(value, name=new)
    if isinstance(value, SyntaxNode) and is_dataclass(value):
        changed = {
            entry.name: renamed(getattr(value, entry.name), name_of)
            for entry in fields(value)
            if isinstance(getattr(value, entry.name), SyntaxNode | tuple)
        }
        return replace(value, **changed)
    if isinstance(value, tuple) and type(value) is tuple:
        return tuple(renamed(part, name_of) for part in value)
    return value


class Uses:
    """The uses of all values of a mission.

    Attributes:
        of: By the name of a variable.
        fixed: Variables with few known values, which no message, draw or computation changes.
        by_draw: By the path of a node in its tree, the expressions that draw.

    Args:
        mission: Named trees included.
        requirements: Their conditions on variables count, too.
    """

    def __init__(self, mission: Mission, requirements: Iterable[Requirement] = ()) -> None:
        self._mission = mission
        self._every: list[Use] = []
        self._drawing: dict[int, list[Use]] = {}
        self._times: set[float] = set()
        literal: dict[str, list[Any]] = {name: [value] for name, value in mission.inputs.items()}
        varying: set[str] = set()
        for tree in mission.all_trees:
            varying.update(follow.variable for follow in tree.follow)
            if not tree.is_main:
                for name, value in tree.inputs.items():
                    literal.setdefault(name, []).append(value)
            for node in tree.body.walk():
                self._note_node(tree, node)
                self._note_writes(node, literal, varying)
        for requirement in requirements:
            root = renamed(root_of(requirement))
            place = f"requirement '{requirement.name}'"
            self._every.append(Use(root, requirement.text, place, "condition"))
        self.fixed: dict[str, list[Any]] = {
            name: values for name, values in literal.items() if name not in varying
        }
        self.of: dict[str, list[Use]] = {}
        for use in self._every:
            for name in names_in(use.root):
                self.of.setdefault(name, []).append(use)

    @property
    def times(self) -> tuple[float, ...]:
        """The least, the middle and the greatest of the constant times of the mission, s."""
        times = sorted(self._times)
        return tuple(dict.fromkeys(times[index] for index in (0, len(times) // 2, -1) if times))

    def drawing(self, node: NodeModel) -> list[Use]:
        """Return the expressions of a node that draw."""
        return self._drawing.get(id(node), [])

    # ---- nodes -------------------------------------------------------------------------------

    def _note_node(self, tree: Tree, node: NodeModel) -> None:
        place = f"{self._mission.portable_name(tree.document.file)}:{node.line}"
        for read in node.reads():
            self._note_read(node, read, place)
        if isinstance(node, TreeNode):
            for inner, outer in node.outputs.items():
                for source, target in ((inner, outer), (outer, inner)):
                    name = Name(1, source, True)
                    self._note(node, Use(name, source, place, "flow", target=target))
        if isinstance(node, InterfaceNode):
            for root, text, shape in _sent(node.sent, shapes(node.type).sends):
                kind: Kind = "plain" if shape is None else "sent"
                self._note(node, Use(root, text, place, kind, shape=shape))
            if node.condition is not None:
                self._note(node, condition_use(node, place))

    def _note_read(self, node: NodeModel, read: Read, place: str) -> None:
        if isinstance(read.wanted, NumberRule) and type(read.value) in (int, float):
            self._times.add(float(read.value))  # type: ignore[arg-type]
        for root, text in _roots(read.value):
            self._note(node, _use_of(node, read, root, text, place))

    def _note(self, node: NodeModel, use: Use) -> None:
        self._every.append(use)
        if DRAW in names_in(use.root):
            self._drawing.setdefault(id(node), []).append(use)

    def _note_writes(
        self, node: NodeModel, literal: dict[str, list[Any]], varying: set[str]
    ) -> None:
        given: Mapping[str, Any] = {}
        if isinstance(node, SetNode):
            given = node.values
        elif isinstance(node, TreeNode):
            given = node.inputs
            varying.update(node.outputs.values(), node.outputs)
        elif isinstance(node, OutputsNode | PythonNode):
            varying.update(node.outputs.values())
        elif isinstance(node, ForEachNode):
            varying.add(node.variable)
        for name, value in given.items():
            known = _literal(value)
            if known is FAILED:
                varying.add(name)
            else:
                literal.setdefault(name, []).append(known)


def condition_use(node: InterfaceNode, place: str = "") -> Use:
    """Return the condition of a node on messages; its fields have separate names."""
    condition = node.condition
    assert condition is not None
    asked = shapes(node.type).asks
    names = {}
    for name in condition.references:
        if name.variable or asked is None:
            continue
        try:
            field_at(asked, name.name)
        except UnknownField:
            continue
        names[name.name] = field_name(name.name)
    return Use(renamed(condition.root, names), condition.text, place, "condition")


def _use_of(node: NodeModel, read: Read, root: SyntaxNode, text: str, place: str) -> Use:
    if isinstance(read.wanted, NumberRule):
        return Use(root, text, place, "number", read.wanted)
    if isinstance(node, SetNode | TreeNode):
        return Use(root, text, place, "flow", target=str(read.path[-1]))
    if isinstance(node, ForEachNode):
        return Use(root, text, place, "elements", target=node.variable)
    return Use(root, text, place, "condition" if read.wanted == "bool" else "plain")


def _sent(value: Any, shape: Shape | None) -> Iterator[tuple[SyntaxNode, str, Shape | None]]:
    """Yield the expressions in the fields of a message, each with the shape of its field.

    Texts take every value, so they have none.
    """
    match value:
        case Text():
            is_text = isinstance(shape, Scalar) and shape.type == "text"
            reading = value.template if is_text else value.expression
            if not isinstance(reading, ExpressionError):
                for root, text in _roots(reading):
                    yield root, text, None if is_text else shape
        case Mapping():
            known = shape.fields if isinstance(shape, MessageShape) else {}
            for name, part in value.items():
                yield from _sent(part, known.get(name, _COORDINATE))
        case list() | tuple():
            for part in value:
                yield from _sent(part, shape.item if isinstance(shape, ListOf) else _COORDINATE)
        case _:
            yield from ((root, text, shape) for root, text in _roots(value))


def _roots(value: Any) -> Iterator[tuple[SyntaxNode, str]]:
    match value:
        case Expression():
            yield value.root, value.text
        case Template():
            for hole in value.holes:
                yield hole.expression.root, hole.expression.text
        case Text():
            for reading in (value.template, value.expression):
                if not isinstance(reading, ExpressionError):
                    yield from _roots(reading)
        case Mapping() | list() | tuple():
            for part in value.values() if isinstance(value, Mapping) else value:
                yield from _roots(part)


def _literal(value: Any) -> Any:
    """Return a value that is written as it is; `FAILED` for any other."""
    match value:
        case bool() | int() | float() | str():
            return value
        case Expression() if is_literal(value.root):
            return evaluated(value.root, "", 0.0, {})
        case Template() if not value.references and not value.draws:
            return value.text
    return FAILED
