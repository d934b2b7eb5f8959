"""Which names are known where, of what type, and what an expression does with them.

Variables are the inputs, which never change, and the outputs of nodes that stand earlier in
the file. That an earlier node has really written its outputs, only the run can tell.
"""

from __future__ import annotations

import random
from collections import ChainMap
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from bt_mission.base.diagnostics import Diagnostic, describe, did_you_mean, listed, quoted
from bt_mission.base.yaml.document import Document
from bt_mission.language.expressions.expression import Expression, Template, Value, names_in
from bt_mission.language.expressions.outcomes import evaluate_constants
from bt_mission.language.expressions.places import place_of
from bt_mission.language.expressions.syntax import Name, SyntaxNode
from bt_mission.language.expressions.values import ExpressionError, Plain, Type, joined, type_of
from bt_mission.language.follow import Follow
from bt_mission.language.message_types import (
    MessageShape,
    Shape,
    UnknownField,
    field_at,
    too_much,
    value_type,
)
from bt_mission.language.mission import Tree
from bt_mission.language.nodes.base import NodeModel, Path, Write
from bt_mission.language.nodes.decorators import ForEachNode
from bt_mission.language.nodes.fields import NumberRule
from bt_mission.language.nodes.interfaces import InterfaceNode

OutputType = Callable[[InterfaceNode | Follow, str], Type | None]
"""The type of a field that is read of messages; None where it is not known."""

MOST_ELEMENTS = 100
"""Of the list of a `for_each`, for which a goal in it is checked."""


@dataclass
class Variables:
    """The names known at one node of a tree in a document.

    It changes as the tree is walked: use it at once.
    """

    document: Document
    inputs: Mapping[str, Plain]
    types: MutableMapping[str, Type | None]
    lines: Mapping[str, int]
    given: frozenset[str] = frozenset()
    """The inputs of this tree, which nobody writes."""
    followed: Mapping[str, int] = field(default_factory=dict)
    """Variables that follow a topic, with the line in which they do."""
    loops: dict[str, int] = field(default_factory=dict)
    """Variables that a `for_each` around this step goes through, with its line."""
    loop_values: dict[str, list[Plain]] = field(default_factory=dict)
    """The elements that these go through, where they are the same in every run."""
    left: dict[str, int] = field(default_factory=dict)
    """Those of a `for_each` that has ended, with its line."""

    def diagnostic(self, path: Path, error: ExpressionError, offset: int = 0) -> Diagnostic:
        """Return an error in an expression as one at its place in the document."""
        offset += error.column - 1
        return self.document.diagnostic(error.code, path, error.message, error.hint, offset=offset)

    def note(self, name: str, kind: Type | None) -> None:
        """Take in that a variable is written; where writers disagree, its type is not known."""
        self.types[name] = joined({self.types.get(name, kind), kind})

    def type_of(self, value: Value) -> Type | None:
        """Return the type of a value, as far as it is known."""
        if not isinstance(value, Expression):
            return type_of(value)
        try:
            return value.infer(lambda name: self.types.get(name.name))
        except ExpressionError:
            return None

    def elements(self, written: Value) -> list[Plain] | None:
        """Return the elements of a list; None where they are not the same in every run."""
        value: object = written
        if isinstance(written, Expression) and self.fixes(written.names) and not written.draws:
            try:
                value = written.evaluate(self.inputs, random.Random(0))
            except ExpressionError:
                return None
        return value if isinstance(value, list) else None

    def for_each_element(self, names: frozenset[str]) -> Iterator[Variables]:
        """Yield these variables with each value of a loop's variable among the names.

        Only these variables themselves are given where no such loop is around the step.
        """
        name = next((loop_name for loop_name in names if loop_name in self.loop_values), None)
        if name is None:
            yield self
            return
        for value in self.loop_values[name][:MOST_ELEMENTS]:
            others = {
                loop_name: values
                for loop_name, values in self.loop_values.items()
                if loop_name != name
            }
            inputs = {**self.inputs, name: value}
            yield from replace(self, inputs=inputs, loop_values=others).for_each_element(names)

    def fixed(self, name: str) -> str | None:
        """Return why a variable cannot be written here, or None."""
        if name in self.given:
            return f"'{name}' is an input, and inputs never change; choose another name"
        if name in self.followed:
            line = self.followed[name]
            why = f"'{name}' follows a topic, in line {line}; only the topic changes it"
            return f"{why}; choose another name"
        if name in self.loops:
            line = self.loops[name]
            return f"'{name}' is the variable of the for_each in line {line}; choose another name"
        return None

    def unknown(self, name: Name) -> tuple[str, str, str | None] | None:
        """Return code, message and hint for a name that is not known here, or None."""
        if name.name in self.types:
            return None
        if name.name in self.left:
            return (
                "BT-403",
                f"is defined only inside the for_each in line {self.left[name.name]}",
                None,
            )
        if name.name in self.lines:
            return "BT-403", f"is used before assignment, in line {self.lines[name.name]}", None
        why = f"is an undefined variable (defined: {listed(self.types)})"
        return "BT-402", why, did_you_mean(name.name, [*self.types, "true", "false"])

    def fixes(self, names: frozenset[str]) -> bool:
        """Return whether these names have the same values in every run of this mission."""
        return names <= self.inputs.keys()


