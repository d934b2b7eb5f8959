"""Expressions, requirements, units, goals and nodes with what they mean or what is wrong with them.

One file of `transcripts` for each. An error has its column, its message and its hint.
"""

from __future__ import annotations

import json
import math
import random
from collections.abc import Callable
from typing import Any

import pytest

from bt_mission.base.diagnostics import InputError, in_order
from bt_mission.base.yaml.document import read_text
from bt_mission.language.checks.mission import tree_diagnostics
from bt_mission.language.expressions.expression import Expression, Template
from bt_mission.language.expressions.outcomes import outcomes, range_of
from bt_mission.language.expressions.syntax import Name
from bt_mission.language.expressions.values import ExpressionError, Type
from bt_mission.language.inputs import overridden
from bt_mission.language.message_types import (
    InterfaceShapes,
    ListOf,
    MessageShape,
    Scalar,
    UnknownType,
    conform,
)
from bt_mission.language.node_reader import NodeReader
from bt_mission.requirements.language.formula import Formula
from bt_mission.sessions.load import load
from tests.support.transcripts import assert_transcript, transcripts_of

NAMES: dict[str, Any] = {
    "n": 2,
    "x": 0.125,
    "t": True,
    "s": "word",
    "list": [1, [2, 3], 4],
    "empty": [],
    "later": 1,
    "distance": math.inf,
    "pose": {"x": 1},
}
TYPES: dict[str, Type] = {"n": "integer", "x": "number", "t": "bool", "s": "text"}
TYPES |= {"list": "list", "empty": "list", "distance": "number"}


def as_line(error: ExpressionError) -> str:
    """Return column, message and hint of an error."""
    return f"{error.column}: {error.message}" + (f"; {error.hint}" if error.hint else "")


def expression(text: str) -> str:
    """Return the type and the value of an expression, or what is wrong before and during a run."""
    try:
        parsed = Expression(text)
    except ExpressionError as error:
        return as_line(error)
    try:
        kind: str = parsed.infer(lambda name: TYPES.get(name.name)) or "unknown"
    except ExpressionError as error:
        kind = as_line(error)
    try:
        return f"{kind}: {parsed.evaluate(NAMES, random.Random(0))!r}"
    except ExpressionError as error:
        return f"{kind}\nin a run: {as_line(error)}"


def template(text: str) -> str:
    """Return what a text with expressions in it becomes."""
    try:
        return f"'{Template(text).evaluate(NAMES, random.Random(0))}'"
    except ExpressionError as error:
        return as_line(error)


RANGES = {"angle": (0.0, 90.0), "left": (-5.0, 5.0), "count": (3.0, 3.0), "gap": (0.0, math.inf)}


def condition(text: str) -> str:
    """Return what a condition can be, or a number's range, where the numbers in it have ranges."""

    def find(name: Any) -> tuple[float, float] | None:
        return RANGES.get(name.name) if isinstance(name, Name) else None

    root = Expression(text).root
    possible = " or ".join(str(value).lower() for value in sorted(outcomes(root, find)))
    low, high = range_of(root, find)
    return f"{possible}; from {low} to {high}"


def unit(line: str) -> str:
    """Return the value of `expression -> unit`."""
    text, _, name = line.partition(" ->")
    try:
        value = Expression(text).in_unit(name.strip()).evaluate({"x": 2.0}, random.Random(0))
    except ExpressionError as error:
        return as_line(error)
    return f"{value:.9g}"


def requirement(line: str) -> str:
    """Return whether a requirement is valid, alone or in the line of a mission."""
    try:
        if not line.startswith("a: "):
            Formula(line)
            return "valid"
        load(
            f"mission: tour\ninputs: {{most: 0.2}}\nrequirements:\n  {line}\ntree:\n  sequence:\n"
            "    - {turn: {angle: 90}, name: look around}\n    - {wait: 1, name: visit A}\n"
        )
    except ExpressionError as error:
        return as_line(error)
    except InputError as error:
        return "\n".join(
            f"{each.line}:{each.column}: {each.headline}" for each in error.diagnostics
        )
    return "valid"


FLOAT = Scalar("float32", "number", -3.4e38, 3.4e38)
INT = Scalar("int8", "integer", -128, 127)
POINT = MessageShape("geometry_msgs/Point", {"x": FLOAT, "y": FLOAT, "z": FLOAT})
GOAL = MessageShape(
    "the goal of a/action/B",
    {
        "speed": FLOAT,
        "count": INT,
        "on": Scalar("bool", "bool"),
        "label": Scalar("string<=5", "text", most=5),
        "three": ListOf(FLOAT, size=3),
        "few": ListOf(INT, most=2),
        "poses": ListOf(MessageShape("geometry_msgs/PoseStamped", {})),
        "inner": MessageShape("a/Inner", {"x": FLOAT}),
        "at": POINT,
        "limit": MessageShape("builtin_interfaces/Duration", {"sec": INT, "nanosec": INT}),
    },
)
SHAPES = InterfaceShapes(
    GOAL,
    MessageShape(
        "the result of a/action/B", {"far": FLOAT, "word": GOAL.fields["label"], "at": POINT}
    ),
    MessageShape(
        "the feedback of a/action/B",
        {
            "now": FLOAT,
            "steps": INT,
            "at": POINT,
            "all": ListOf(FLOAT),
            "done": Scalar("b", "bool"),
        },
    ),
)


