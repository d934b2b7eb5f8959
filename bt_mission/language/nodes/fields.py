"""What each place of a mission file takes: the rules that models, loader and check share."""

from __future__ import annotations

import math
import random
import re
import shlex
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, TypeVar, cast

from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from bt_mission.base.actions import MOVED
from bt_mission.base.diagnostics import describe, did_you_mean, listed
from bt_mission.base.stamps import MOST_SECONDS
from bt_mission.base.units import converted
from bt_mission.language.expressions.expression import Expression, Template, Text
from bt_mission.language.expressions.parser import RESERVED, parse
from bt_mission.language.expressions.units import Measured, as_quantity, is_angle
from bt_mission.language.expressions.values import ExpressionError, LooseText, Type

VARIABLE = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_SHORT_TYPE = r"([a-z][a-z0-9_]*)/(?:(msg|srv|action)/)?([A-Z][A-Za-z0-9]*)"
"""The name of a type, also without its folder. Such patterns are compiled when they are used."""
_ROS_NAME = r"(~/|/)?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*"
_FACTORY = r"[\w./-]+\.py:[A-Za-z_]\w*|[A-Za-z_]\w*(\.\w+)*:[A-Za-z_]\w*"
_NODE_OR_PROGRAM = rf"{_FACTORY}|[\w./-]+\.py(\s[^\x00-\x1f]*)?"
_PROGRAM = r"[\w./-]+\.py|[A-Za-z_][\w-]*(\.\w+)*"
_TARGET = rf"{_FACTORY}|[A-Za-z_][\w-]*"
_TREE_NAME = r"[^\W\d][\w-]*"
_QUANTITY = r"[-+ ]*[.0-9]"
_FIELD = r"[a-z][a-z0-9_]*(\.[a-z][a-z0-9_]*)*"


Kind = TypeVar("Kind")


@dataclass(frozen=True)
class NumberRule:
    """A number with its limits; the lower one is a phrase."""

    words: str
    least: float
    most: float = math.inf
    itself: bool = True
    whole: bool = False
    unit: str = ""

    @property
    def type(self) -> Type:
        """The type that an expression here must have."""
        return "integer" if self.whole else "number"

    def allows(self, value: object) -> bool:
        """Return whether a computed value may stand here."""
        kind = int if self.whole else (int, float)
        if not isinstance(value, kind) or isinstance(value, bool) or not math.isfinite(value):
            return False
        enough = value >= self.least if self.itself else value > self.least
        return enough and value <= self.most

    def refuses(self, shown: str, value: object) -> str:
        """Return what is wrong with a value, which is shown like this."""
        if isinstance(value, int | float) and self.most < value < math.inf:
            return f"expected {self.words}, at most {self.most:,}, got {shown}"
        return f"expected {self.words}, got {shown}"

    @staticmethod
    def code_of(value: object) -> str:
        """Return the code of the error for a value that is not allowed."""
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return "BT-302" if is_number else "BT-301"

    def parse(self, value: Any) -> float | Expression:
        """Return a constant, or the expression that a text holds."""
        if isinstance(value, str):
            expression = parsed(Expression, value, self.words, self.unit)
            if not is_quantity(value):
                return expression
            value = expression.evaluate({}, random.Random(0))
        if not self.allows(value):
            raise refusal(self.refuses(describe(value), value), code=self.code_of(value))
        number: float = value
        return number

    def parse_constant(self, value: Any) -> float:
        """Return a constant, which may have a unit; here no expression may stand."""
        if self.unit and isinstance(value, str) and is_quantity(value):
            value = self.parse(value)
        if not self.allows(value):
            raise refusal(self.refuses(describe(value), value), code=self.code_of(value))
        return float(value)


MOST_WEIGHT = 1_000_000_000
"""So that the weights of all children have a finite sum."""

TIMES = NumberRule("an integer of at least 1", 1, whole=True)
SECONDS = NumberRule("seconds, 0 or more", 0, MOST_SECONDS, unit="s")
LIMIT = NumberRule("seconds above 0", 0, MOST_SECONDS, itself=False, unit="s")
WEIGHT = NumberRule("a weight above 0", 0, MOST_WEIGHT, itself=False)


def refusal(
    message: str, hint: str | None = None, offset: int | None = None, code: str = "BT-301"
) -> PydanticCustomError:
    """Return the error for pydantic that `model_diagnostics` turns into one with this text."""
    context: dict[str, Any] = {"message": message, "hint": hint, "offset": offset, "code": code}
    return PydanticCustomError("refused", "{message}", context)