class Visit(NamedTuple):
    """A node with the variables known at it, or `is_behind` what is below it."""

    node: NodeModel
    variables: Variables
    is_behind: bool = False


def walk(tree: Tree, output_type: OutputType) -> Iterator[Visit]:
    """Yield every node of a tree in the order of the file, with the variables known at it.

    A node that reads values behind what is below it comes there once more. Behind the last one,
    these are the variables known at the end of the tree.
    """
    lines: dict[str, int] = {}
    for node in tree.body.walk():
        for name in written_by(node):
            lines.setdefault(name, node.line)
    known: dict[str, Type | None] = dict.fromkeys(sorted(tree.lost))
    known |= tree.types
    known |= {
        followed_topic.variable: output_type(followed_topic, followed_topic.settings.field)
        for followed_topic in tree.follow
    }
    followed = {followed_topic.variable: followed_topic.line for followed_topic in tree.follow}
    given = frozenset(tree.types)
    variables = Variables(tree.document, tree.constants, known, lines, given, followed)
    yield from _walk(tree.body, variables, output_type)


def _walk(node: NodeModel, variables: Variables, output_type: OutputType) -> Iterator[Visit]:
    yield Visit(node, variables)
    if not isinstance(node, ForEachNode):
        for write in node.writes():
            variables.note(write.variable, _type_of(node, write, variables, output_type))
        for below in node.below:
            yield from _walk(below, variables, output_type)
        if any(read.is_behind for read in node.reads()):
            yield Visit(node, variables, is_behind=True)
        return
    types, loops, name = variables.types, variables.loops, node.variable
    # A name that is taken already has its own diagnostic, and keeps its type.
    shadowed = {name: types[name]} if name in types else {}
    around = {name: loops[name]} if name in loops else {}
    elements = variables.elements(node.elements)
    types[name] = None if elements is None else joined({type_of(element) for element in elements})
    loops[name] = node.line
    if elements and not shadowed:
        variables.loop_values[name] = elements
    yield from _walk(node.child, variables, output_type)
    del types[name]
    variables.loop_values.pop(name, None)
    variables.left[name] = loops.pop(name)
    types.update(shadowed)
    loops.update(around)


def _type_of(
    node: NodeModel, write: Write, variables: Variables, output_type: OutputType
) -> Type | None:
    if write.value is not None:
        return variables.type_of(write.value)
    if isinstance(node, InterfaceNode):
        return output_type(node, str(write.path[-1]))
    return write.type


def written_by(node: NodeModel) -> tuple[str, ...]:
    """Return the variables that a node writes for the nodes behind it."""
    if isinstance(node, ForEachNode):
        return ()
    return tuple(write.variable for write in node.writes())