def action(line: str) -> str:
    """Return what is wrong with `goal: ...` or another key of an action, and at which text."""
    goal, modifier = (line[6:], "timeout: 9") if line.startswith("goal: ") else ("{}", line)
    mission = load(
        "mission: m\ninputs: {n: 2, word: hi, xs: [1, 2]}\ntree:\n  sequence:\n"
        f"    - action: {{name: /b, type: a/action/B, goal: {goal}}}\n      {modifier}\n"
        f"    - {'log: $y' if modifier.startswith('outputs') else 'wait: 1'}\n"
    )
    faults = tree_diagnostics(mission, lambda _: SHAPES)
    lines = [f"{each.source[each.column - 1 :]!r}: {each.message}" for each in faults]
    return "\n".join(lines) or "valid"


def message(line: str) -> str:
    """Return the values that a goal sends, which are given as JSON, or what is wrong with them."""
    problems: list[Any] = []
    values = conform(GOAL, json.loads(line), lambda *_: None, problems.append)
    return "\n".join(map(str, problems)) or json.dumps(values)


def node(text: str) -> str:
    """Return what is wrong with a node."""
    document = read_text(text, "n.yaml")
    reader = NodeReader(document)
    reader.node(document.data, ())
    return "\n".join(f"{each.message}; {each.hint}" for each in reader.diagnostics) or "valid"


def scope(line: str) -> str:
    """Return the errors or warnings of nodes in a sequence, with ` | ` between, from line 5 on.

    Inputs that no node reads are not mentioned.
    """
    nodes = "".join(f"    - {text}\n" for text in line.split(" | "))
    try:
        diagnostics = load(f"{SCOPE_HEAD}{nodes}").warnings
    except InputError as error:
        diagnostics = error.diagnostics
    lines = [str(each).splitlines()[0] for each in in_order(diagnostics) if each.line > 2]
    return "\n".join(line.removeprefix("<text>:") for line in lines) or "valid"


SCOPE_HEAD = "mission: m\ninputs: {n: 2, word: hello}\ntree:\n  sequence:\n"
INPUTS: dict[str, Any] = {
    "speed": 0.2,
    "legs": 6,
    "quiet": False,
    "place": "A",
    "zones": ["A", "B"],
}


def value(line: str) -> str:
    """Return the value of an input that is set, or the caret and the message."""
    name, _, text = line.partition("=")
    values, faults = overridden(INPUTS, {name: text})
    return "\n".join(map(str, faults)) or repr(values[name])


OUTPUTS: dict[str, Callable[[str], str]] = {
    "actions": action,
    "conditions": condition,
    "expressions": expression,
    "inputs": value,
    "messages": message,
    "nodes": node,
    "requirements": requirement,
    "scopes": scope,
    "templates": template,
    "units": unit,
}


@pytest.mark.parametrize("path", transcripts_of(__file__), ids=lambda path: path.stem)
def test_every_input_gives_the_output_of_its_transcript(path):
    """A value with its type, or the errors with their places."""
    assert_transcript(path, OUTPUTS[path.stem])


@pytest.mark.parametrize(
    ("outputs", "after", "expected"),
    [
        (["at.x"], "wait: abs(y)", []),
        (["word"], "wait: 2 * y", [(6, "expected a number, got a string")]),
        (["word", "at.x"], "wait: 2 * y", []),
    ],
    ids=["number", "string", "either, which has no type"],
)
def test_outputs_have_the_types_of_their_fields(outputs, after, expected):
    """What later nodes do with them is checked too."""
    nodes = "".join(
        f"    - action: {{name: /b, type: a/action/B}}\n      outputs: {{{output}: y}}\n"
        for output in outputs
    )
    mission = load(f"mission: m\ntree:\n  sequence:\n{nodes}    - {after}\n")
    faults = tree_diagnostics(mission, lambda _: SHAPES)
    assert [(fault.line, fault.message) for fault in faults] == expected


def test_an_unknown_type_has_the_place_of_the_type_and_hides_nothing_else():
    """With the nearest name; other actions are checked all the same."""

    def find(name):
        if name == "a/action/B":
            return SHAPES
        raise UnknownType("BT-501", f"the action type {name} is not installed", "did you mean 'x'?")

    mission = load(
        "mission: m\ntree:\n  sequence:\n"
        "    - action: {name: /c, type: a/action/C}\n"
        "    - turn: {angle: 9}\n"
        "    - action: {name: /b, type: a/action/B, goal: {what: 1}}\n"
    )
    results = list(tree_diagnostics(mission, find))
    assert [(fault.line, fault.column) for fault in results] == [(4, 32), (5, 7), (6, 51)]
    assert results[0].message == "the action type a/action/C is not installed"
    assert results[0].hint == "did you mean 'x'?"