def parsed(kind: Callable[[str], Kind], text: str, words: str = "", unit: str | None = "") -> Kind:
    """Return an expression or template of a text, its error turned into a refusal.

    `words` say what else could stand there. The quantities of an expression are numbers in the
    unit; with None they are unchanged.
    """
    try:
        parsed_value: Any = kind(text)
        is_settled = unit is not None and isinstance(parsed_value, Expression)
        return cast("Kind", parsed_value.in_unit(unit) if is_settled else parsed_value)
    except ExpressionError as error:
        loose = words and isinstance(error, LooseText)
        message = f"expected {words} or an expression: {error.message}" if loose else error.message
        raise refusal(message, error.hint, error.column - 1, error.code) from None


def is_quantity(text: str) -> bool:
    """Return whether a text is a number with a unit and nothing else."""
    try:
        return re.match(_QUANTITY, text) is not None and as_quantity(parse(text)[0]) is not None
    except ExpressionError:
        return False


def in_unit(unit: str) -> BeforeValidator:
    """Return what turns a number with a unit into the number of a field in this unit."""

    def rule(value: Any) -> Any:
        if isinstance(value, str) and is_quantity(value):
            return parsed(Expression, value, unit=unit).evaluate({}, random.Random(0))
        return value

    return BeforeValidator(rule, json_schema_input_type=float | str)


def condition(value: Any, example: str = "current_image >= 5") -> Expression:
    """Return the expression of a condition on a message, its quantities as they are."""
    if not isinstance(value, str):
        message = f"expected a condition such as '{example}', got {describe(value)}"
        raise refusal(message, code="BT-313")
    return parsed(Expression, value, unit=None)


def until(value: Any) -> Expression:
    """Return the expression of a condition on a message; `data` alone is one, too."""
    return condition(value, "percentage < 20")


def question(value: Any) -> Expression | bool:
    """Return the expression of a condition on variables; true and false are conditions, too."""
    return value if isinstance(value, bool) else condition(value, "$speed > 0.1").in_unit("")


def computed(value: Any) -> Any:
    """Return what a variable is set to: a constant, or the expression that a text holds."""
    if isinstance(value, str):
        return parsed(Expression, value)
    return plain(value)


def one_name(value: Any) -> Any:
    """Return a mapping that has one name in it."""
    if not isinstance(value, dict) or len(value) != 1:
        what = "one variable and a list, such as 'place: [1, 2]'"
        raise refusal(f"expected {what}, got {describe(value)}", code="BT-207")
    return value


def tree_use(value: Any) -> Any:
    """Return the use of a named tree; the name alone is one."""
    if isinstance(value, str):
        return {"name": value}
    if not isinstance(value, dict):
        example = "the name of a tree, or 'name' and 'inputs'"
        raise refusal(f"expected {example}, got {describe(value)}", code="BT-207")
    return value


def elements(value: Any) -> Any:
    """Return a list, whose texts are constants, or the expression that gives one."""
    if isinstance(value, str):
        return parsed(Expression, value)
    if not isinstance(value, list):
        message = f"expected a list, or an expression that gives one, got {describe(value)}"
        raise refusal(message, code="BT-313")
    return plain(value)


def message(value: Any) -> Template:
    """Return the template of a log message."""
    if not isinstance(value, str):
        raise refusal(f"expected a string, got {describe(value)}")
    return parsed(Template, value)


def goal_part(value: Any) -> Any:
    """Return a field of a goal, each text in it ready to be read as its field wants it."""
    match value:
        case str():
            return Text(value)
        case dict():
            return {key: goal_part(part) for key, part in value.items()}
        case list():
            return tuple(goal_part(part) for part in value)
        case None:
            raise refusal("expected a value, got nothing")
    return value


def printable(line: str) -> str:
    """Return a line that can be shown: no control characters, which would reach a terminal."""
    for index, character in enumerate(line):
        if not character.isprintable():
            message = f"expected characters that can be shown, got {character!a}"
            raise refusal(message, offset=index, code="BT-311")
    return line


def variable(name: Any) -> str:
    """Return the name of a variable."""
    variable_name = _variable_name(name)
    if variable_name in RESERVED:
        raise refusal(
            f"'{variable_name}' is a keyword of expressions, so it cannot be a variable",
            code="BT-312",
        )
    return variable_name


def plain(value: Any) -> Any:
    """Return the value of an input: a number, truth, a text, or a list of those."""
    if isinstance(value, list):
        for part in value:
            plain(part)
    elif value is None or isinstance(value, dict):
        message = f"expected a number, a boolean, a string or a list, got {describe(value)}"
        raise refusal(message)
    return value


def input_value(value: Any) -> Any:
    """Return the value of an input; a text that is a number with a unit is that number.

    In a list an angle is the yaw of a pose, the last of three numbers, in degrees.
    """
    match plain(value):
        case str() if is_quantity(value):
            quantity = as_quantity(parse(value)[0])
            assert quantity is not None
            return Measured(quantity.number, quantity.unit)
        case list():
            parts = [input_value(part) for part in value]
            for index, part in enumerate(parts):
                if isinstance(part, Measured) and is_angle(part.unit):
                    if (index, len(parts)) != (2, 3) or "/" in part.unit:
                        message = f"{value[index]}: an angle in a list is the yaw of a pose"
                        raise refusal(message, "write the number without a unit", code="BT-305")
                    parts[index] = converted(part, part.unit, "deg")
            return parts
    return value