def node_diagnostics(visit: Visit) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names and types in a node, messages left out."""
    node, variables, is_behind = visit
    around = variables
    for path, value, wanted, assigns, is_read_behind in node.reads():
        if is_read_behind != is_behind:
            continue
        place = (*node.path, *path)
        if isinstance(value, Template):
            yield from template_diagnostics(place, value, around)
        elif isinstance(value, Expression):
            if isinstance(wanted, NumberRule):
                yield from number_diagnostics(place, value, around, wanted)
            else:
                yield from expression_diagnostics(place, value, around, wanted)
        if assigns is not None:
            if around is variables:
                around = replace(variables, types=ChainMap({}, variables.types))
            around.note(assigns, around.type_of(value))
    if not is_behind:
        yield from _naming_diagnostics(node, variables)


def _naming_diagnostics(node: NodeModel, variables: Variables) -> Iterator[Diagnostic]:
    """Yield the variables that a node must not write."""
    for path, name, what, *_ in node.writes():
        why = variables.fixed(name)
        if isinstance(node, ForEachNode):
            is_known = name in variables.types
            why = f"'{name}' is already a variable; choose another name" if is_known else None
        if why is not None:
            yield variables.document.diagnostic(
                "BT-408", (*node.path, *path), why, key=what == "variable"
            )


def number_diagnostics(
    path: Path, value: Expression, variables: Variables, rule: NumberRule
) -> Iterator[Diagnostic]:
    """Yield what is wrong with an expression that must give a number."""
    if value.draws or not variables.fixes(value.names):
        yield from expression_diagnostics(path, value, variables, rule.type, expected=rule.words)
        return
    try:
        result = value.evaluate(variables.inputs, random.Random(0))
    except ExpressionError as error:
        yield variables.diagnostic(path, error)
        return
    if not rule.allows(result):
        yield variables.document.diagnostic(
            rule.code_of(result), path, rule.refuses(describe(result), result)
        )


def expression_diagnostics(
    path: Path,
    value: Expression,
    variables: Variables,
    wanted: Type | None,
    message: MessageShape | None = None,
    offset: int = 0,
    expected: str | None = None,
) -> Iterator[Diagnostic]:
    """Yield the names in an expression that are not known, or else the clash of types in it.

    Args:
        path: Where it stands.
        value: The expression.
        variables: Those known there.
        wanted: The type that it must have; None where every type will do.
        message: The message whose fields come before variables, in a condition on messages.
        offset: Of the expression in its text.
        expected: The expected value, as a phrase; a single unknown word is compared with it.
    """
    loose = _loose_word(value.root, variables, expected)
    if loose is not None:
        yield variables.diagnostic(path, loose, offset)
        return
    diagnostics = list(reference_diagnostics(path, value.references, variables, message, offset))
    yield from diagnostics
    if diagnostics:
        return

    def type_at(name: Name) -> Type | None:
        shape = _field(message, name)
        return variables.types.get(name.name) if shape is None else value_type(shape)

    def is_constant(name: Name) -> bool:
        return name.name in variables.inputs and _field(message, name) is None

    try:
        if wanted is None:
            value.infer(type_at)
        else:
            value.root.expect(type_at, wanted)
        evaluate_constants(value.root, variables.inputs, is_constant, wanted)
    except ExpressionError as error:
        yield variables.diagnostic(path, error, offset)


def _loose_word(
    root: SyntaxNode, variables: Variables, expected: str | None
) -> ExpressionError | None:
    """Return what is wrong with one word that is no variable, or None."""
    named = place_of(root)
    word = root if named is None else named[0]
    if not expected or not isinstance(word, Name) or word.variable:
        return None
    unknown = variables.unknown(word)
    if unknown is None or named is not None:
        return None if unknown is None or named is None else named[1].unknown(word.name)
    code, why, hint = unknown
    message = f"expected {expected}, got {quoted(word.name)}, which {why}"
    return ExpressionError(code, message, 1, hint)


def reference_diagnostics(
    path: Path,
    references: Iterable[Name],
    variables: Variables,
    message: MessageShape | None = None,
    offset: int = 0,
    *,
    is_on_messages: bool = False,
) -> Iterator[Diagnostic]:
    """Yield a diagnostic for every name that is neither a field nor a known variable.

    `is_on_messages` allows fields that are not known.
    """
    may_be_field = message is not None or is_on_messages
    for name in references:
        if message is not None and not name.variable:
            try:
                shape = field_at(message, name.name)
            except UnknownField as error:
                if name.name not in variables.types:
                    wrong = ExpressionError(error.code, error.message, name.column, error.hint)
                    yield variables.diagnostic(path, wrong, offset)
                continue
            if isinstance(shape, MessageShape):
                wrong = ExpressionError("BT-502", too_much(name.name, shape), name.column)
                yield variables.diagnostic(path, wrong, offset)
        elif (unknown := variables.unknown(name)) is not None:
            code, why, hint = unknown
            if hint is None and name.variable and may_be_field:
                hint = f"a field is written without '$': {name.name}"
            wrong = ExpressionError(code, f"'{name.shown}' {why}", name.column, hint)
            yield variables.diagnostic(path, wrong, offset)


def _field(message: MessageShape | None, name: Name) -> Shape | None:
    """Return the field of a message that a name stands for, or None."""
    if message is None or name.variable:
        return None
    try:
        return field_at(message, name.name)
    except UnknownField:
        return None


def template_diagnostics(path: Path, value: Template, variables: Variables) -> Iterator[Diagnostic]:
    """Yield what is wrong with the names in a template."""
    for hole in value.holes:
        yield from expression_diagnostics(
            path, hole.expression, variables, hole.wanted, offset=hole.offset
        )


def names_read(node: NodeModel) -> frozenset[str]:
    """Return every variable that a node may read."""
    read = [names_in(value_read.value) for value_read in node.reads()]
    if isinstance(node, InterfaceNode):
        read += [names_in(node.sent), names_in(node.condition)]
    return frozenset().union(*read)
