"""Actions against their types, with types made up for the purpose."""

import pytest

from bt_mission.language.checks.mission import tree_faults
from bt_mission.language.message_types import (
    InterfaceShapes,
    ListOf,
    MessageShape,
    Scalar,
    UnknownType,
)
from bt_mission.sessions.load import load

FLOAT = Scalar("float32", "number")
INT = Scalar("int32", "integer", -(2**31), 2**31 - 1)
BOOL = Scalar("bool", "bool")
TEXT = Scalar("string", "text")
POINT = MessageShape("geometry_msgs/Point", {"x": FLOAT, "y": FLOAT})
SHAPES = InterfaceShapes(
    MessageShape(
        "the goal of a/action/B", {"speed": FLOAT, "count": INT, "label": TEXT, "at": POINT}
    ),
    MessageShape("the result of a/action/B", {"far": FLOAT, "word": TEXT, "at": POINT}),
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


def faults(*modifiers, goal="{}", after="wait: 1", inputs="{n: 2, word: hi, xs: [1, 2]}"):
    """Return (line, text at the caret, message) of the faults in an action and what follows."""
    mission = load(
        f"mission: m\ninputs: {inputs}\ntree:\n  sequence:\n"
        f"    - action: {{name: /b, type: a/action/B, goal: {goal}}}\n"
        + "".join(f"      {line}\n" for line in modifiers)
        + f"    - {after}\n"
    )
    found = tree_faults(mission, lambda _: SHAPES)
    return [(fault.line, fault.source[fault.column - 1 :], fault.message) for fault in found]


def test_a_goal_that_fits_has_no_faults():
    """Constants, expressions of the right type, templates."""
    goal = '{speed: 1, count: n * 2, label: "$word-${n}.xml", at: {x: "uniform(0, 1)"}}'
    assert faults(goal=goal) == []


@pytest.mark.parametrize(
    ("goal", "caret", "message"),
    [
        (
            "{sped: 1}",
            "sped",
            "no field 'sped' in the goal of a/action/B (its fields: ",
        ),
        ("{speed: fast}", "fast", "expected a number (float32), got 'fast', which is "),
        ("{speed: 2 * nn}", "nn", "'nn' is an undefined variable (defined: n, word, xs)"),
        (
            "{speed: very fast}",
            "fast",
            "expected a number (float32) or an expression: ",
        ),
        ("{speed: n +}", "}", "expected a number, a name or a '(', got the end"),
        ("{speed: $word}", "$word", "expected a number (float32), got string 'hi'"),
        ("{speed: n > 1}", "n > 1", "expected a number (float32), got true"),
        ("{count: n / 2}", "n / 2", "expected an integer (int32), got 1.0"),
        ("{count: 'uniform(0, 9)'}", "uniform", "expected an integer, got a number"),
        ("{count: n ** 40}", "n **", "the number 1099511627776 is outside int32"),
        ("{speed: 1 / (n - 2)}", "/ (n", "division by zero"),
        ("{label: 5}", "5", "expected a string (string), got the number 5"),
        ("{label: '${n +}'}", "}'", "expected a number, a name or a '(', got the end"),
        ("{label: 'a ${1 / (n - 2)}'}", "/ (n", "division by zero"),
        ("{label: 'a ${nn}'}", "nn}", "'nn' is an undefined variable"),
        ("{at: [1, 2]}", "[1", "expected a point [x m, y m, z m], got a list of 2"),
        ("{at: $xs}", "$xs", "expected a point [x m, y m, z m], got a list of 2"),
        ("{at: {z: 1}}", "z:", "no field 'z' in geometry_msgs/Point (its fields: x, y)"),
    ],
)
def test_a_goal_that_does_not_fit(goal, caret, message):
    """Each fault stands at its value, and inside a text where it can be told."""
    ((line, at, found),) = faults(goal=goal)
    assert found.startswith(message)
    assert line == 5
    assert at.startswith(caret)


@pytest.mark.parametrize(
    "condition", ["now > 2", "at.x > 1 and not done", "len(all) > n", "$n < steps", "now > n"]
)
def test_conditions_on_the_feedback(condition):
    """Bare names are fields, dotted for nested ones; variables may help."""
    assert faults(f"cancel_when: {condition}") == []


@pytest.mark.parametrize(
    ("condition", "caret", "message"),
    [
        (
            "nwo > 2",
            "nwo",
            "no field 'nwo' in the feedback of a/action/B (its fields: ",
        ),
        ("at.z > 2", "at.z", "no field 'z' in geometry_msgs/Point (its fields: x, y)"),
        ("now.x > 2", "now.x", "'now.x': float32 has no fields of its own"),
        ("at > 2", "at", "'at' is a geometry_msgs/Point; name one of its fields: at.x, at.y"),
        ("now", "now", "expected a boolean, got a number"),
        ("now > word", "> word", "cannot compare a number with a string"),
        ("all > 2", "> 2", "cannot compare a list with an integer"),
        (
            "n > 2",
            "n > 2",
            "the condition reads no field of the feedback (now, steps, at, ",
        ),
    ],
)
def test_conditions_that_do_not_fit(condition, caret, message):
    """Names, types, and a condition that no feedback can change."""
    ((line, at, found),) = faults(f"cancel_when: {condition}")
    assert found.startswith(message)
    assert line == 6
    assert at.startswith(caret)


@pytest.mark.parametrize(
    ("output", "message"),
    [
        ("fra: x", "no field 'fra' in the result of a/action/B (its fields: far, word, at)"),
        ("at: x", "'at' is a geometry_msgs/Point; name one of its fields: at.x, at.y"),
        ("at.z: x", "no field 'z' in geometry_msgs/Point (its fields: x, y)"),
    ],
)
def test_outputs_that_the_result_does_not_have(output, message):
    """At the key that names the field."""
    ((line, at, found),) = faults(f"outputs: {{{output}}}", after="log: $x")
    assert (line, at, found) == (6, f"{output}}}", message)


def test_outputs_have_the_types_of_their_fields():
    """What later nodes do with them is checked too."""
    assert faults("outputs: {at.x: x}", after="wait: abs(x)") == []
    ((line, at, message),) = faults("outputs: {word: x}", after="wait: 2 * x")
    assert (line, at, message) == (7, "x", "expected a number, got a string")


def test_an_unknown_type_is_told_at_the_type_and_hides_nothing_else():
    """With the nearest name; other actions are checked all the same."""

    def find(name):
        if name == "a/action/B":
            return SHAPES
        raise UnknownType(f"the action type {name} is not installed", "did you mean 'x'?")

    mission = load(
        "mission: m\ntree:\n  sequence:\n"
        "    - action: {name: /c, type: a/action/C}\n"
        "    - turn: {angle: 9}\n"
        "    - action: {name: /b, type: a/action/B, goal: {what: 1}}\n"
    )
    found = list(tree_faults(mission, find))
    assert [(fault.line, fault.column) for fault in found] == [(4, 32), (5, 7), (6, 51)]
    assert found[0].message == "the action type a/action/C is not installed"
    assert found[0].hint == "did you mean 'x'?"