def moved_parts(value: Any) -> tuple[str, ...]:
    """Return the parts of the robot that a goal moves: one, a list, or an empty list."""
    parts = value if isinstance(value, list) else [value]
    for part in parts:
        if part not in MOVED:
            hint = did_you_mean(part, MOVED) if isinstance(part, str) else None
            message = f"expected {listed(MOVED)}, a list of these, or [], got {describe(part)}"
            raise refusal(message, hint, code="BT-303")
    return tuple(parts)


def place(value: Any) -> Any:
    """Return a place on the map: x (m), y (m) and yaw (deg), as a list or by their names."""
    axes = {"x": "m", "y": "m", "yaw": "deg"}
    named = value if isinstance(value, dict) else None
    if isinstance(value, list) and len(value) in (2, 3):
        named = dict(zip(axes, value, strict=False))
    if named is None or not {"x", "y"} <= named.keys() <= axes.keys():
        expected = "a place such as [x m, y m, yaw deg] or {x: 1.0, y: 0.5, yaw: 90}"
        raise refusal(f"expected {expected}, got {describe(value)}", code="BT-314")
    return tuple(_coordinate(named.get(name, 0.0), unit) for name, unit in axes.items())


def _coordinate(value: Any, unit: str) -> float:
    if isinstance(value, str) and is_quantity(value):
        value = parsed(Expression, value, unit=unit).evaluate({}, random.Random(0))
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise refusal(f"expected a number, in {unit}, got {describe(value)}", code="BT-314")
    return float(value)


def text_rule(pattern: str, expected: str) -> Callable[[Any], str]:
    """Return the rule for texts of a pattern, which refuses others in these words."""

    def rule(value: Any) -> str:
        if not isinstance(value, str) or not re.fullmatch(pattern, value):
            raise refusal(f"expected {expected}, got {describe(value)}", code="BT-307")
        return value

    return rule


def _type_rule(folder: str, example: str) -> Callable[[Any], str]:
    """Return the rule for the full name of a type of an action, a service or a message."""
    rule = text_rule(rf"[a-z][a-z0-9_]*/{folder}/[A-Z][A-Za-z0-9]*", f"a type such as {example}")

    def with_folder(value: Any) -> str:
        parts = re.fullmatch(_SHORT_TYPE, value) if isinstance(value, str) else None
        if parts is not None and parts[2] != folder:
            hint = f"did you mean '{parts[1]}/{folder}/{parts[3]}'?"
            raise refusal(
                f"expected a type such as {example}, got {describe(value)}", hint, code="BT-307"
            )
        return rule(value)

    return with_folder


def message_field(value: Any) -> str:
    """Return the dotted name of a field of a message."""
    if isinstance(value, str) and re.fullmatch(_FIELD, value.partition("[")[0]) and "[" in value:
        hint = "follow the list, and write the index where the variable is read: NAME[0]"
        message = f"expected the name of a field, got {describe(value)}"
        raise refusal(message, hint, code="BT-307")
    return _message_field(value)


_message_field = text_rule(_FIELD, "the name of a field such as pose.position.x")
_variable_name = text_rule(VARIABLE.pattern, "a name of letters, digits and '_'")
tree_name = text_rule(_TREE_NAME, "a name of letters, digits, '_' and '-'")
result_field = text_rule(_FIELD, "the name of a result field")
python_target = text_rule(
    _TARGET, "'my_package.leaves:Approach', 'leaves.py:Approach' or the name of a plug-in"
)
node_factory = text_rule(
    _NODE_OR_PROGRAM, "'my_package.server:make', 'server.py:make' or a program, 'server.py'"
)


@dataclass(frozen=True)
class ProgramEntry:
    """A program in `nodes`, written as a mapping.

    Attributes:
        target: The file and its arguments, as on a command line.
        name: For people; empty is the name of the file.
    """

    target: str
    name: str


def node_entry(value: Any) -> str | ProgramEntry:
    """Return an entry of `nodes`: a factory or a program as text, or a program as a mapping."""
    if not isinstance(value, dict):
        return node_factory(value)
    if unknown := sorted(map(str, value.keys() - set(_ENTRY_KEYS))):
        hint = did_you_mean(unknown[0], _ENTRY_KEYS)
        raise refusal(f"unknown key '{unknown[0]}' (keys: {listed(_ENTRY_KEYS)})", hint)
    program, words = value.get("program"), value.get("arguments", [])
    if not isinstance(program, str) or not re.fullmatch(_PROGRAM, program):
        raise refusal(
            "program: expected a file such as 'server.py', a module or a console script, got "
            f"{describe(program)}"
        )
    if not isinstance(words, list) or any(isinstance(word, dict | list) for word in words):
        raise refusal(f"arguments: expected a list of words, got {describe(words)}")
    name = value.get("name", "")
    if not isinstance(name, str):
        raise refusal(f"name: expected a string, got {describe(name)}")
    return ProgramEntry(shlex.join([program, *map(_word, words)]), name)


