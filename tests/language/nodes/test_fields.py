"""The rules for numbers, shared by models, loader and executive."""

import pytest
from pydantic_core import PydanticCustomError

from bt_mission.language.expressions.expression import Expression
from bt_mission.language.nodes import fields
from bt_mission.language.nodes.fields import LIMIT, SECONDS, TIMES, WEIGHT


@pytest.mark.parametrize(
    ("rule", "good", "bad"),
    [
        (TIMES, [1, 7], [0, -1, 1.0, True, "1", None]),
        (SECONDS, [0, 0.0, 2.5, 2**31 - 1], [-0.1, False, "1", None, float("nan"), 2**31]),
        (LIMIT, [0.001, 5, 1e9], [0, -1, True, None, float("nan"), 1e300]),
        (WEIGHT, [1e-300, 3, 1e9], [0, -1, True, None, float("nan"), 1e10]),
    ],
)
def test_a_rule_allows_what_it_says(rule, good, bad):
    """No truth values, no texts, no nan."""
    assert all(rule.allows(value) for value in good)
    assert not any(rule.allows(value) for value in bad)


def test_an_upper_limit_is_said_where_it_counts():
    """68 years are as long as a time of ROS can be; nobody is told who asks for less."""
    assert LIMIT.refuses("1e300", 1e300) == (
        "expected seconds above 0, at most 2,147,483,647, got 1e300"
    )
    assert LIMIT.refuses("0", 0) == "expected seconds above 0, got 0"


def test_a_text_is_an_expression():
    """Its value is measured when it is known."""
    assert LIMIT.parse("2 * x") == Expression("2 * x")


@pytest.mark.parametrize(
    ("text", "message", "offset"),
    [
        (
            "ten seconds",
            (
                "expected seconds above 0 or an expression: expected an operator or the end, "
                "got 'seconds'"
            ),
            4,
        ),
        ("2 * (3", "expected ')' for the '(' in '(3'", 6),
    ],
)
def test_words_are_told_from_formulas(text, message, offset):
    """Loose words hear what else could stand there; a broken formula only what breaks it."""
    with pytest.raises(PydanticCustomError) as caught:
        LIMIT.parse(text)
    context = caught.value.context
    assert context is not None
    assert (context["message"], context["offset"]) == (message, offset)


def test_where_no_expression_may_stand():
    """A text is refused as any other value."""
    with pytest.raises(PydanticCustomError, match="expected seconds above 0, got string '2'"):
        LIMIT.parse_constant("2")
    assert LIMIT.parse_constant(2) == 2.0


@pytest.mark.parametrize("name", ["turn", "/turn", "~/turn", "/robot1/turn", "a_1/b"])
def test_names_as_ros_has_them(name):
    """Relative, absolute, private."""
    assert fields.action_name(name) == name
    assert fields.service_name(name) == name
    assert fields.topic_name(name) == name


@pytest.mark.parametrize("name", ["", "/", "turn/", "a//b", "1st", "~turn", "a b", 5, None])
def test_what_is_no_name(name):
    """Each kind is told with an example of its own."""
    with pytest.raises(PydanticCustomError, match="expected the name of a topic such as /batt"):
        fields.topic_name(name)


def test_types_are_told_by_their_folder():
    """The type of a message is none of a service."""
    assert fields.service_type("std_srvs/srv/Trigger") == "std_srvs/srv/Trigger"
    assert fields.message_type("std_msgs/msg/Bool") == "std_msgs/msg/Bool"
    for rule, wrong in (
        (fields.service_type, "std_msgs/msg/Bool"),
        (fields.message_type, "std_msgs/Bool"),
        (fields.action_type, "std_srvs/srv/Trigger"),
    ):
        with pytest.raises(PydanticCustomError, match="expected a type such as "):
            rule(wrong)
