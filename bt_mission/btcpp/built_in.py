"""The kinds of nodes that BehaviorTree.CPP has as well: each as elements of XML, both ways."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_mission.btcpp.attributes import NAME, LocatedValue, located, mapping
from bt_mission.btcpp.elements import Tag
from bt_mission.btcpp.node_parts import NodeData, NodeElement, negated
from bt_mission.btcpp.scripts import ScriptError, assignments, written_assignments
from bt_mission.core.diagnostics import quoted


@dataclass(frozen=True)
class BuiltIn:
    """One kind of node that BehaviorTree.CPP has as well.

    `tags` are its elements, each with its attributes. `read` makes the data of a node from one of
    them, `write` the element of a node.
    """

    tags: Mapping[str, tuple[str, ...]]
    read: Callable[[NodeElement], dict[str, Any]]
    write: Callable[[NodeData], Tag]


def _composite(kind: str, tag: str) -> BuiltIn:
    reactive = f"Reactive{tag}"

    def read(node: NodeElement) -> dict[str, Any]:
        return {kind: node.children(), **({"memory": False} if node.tag == reactive else {})}

    def write(node: NodeData) -> Tag:
        written = tag if node.data.get("memory", True) else reactive
        return Tag(written, {}, node.children(kind))

    return BuiltIn({tag: (), reactive: (), f"Async{tag}": ()}, read, write)


# ---- parallel --------------------------------------------------------------------------------

_POLICIES = {
    ("all", "any", "halt"): ("Parallel", {"success_count": "-1", "failure_count": "1"}),
    ("any", "any", "halt"): ("Parallel", {"success_count": "1", "failure_count": "1"}),
    ("any", "impossible", "halt"): ("Parallel", {"success_count": "1", "failure_count": "-1"}),
    ("all", "impossible", "halt"): ("Parallel", {"success_count": "-1", "failure_count": "-1"}),
    ("all", "any", "finish"): ("ParallelAll", {"max_failures": "1"}),
    ("any", "impossible", "finish"): ("ParallelAll", {"max_failures": "-1"}),
}
"""When a parallel succeeds, when it fails, and what becomes of the rest, in both languages."""

_POLICY = {"succeed_when": "all", "fail_when": "any", "rest": "halt"}
"""The keys of a policy, each with its default."""


_COUNTS = {
    "Parallel": {"success_count": -1, "failure_count": 1},
    "ParallelAll": {"max_failures": 1},
}
"""The attributes of the elements, each with its default."""


def _read_parallel(node: NodeElement) -> dict[str, Any]:
    counts = {name: str(node.count(name, usual)) for name, usual in _COUNTS[node.tag].items()}
    (policy,) = (said for said, written in _POLICIES.items() if written == (node.tag, counts))
    words = zip(_POLICY.items(), policy, strict=True)
    said = {key: word for (key, usual), word in words if word != usual}
    return {"parallel": node.children(), **said}


def _write_parallel(node: NodeData) -> Tag:
    children = node.children("parallel")
    policy = [node.data.get(key, default) for key, default in _POLICY.items()]
    if isinstance(policy[0], list):
        hint = "write 'all' or 'any', or put those that count into a parallel of their own"
        node.refuse("children that count, by name", hint, "succeed_when")
        return Tag("Parallel", {}, children)
    if tuple(policy) not in _POLICIES:
        shown = f"'succeed_when: {policy[0]}', 'fail_when: {policy[1]}' and 'rest: {policy[2]}'"
        hint = "let the rest halt; or with 'rest: finish' write all and any, or any and impossible"
        node.refuse(f"{shown} together", hint, "rest", key=True)
        return Tag("Parallel", {}, children)
    return Tag(*_POLICIES[tuple(policy)], children)


# ---- decorators ------------------------------------------------------------------------------


def _repeated(kind: str, key: str, tag: str, attribute: str) -> BuiltIn:
    def read(node: NodeElement) -> dict[str, Any]:
        return {kind: {key: node.times(attribute)}, "do": node.child()}

    def write(node: NodeData) -> Tag:
        for word in ("while", "until"):
            if word in node.data[kind]:
                hint = "write 'count', or keep the mission in YAML"
                node.refuse(f"'{word}' of a repeat", hint, kind, word, key=True)
        if key not in node.data[kind]:
            return Tag(tag, {attribute: "1"}, (node.child(),))
        if node.data[kind].get("pause", 0) != 0:
            hint = "leave it out, or put a 'wait' before what is tried"
            node.refuse("a pause between attempts", hint, kind, "pause", key=True)
        return Tag(tag, {attribute: node.times(kind, key)}, (node.child(),))

    return BuiltIn({tag: (attribute,)}, read, write)


def _read_timeout(node: NodeElement) -> dict[str, Any]:
    return {"timeout": node.seconds("msec"), "do": node.child()}


def _write_timeout(node: NodeData) -> Tag:
    milliseconds = node.milliseconds("timeout")
    if milliseconds is None:
        hint = "write a number of seconds with at most three decimals, or '$NAME / 1000'"
        node.refuse("a limit that is no number of milliseconds", hint, "timeout")
    return Tag("Timeout", {"msec": milliseconds or "0"}, (node.child(),))


def _read_force(node: NodeElement) -> dict[str, Any]:
    return {"force": node.tag.removeprefix("Force").lower(), "do": node.child()}


def _write_force(node: NodeData) -> Tag:
    return Tag(f"Force{node.data['force'].capitalize()}", {}, (node.child(),))


def _read_guard(node: NodeElement) -> dict[str, Any]:
    """Return a WhileDoElse; one that has an else is two guards, of which one goes on at a time."""
    if node.count_children != 3:
        question, child = node.exactly(2)
        return {"guard": node.condition(question), "do": node.read(child)}
    question, child, other = node.exactly(3)
    condition = node.condition(question)
    opposite = LocatedValue(negated(condition.data), condition.place)
    first = located({"guard": condition, "do": node.read(child)}, child.at)
    second = located({"guard": opposite, "do": node.read(other)}, other.at)
    return {"fallback": [first, second], "memory": False}


def _write_guard(node: NodeData) -> Tag:
    return Tag("WhileDoElse", {}, (node.condition("guard"), node.child()))


def _read_try(node: NodeElement) -> dict[str, Any]:
    """Return a TryCatch: what is tried, and what is done after a failure, which it stays."""
    halted = node.take("catch_on_halt", needed=False)
    if halted is not None and halted.value.lower() not in ("false", "0"):
        message = "'catch_on_halt' has no counterpart"
        node.report(halted.at, message, "write the mission in YAML, with 'finally'")
    if node.count_children < 2:
        node.report(node.at, f"expected 2 nodes or more in <TryCatch>, got {node.count_children}")
    *tried, caught = node.first(max(2, node.count_children))
    attempts = [node.read(one) for one in tried]
    attempt = attempts[0] if len(attempts) == 1 else {"sequence": attempts}
    return {"fallback": [attempt, {"force": "failure", "do": node.read(caught)}]}


def _read_when(node: NodeElement) -> dict[str, Any]:
    if node.tag == "Precondition":
        return _read_precondition(node)
    question, child, other = node.exactly(3)
    found = {"when": node.condition(question), "do": node.read(child)}
    if other.tag == "AlwaysSuccess" and not other.attributes and not other.children:
        return found
    return {**found, "else": node.read(other)}


def _read_precondition(node: NodeElement) -> dict[str, Any]:
    question, otherwise = node.code("if"), node.take("else", needed=False)
    child = node.child()
    value = "FAILURE" if otherwise is None else otherwise.value
    if value == "SUCCESS":
        return {"when": question, "do": child}
    if otherwise is not None and value != "FAILURE":
        message = f"expected SUCCESS or FAILURE, got {quoted(value)}"
        node.report(otherwise.value_at, message)
    return {"sequence": [{"check": question}, child]}


def _write_when(node: NodeData) -> Tag:
    child, code = node.child(), node.code("when")
    if node.data.get("else") is not None:
        other = node.child("else")
        if other == Tag("AlwaysSuccess"):
            other = Tag("ScriptCondition", {"code": "true"})
        return Tag("IfThenElse", {}, (node.condition("when"), child, other))
    if code is not None:
        return Tag("Precondition", {"if": code, "else": "SUCCESS"}, (child,))
    return Tag("IfThenElse", {}, (node.condition("when"), child, Tag("AlwaysSuccess")))


# ---- leaves ----------------------------------------------------------------------------------


def _read_check(node: NodeElement) -> dict[str, Any]:
    held = {"AlwaysSuccess": True, "AlwaysFailure": False}
    check = held[node.tag] if node.tag in held else node.code("code")
    node.exactly(0)
    return {"check": check}


def _write_check(node: NodeData) -> Tag:
    question = node.data["check"]
    if isinstance(question, bool):
        return Tag("AlwaysSuccess" if question else "AlwaysFailure")
    code = node.code("check")
    return node.leaf("check") if code is None else Tag("ScriptCondition", {"code": code})


def _read_set(node: NodeElement) -> dict[str, Any]:
    code = node.take("code")
    node.exactly(0)
    if code is None:
        return {"set": {}}
    try:
        found = assignments(code.value)
    except ScriptError as error:
        node.report(code.within(error.column - 1), error.message, error.hint)
        found = []
    else:
        if not found:
            node.report(code.value_at, "expected 'name := value', got nothing")
    values = [
        (name, code.within(column - 1), located(value, code.value_at))
        for name, column, value in found
    ]
    return {"set": mapping(code.value_at, values)}


def _write_set(node: NodeData) -> Tag:
    code = written_assignments(node.data["set"])
    return node.leaf("set") if code is None else Tag("Script", {"code": code})


def _read_blackboard(node: NodeElement) -> dict[str, Any]:
    key, value = node.take("output_key"), node.value("value", 0)
    node.exactly(0)
    if key is None:
        return {"set": {}}
    if NAME.fullmatch(key.value) is None:
        node.report(key.value_at, f"expected the name of a variable, got {quoted(key.value)}")
        return {"set": {}}
    text = value.data
    if isinstance(text, str) and not text.startswith("$"):
        value = located(repr(text), (value.place.line, value.place.column))
    return {"set": mapping(key.value_at, [(key.value, key.value_at, value)])}


def _read_wait(node: NodeElement) -> dict[str, Any]:
    seconds = node.seconds("msec")
    node.exactly(0)
    return {"wait": seconds}


def _write_wait(node: NodeData) -> Tag:
    milliseconds = node.milliseconds("wait")
    return node.leaf("wait") if milliseconds is None else Tag("Sleep", {"msec": milliseconds})


def _read_delay(node: NodeElement) -> dict[str, Any]:
    return {"sequence": [{"wait": node.seconds("delay_msec")}, node.child()]}


KINDS = {
    "sequence": _composite("sequence", "Sequence"),
    "fallback": _composite("fallback", "Fallback"),
    "parallel": BuiltIn(
        {tag: tuple(names) for tag, names in _COUNTS.items()}, _read_parallel, _write_parallel
    ),
    "repeat": _repeated("repeat", "count", "Repeat", "num_cycles"),
    "retry": _repeated("retry", "attempts", "RetryUntilSuccessful", "num_attempts"),
    "timeout": BuiltIn({"Timeout": ("msec",)}, _read_timeout, _write_timeout),
    "invert": BuiltIn(
        {"Inverter": ()},
        lambda node: {"invert": node.child()},
        lambda node: Tag("Inverter", {}, (node.child("invert"),)),
    ),
    "force": BuiltIn({"ForceSuccess": (), "ForceFailure": ()}, _read_force, _write_force),
    "guard": BuiltIn({"WhileDoElse": ()}, _read_guard, _write_guard),
    "when": BuiltIn({"Precondition": ("if", "else"), "IfThenElse": ()}, _read_when, _write_when),
    "check": BuiltIn(
        {"ScriptCondition": ("code",), "AlwaysSuccess": (), "AlwaysFailure": ()},
        _read_check,
        _write_check,
    ),
    "set": BuiltIn({"Script": ("code",)}, _read_set, _write_set),
    "wait": BuiltIn({"Sleep": ("msec",)}, _read_wait, _write_wait),
}
"""The kinds of nodes that BehaviorTree.CPP has as well."""

BUILT_IN = {
    "Delay": (("delay_msec",), _read_delay),
    "KeepRunningUntilFailure": (
        (),
        lambda node: {"repeat": {"while": True}, "do": node.child()},
    ),
    "TryCatch": (("catch_on_halt",), _read_try),
    "SetBlackboard": (("value", "output_key"), _read_blackboard),
    **{tag: (names, kind.read) for kind in KINDS.values() for tag, names in kind.tags.items()},
}
"""The nodes of BehaviorTree.CPP and Nav2 that have a counterpart, and what reads each."""