def _word(value: Any) -> str:
    """Return an argument as it is written in YAML."""
    return str(value).lower() if isinstance(value, bool) else str(value)


_ENTRY_KEYS = ("program", "arguments", "name")

factory = text_rule(_FACTORY, "'my_package.server:make' or 'server.py:make'")
action_name = text_rule(_ROS_NAME, "the name of an action such as /turn")
action_type = _type_rule("action", "nav2_msgs/action/Spin")
service_name = text_rule(_ROS_NAME, "the name of a service such as /stop")
service_type = _type_rule("srv", "std_srvs/srv/Trigger")
topic_name = text_rule(_ROS_NAME, "the name of a topic such as /battery_state")
message_type = _type_rule("msg", "sensor_msgs/msg/BatteryState")


# ---- the types of fields ---------------------------------------------------------------------


@dataclass(frozen=True)
class Reads:
    """Marks a field whose value may read variables, with the rule or the type of that value."""

    wanted: NumberRule | Type | None = None


NUMBER_SCHEMA = WithJsonSchema({"type": ["number", "string"]})
TEXT_SCHEMA = WithJsonSchema({"type": "string"})
OBJECT_SCHEMA = WithJsonSchema({"type": "object", "minProperties": 1, "maxProperties": 1})

Times = Annotated[Any, PlainValidator(TIMES.parse), NUMBER_SCHEMA, Reads(TIMES)]
Seconds = Annotated[Any, PlainValidator(SECONDS.parse), NUMBER_SCHEMA, Reads(SECONDS)]
Limit = Annotated[Any, PlainValidator(LIMIT.parse), NUMBER_SCHEMA, Reads(LIMIT)]
FixedLimit = Annotated[float, PlainValidator(LIMIT.parse_constant), NUMBER_SCHEMA]
Observe = Annotated[
    float, PlainValidator(SECONDS.parse_constant), WithJsonSchema({"type": "number"})
]
Weight = Annotated[float, PlainValidator(WEIGHT.parse_constant), WithJsonSchema({"type": "number"})]
FeedbackCondition = Annotated[Any, PlainValidator(condition), TEXT_SCHEMA]
Condition = Annotated[
    Any, PlainValidator(question), WithJsonSchema({"type": ["string", "boolean"]}), Reads("bool")
]
Computed = Annotated[Any, PlainValidator(computed), WithJsonSchema({}), Reads()]
Elements = Annotated[
    Any, PlainValidator(elements), WithJsonSchema({"type": ["array", "string"]}), Reads("list")
]
Message = Annotated[Any, PlainValidator(message), TEXT_SCHEMA, Reads()]
ActionNameField = Annotated[str, PlainValidator(action_name), TEXT_SCHEMA]
Variable = Annotated[str, PlainValidator(variable), TEXT_SCHEMA]
TreeName = Annotated[str, PlainValidator(tree_name), TEXT_SCHEMA]
ResultField = Annotated[str, PlainValidator(result_field), TEXT_SCHEMA]
Factory = Annotated[str, PlainValidator(factory), TEXT_SCHEMA]
"""What makes something of the user's: a function or a class."""
NodeFactories = list[
    Annotated[
        str | ProgramEntry,
        PlainValidator(node_entry),
        WithJsonSchema(
            {
                "anyOf": [
                    {"type": "string"},
                    {
                        "type": "object",
                        "properties": {
                            "program": {"type": "string"},
                            "arguments": {"type": "array"},
                            "name": {"type": "string"},
                        },
                        "required": ["program"],
                        "additionalProperties": False,
                    },
                ]
            }
        ),
    ]
]
"""The factories of the user's nodes in a simulation, and programs."""
InputValue = Annotated[Any, PlainValidator(input_value), WithJsonSchema({})]
Place = Annotated[Any, PlainValidator(place), WithJsonSchema({"type": ["array", "object"]})]
GoalPart = Annotated[Any, PlainValidator(goal_part), WithJsonSchema({})]
Goal = dict[str, GoalPart]
MovedParts = Annotated[
    Any,
    PlainValidator(moved_parts),
    WithJsonSchema(
        {
            "anyOf": [
                {"enum": list(MOVED)},
                {"type": "array", "items": {"enum": list(MOVED)}},
            ]
        }
    ),
]
Line = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(printable)]
