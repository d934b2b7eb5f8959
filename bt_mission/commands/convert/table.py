"""The table of nodes: each element of XML with the node of a mission that means the same.

A row holds an element, and its node as a mission file has it, with columns in the places of what
attributes and elements below give. `document` fills a row's columns from an element, and
`mission_writer` finds the row that a node fits. The rows of our own leaves, `<turn angle="90"
timeout="30"/>`, follow from the schemas of their classes.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import Any, Literal, TypeAlias

from bt_mission.commands.convert.attributes import (
    AS_IT_IS,
    MILLISECONDS,
    OUTPUT,
    TEXT,
    TIMES,
    VALUE,
    Codec,
    given,
)
from bt_mission.commands.convert.scripts import ASSIGNMENTS, CONDITION
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.nodes.base import CompositeNode, NodeModel
from bt_mission.language.nodes.fields import VARIABLE
from bt_mission.language.nodes.interfaces import InterfaceNode
from bt_mission.language.nodes.registry import KINDS

FORMAT = "4"
SUBTREE = "SubTree"
"""The use of a named tree, whose ports depend on the tree."""

TREE_NAME = "tree"
"""The attribute of `Metadata` with the name of a tree whose ID had to be another one."""

REQUIREMENT = "requirement"
"""The attribute of `Metadata` with the name of a requirement of the mission."""

OUT = "out_"
"""Begins the attributes that name a variable for something that a leaf gives."""

_NESTED = "__"
"""Stands between the names of nested fields; no ROS field has it in its name."""

_GOAL = "goal__"
"""May stand before the fields of a goal, and must where a modifier has the same name."""

_DEEPEST = 50
"""Fields within each other."""

_FIELD = re.compile(r"[a-z](?:_?[a-z0-9])*")

Names = tuple[str, ...]
Refusal = tuple[str, str]
"""Parts of missions without a counterpart in XML, with what to write instead."""


# ---- columns ---------------------------------------------------------------------------------


@dataclass(frozen=True)
class Port:
    """One attribute. `refusal` is for values without a counterpart; else another row is tried."""

    name: str
    codec: Codec
    is_needed: bool = False
    refusal: Refusal | None = None


@dataclass(frozen=True)
class Ports:
    """A mapping with an attribute for each entry: a prefix and the name of the entry.

    Attributes:
        prefix: What the attributes begin with.
        codec: How their values are written.
        holds: Names of variables or attributes, dotted fields, or nested fields.
        taken: Attributes of the element that have another meaning; fields without one of these
            names need no prefix. None if every attribute needs it.
    """

    prefix: str
    codec: Codec
    holds: Literal["names", "dotted", "nested"]
    taken: frozenset[str] | None = None

    @property
    def title(self) -> str:
        """The attributes, in a list of those that an element takes."""
        if self.taken is not None:
            return "fields of the goal"
        return self.prefix + ("NAME" if self.prefix in ("set_", "in_") else "FIELD")

    def path(self, attribute: str) -> Names | None:
        """Return the keys of the entry that an attribute gives, or None."""
        is_short = self.taken is not None and attribute not in self.taken
        is_short &= not attribute.startswith(OUT)
        if not (is_short or attribute.startswith(self.prefix)):
            return None
        name = attribute.removeprefix(self.prefix)
        if self.holds == "dotted":
            return (name.replace(_NESTED, "."),)
        path: Names = (name,)
        pattern = VARIABLE
        if self.holds == "nested":
            path, pattern = tuple(name.split(_NESTED)), _FIELD
        return path if len(path) <= _DEEPEST and all(map(pattern.fullmatch, path)) else None

    def attribute(self, path: Names) -> str | None:
        """Return the attribute that gives an entry, or None."""
        name = _NESTED.join(path)
        if self.holds == "dotted":
            return self.prefix + name.replace(".", _NESTED)
        if self.holds == "nested" and not all(map(_FIELD.fullmatch, path)):
            return None
        is_long = self.taken is None or name in self.taken or name.startswith((OUT, self.prefix))
        return self.prefix + name if is_long else name


@dataclass(frozen=True)
class Child:
    """The node of one element below; an element `absent` without attributes stands for none."""

    index: int = 0
    absent: str | None = None


@dataclass(frozen=True)
class Question:
    """The condition of one element below, which asks nothing else, or its opposite."""

    index: int = 0
    is_negated: bool = False


@dataclass(frozen=True)
class Children:
    """The nodes of all elements below; `skips` is the kind that passes over skipped ones."""

    skips: str | None = None


@dataclass(frozen=True)
class AllButLast:
    """The node of all elements below but the last one."""


@dataclass(frozen=True)
class Blackboard:
    """The value for one variable, each of which is an attribute."""

    key: Port
    value: Port


@dataclass(frozen=True)
class Never:
    """A key without a counterpart, unless it has this value."""

    refusal: Refusal
    unless: Any = None


Below: TypeAlias = Child | Question | Children | AllButLast
Column: TypeAlias = Port | Ports | Blackboard | Never | Below


# ---- rows ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Row:
    """An element, and the node that means the same.

    Attributes:
        tag: The element.
        node: The node: its kind first, then its modifiers, each a constant or a column.
        fixed: Attributes that have these values in this row.
        is_written: Whether nodes are written so; else another row writes them.
        is_leaf: Whether it is a leaf of missions.
    """

    tag: str
    node: Mapping[str, Any]
    fixed: Mapping[str, str] = field(default_factory=dict)
    is_written: bool = True
    is_leaf: bool = False

    @property
    def kind(self) -> str:
        """The kind of the node."""
        return next(iter(self.node))

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """Its columns, in the order of the node."""
        return tuple(_columns(self.node))

    @property
    def takes(self) -> tuple[str, ...]:
        """All attributes that the element takes, for people."""
        columns = (column for column in self.columns if isinstance(column, Port | Ports))
        titles = (port.name if isinstance(port, Port) else port.title for port in columns)
        return (*titles, *self.fixed, "name")

    @cached_property
    def children(self) -> int | None:
        """How many elements are below; None for any number."""
        if any(isinstance(column, Children | AllButLast) for column in self.columns):
            return None
        below = (column for column in self.columns if isinstance(column, Child | Question))
        return len({column.index for column in below})


def _columns(part: Any) -> Iterator[Column]:
    if isinstance(part, Blackboard):
        yield from (part, part.value, part.key)
    elif isinstance(part, Mapping):
        for inner in part.values():
            yield from _columns(inner)
    elif isinstance(part, list):
        for inner in part:
            yield from _columns(inner)
    elif isinstance(part, Column.__args__):
        yield part


@dataclass(frozen=True)
class Choice:
    """An attribute with a few values: its default, and the message for another value."""

    default: str
    message: str
    hint: str | None = None


_COUNT = "expected 1 or -1 (all), got {}"
_FINALLY = "write the mission in YAML, with 'finally'"
CHOICES = {
    "success_count": Choice("-1", _COUNT),
    "failure_count": Choice("1", _COUNT),
    "max_failures": Choice("1", _COUNT),
    "else": Choice("FAILURE", "expected SUCCESS or FAILURE, got {}"),
    "catch_on_halt": Choice("false", "'catch_on_halt' has no counterpart", _FINALLY),
}
"""The attributes that rows have fixed values of."""

NAME = Port("name", AS_IT_IS)
_EXPRESSION = ("a count that is an expression", "'set' a variable to it first, and give its name")
_CYCLES = Port("num_cycles", TIMES, True, _EXPRESSION)
_ATTEMPTS = Port("num_attempts", TIMES, True, _EXPRESSION)
_WHILE, _UNTIL = (
    Never((f"'{word}' of a repeat", "write 'count', or keep the mission in YAML"))
    for word in ("while", "until")
)
_PAUSED = "leave it out, or put a 'wait' before the node"
_PAUSE = Never(("a pause between attempts", _PAUSED), unless=0)
_SECONDS = "write a number of seconds with at most three decimals, or '$NAME / 1000'"
_NO_MILLISECONDS = ("a limit that is not a whole number of milliseconds", _SECONDS)
_LIMIT = Port("msec", MILLISECONDS, True, _NO_MILLISECONDS)
_DELAY = Port("delay_msec", MILLISECONDS, True)
_IF = Port("if", CONDITION, True)
_KEY = Port("output_key", AS_IT_IS, True)
_GUARD = {"guard": Question(), "do": Child(1)}
_ELSE = {"guard": Question(is_negated=True), "do": Child(2)}
_CATCH = {"force": "failure", "do": Child(-1)}


def _in_turn(kind: str, tag: str) -> tuple[Row, ...]:
    return (
        Row(tag, {kind: Children(kind)}),
        Row(f"Reactive{tag}", {kind: Children(kind), "memory": False}),
        Row(f"Async{tag}", {kind: Children(kind)}, is_written=False),
    )


def _parallel(succeed: str, fail: str, rest: str, tag: str, **fixed: str) -> Row:
    policy = {"succeed_when": succeed, "fail_when": fail, "rest": rest}
    settings = {key: word for key, word in policy.items() if word != default_of("parallel", key)}
    return Row(tag, {"parallel": Children(), **settings}, fixed)


def default_of(kind: str, key: str) -> Any:
    """Return the value of a modifier that is left out."""
    return next(
        (
            info.default
            for name, info in KINDS[kind].model_fields.items()
            if key == (info.alias or name)
        ),
        None,
    )


_ROWS = (
    *_in_turn("sequence", "Sequence"),
    *_in_turn("fallback", "Fallback"),
    _parallel("all", "any", "halt", "Parallel", success_count="-1", failure_count="1"),
    _parallel("any", "any", "halt", "Parallel", success_count="1", failure_count="1"),
    _parallel("any", "impossible", "halt", "Parallel", success_count="1", failure_count="-1"),
    _parallel("all", "impossible", "halt", "Parallel", success_count="-1", failure_count="-1"),
    _parallel("all", "any", "finish", "ParallelAll", max_failures="1"),
    _parallel("any", "impossible", "finish", "ParallelAll", max_failures="-1"),
    Row("Repeat", {"repeat": {"count": _CYCLES, "while": _WHILE, "until": _UNTIL}, "do": Child()}),
    Row("KeepRunningUntilFailure", {"repeat": {"while": True}, "do": Child()}, is_written=False),
    Row("RetryUntilSuccessful", {"retry": {"attempts": _ATTEMPTS, "pause": _PAUSE}, "do": Child()}),
    Row("Timeout", {"timeout": _LIMIT, "do": Child()}),
    Row("Inverter", {"invert": Child()}),
    Row("ForceSuccess", {"force": "success", "do": Child()}),
    Row("ForceFailure", {"force": "failure", "do": Child()}),
    Row("WhileDoElse", _GUARD),
    # One of the two guards goes on at a time.
    Row("WhileDoElse", {"fallback": [_GUARD, _ELSE], "memory": False}, is_written=False),
    Row("Precondition", {"when": _IF, "do": Child()}, {"else": "SUCCESS"}),
    Row("Precondition", {"sequence": [{"check": _IF}, Child()]}, {"else": "FAILURE"}, False),
    Row("IfThenElse", {"when": Question(), "do": Child(1), "else": Child(2, "AlwaysSuccess")}),
    # Without a third child it fails where the condition is false.
    Row("IfThenElse", {"sequence": [{"check": Question()}, Child(1)]}, is_written=False),
    # What is done after a failure, which it stays.
    Row("TryCatch", {"fallback": [AllButLast(), _CATCH]}, {"catch_on_halt": "false"}, False),
    Row("AlwaysSuccess", {"check": True}),
    Row("AlwaysFailure", {"check": False}),
    Row("ScriptCondition", {"check": Port("code", CONDITION, True)}),
    Row("Script", {"set": Port("code", ASSIGNMENTS, True)}),
    Row("SetBlackboard", {"set": Blackboard(_KEY, Port("value", VALUE))}, is_written=False),
    Row("Sleep", {"wait": Port("msec", MILLISECONDS, True)}),
    Row("Delay", {"sequence": [{"wait": _DELAY}, Child()]}, is_written=False),
)

_LOOP = "write 'for_each', which only YAML has"
_UPDATE = "variables have no time stamp; use a leaf 'wait_for' on a topic"
WITHOUT_COUNTERPART = {
    **dict.fromkeys(("LoopBool", "LoopDouble", "LoopInt", "LoopString"), _LOOP),
    "RunOnce": "write 'Precondition' on a variable that a 'Script' sets",
    "SequenceWithMemory": "use a 'Sequence', which restarts after a failure",
    "SubTreePlus": "write 'SubTree'",
    **dict.fromkeys(("SkipUnlessUpdated", "WaitValueUpdate", "WasEntryUpdated"), _UPDATE),
    **{f"Switch{count}": "write an IfThenElse for each case" for count in range(2, 7)},
    "UnsetBlackboard": "set the variable to a value that means 'not set'",
}
"""The nodes of BehaviorTree.CPP that no mission has, each with what to write instead."""

_NAV2 = "it is a control node of Nav2"
_PLANS = f"{_NAV2}; the server of 'navigate_to_pose' repeats its planning"
_V3 = "it is a node of BehaviorTree.CPP 3"
OTHERS_WITHOUT_COUNTERPART = {
    "PipelineSequence": f"{_PLANS}; for other actions write 'Parallel', or 'Sequence' if the first "
    "children need not run again",
    "RecoveryNode": f"{_NAV2}; write 'RetryUntilSuccessful' over a 'Fallback' of the first child "
    "and the second one in 'ForceFailure' (bt-mission docs groot)",
    "RoundRobin": f"{_NAV2}; write a 'Fallback', which always begins with its first child",
    "NonblockingSequence": f"{_NAV2}; write 'Parallel'",
    **dict.fromkeys(
        ("RateController", "DistanceController", "SpeedController", "GoalUpdater"), _PLANS
    ),
    "PathLongerOnApproach": _PLANS,
    "SingleTrigger": f"{_NAV2}; write 'Precondition' on a variable that a 'Script' sets",
    "SequenceStar": f"{_V3}, which continues with the child that failed; use a 'Sequence', which "
    "restarts after a failure",
    "FallbackStar": f"{_V3}; write 'Fallback'",
    **dict.fromkeys(
        ("BlackboardCheckInt", "BlackboardCheckDouble", "BlackboardCheckString"),
        f"{_V3}; write 'Precondition'",
    ),
    "BlackboardCheckBool": f"{_V3}; write 'Precondition'",
}
"""Control nodes of other packages and versions, which no leaf replaces."""

ELEMENTS = tuple(dict.fromkeys(row.tag for row in _ROWS))
"""The nodes of BehaviorTree.CPP that have a counterpart."""

REGISTERED = frozenset((*ELEMENTS, SUBTREE, *WITHOUT_COUNTERPART)) - {"SubTreePlus"}
"""The built-in nodes of a factory of BehaviorTree.CPP 4."""


def rows_of(tag: str) -> tuple[Row, ...]:
    """Return the rows of an element."""
    leaf = leaf_row(tag)
    return (leaf,) if leaf else tuple(row for row in _ROWS if row.tag == tag)


def rows_for(kind: str) -> tuple[Row, ...]:
    """Return the rows that nodes of a kind may be written as, the first that fits before others."""
    rows = tuple(row for row in _ROWS if row.is_written and row.kind == kind)
    leaf = leaf_row(kind)
    return (*rows, leaf) if leaf else rows


def tree_row(name: Codec, inputs: Mapping[str, str], outputs: Iterable[str]) -> Row:
    """Return the row of the use of a named tree.

    Args:
        name: How the name of the tree is read from its ID, and written as it.
        inputs: The types of its inputs, in our words.
        outputs: The names of its outputs.
    """
    hint = "'set' a variable to it first, and give that"
    takes = {
        key: Port(key, given(word), refusal=(f"the value of '{key}'", hint))
        for key, word in inputs.items()
    }
    gives = {key: Port(key, OUTPUT) for key in outputs}
    return Row(SUBTREE, {"tree": {"name": Port("ID", name), "inputs": takes}, "outputs": gives})


# ---- our leaves ------------------------------------------------------------------------------


def leaf_kinds() -> tuple[str, ...]:
    """Return every kind of leaf but `tree`, which is a SubTree."""
    return tuple(kind for kind in KINDS if leaf_row(kind))


def leaf_row(kind: str) -> Row | None:
    """Return the row of a kind of leaf; None for anything else."""
    model = KINDS.get(kind)
    if model is None or kind == "tree" or model.child_keys or issubclass(model, CompositeNode):
        return None
    return _leaf_row(kind, model)


@cache
def _leaf_row(kind: str, model: type[NodeModel]) -> Row:
    """Return the row of a leaf: its attributes are the fields of its class and of its settings."""
    schema = model.model_json_schema()
    written = {key: part for key, part in schema["properties"].items() if key != "name"}
    value = written.pop(kind)
    settings = "$ref" in value and schema["$defs"][value["$ref"].rpartition("/")[2]]["properties"]
    modifiers: dict[str, Column] = {
        key: Port(key, _codec(part)) for key, part in written.items() if not _is_object(part)
    }
    if "inputs" in written:
        modifiers["inputs"] = Ports("in_", VALUE, "names")
    if "outputs" in written:
        is_message = issubclass(model, InterfaceNode)
        modifiers["outputs"] = Ports(OUT, OUTPUT, "dotted" if is_message else "names")
    own: Any
    if settings:
        own = {
            key: Ports(f"{key}{_NESTED}", VALUE, "nested")
            if _is_object(part)
            else Port(kind if key == "name" else key, _codec(part))
            for key, part in settings.items()
        }
    elif kind in ACTION_NAMES:
        own = Ports(_GOAL, VALUE, "nested", frozenset((*modifiers, "name")) - {"outputs"})
    elif _is_object(value):
        own = Ports(f"{kind}_", VALUE, "names")
    else:
        fields = model.model_fields.items()
        name = next(name for name, info in fields if info.alias == kind)
        own = Port(name, _codec(value), is_needed=True)
    return Row(kind, {kind: own, **modifiers}, is_leaf=True)


def _is_object(schema: Mapping[str, Any]) -> bool:
    return schema.get("type") == "object"


def _codec(schema: Mapping[str, Any]) -> Codec:
    return TEXT if schema.get("type") == "string" else VALUE
