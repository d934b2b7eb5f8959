"""From the nodes of a mission file to the elements of an XML file."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_mission.btcpp.attributes import written_value
from bt_mission.btcpp.emit import Tag
from bt_mission.btcpp.leaf_writing import Path, write_leaf
from bt_mission.btcpp.leaves import LEAVES
from bt_mission.btcpp.ports import text_constant, written_port_value
from bt_mission.btcpp.scripts import literal, to_script, written_assignments
from bt_mission.core.diagnostics import MOST_FAULTS, Diagnostic
from bt_mission.core.yaml.document import Document
from bt_mission.language.action_names import ACTION_NAMES
from bt_mission.language.goal_limits import DEFAULTS, GoalLimitsTable
from bt_mission.language.node_reader import NodeReader, Signature

_NAME = re.compile(r"\$?([A-Za-z_][A-Za-z0-9_]*)")
_THOUSANDTH = re.compile(r"\$([A-Za-z_][A-Za-z0-9_]*) / 1000")
_LARGEST_MSEC = 2**31 - 1
_PARALLELS = {
    ("all", "any", "halt"): ("Parallel", {"success_count": "-1", "failure_count": "1"}),
    ("any", "any", "halt"): ("Parallel", {"success_count": "1", "failure_count": "1"}),
    ("any", "impossible", "halt"): ("Parallel", {"success_count": "1", "failure_count": "-1"}),
    ("all", "impossible", "halt"): ("Parallel", {"success_count": "-1", "failure_count": "-1"}),
    ("all", "any", "finish"): ("ParallelAll", {"max_failures": "1"}),
    ("any", "impossible", "finish"): ("ParallelAll", {"max_failures": "-1"}),
}


@dataclass
class NodeWriter:
    """Writes nodes of one document as elements, and collects what cannot be said.

    `limits` are the mission's; `used` gathers the attributes of each kind of leaf.
    """

    document: Document
    signatures: Mapping[str, Signature]
    limits: GoalLimitsTable
    used: dict[str, dict[str, None]]
    faults: list[Diagnostic] = field(default_factory=list)

    def refuse(self, path: Path, what: str, instead: str, *, key: bool = False) -> None:
        """Note what XML cannot say."""
        if len(self.faults) < MOST_FAULTS:
            message = f"{what}: XML has no counterpart"
            self.faults.append(self.document.fault(path, message, instead, key=key))

    def node(self, data: dict[str, Any], path: Path) -> Tag:
        """Return a node and all below it as an element."""
        kind = NodeReader(self.document).kind(data, path)
        assert kind is not None, "the mission was read before"
        if kind in _WRITE:
            tag = _WRITE[kind](self, data, path)
        elif kind in LEAVES:
            return self.leaf(kind, data, path)
        else:
            hint = "write its nodes one by one, or keep the mission in YAML"
            self.refuse((*path, kind), f"'{kind}'", hint, key=True)
            for inner_path, inner in _below(kind, data, path):
                self.node(inner, inner_path)
            return Tag("AlwaysSuccess")
        named = {"name": data["name"]} if data.get("name") else {}
        return Tag(tag.name, {**named, **tag.attributes}, tag.children)

    def leaf(self, kind: str, data: dict[str, Any], path: Path) -> Tag:
        """Return a leaf of ours."""
        if kind in ACTION_NAMES or kind == "action":
            action = data["action"]["name"] if kind == "action" else ACTION_NAMES[kind].action
            said = self.limits.of(action).items()
            data = {**{name: one for name, one in said if one != DEFAULTS.get(name)}, **data}
        attributes = write_leaf(LEAVES[kind], data, path, self.refuse)
        self.used.setdefault(kind, {}).update(dict.fromkeys(attributes))
        return Tag(kind, attributes)

    def children(self, key: str, data: dict[str, Any], path: Path) -> tuple[Tag, ...]:
        """Return the children of a composite."""
        return tuple(self.node(one, (*path, key, i)) for i, one in enumerate(data[key]))

    def child(self, data: dict[str, Any], path: Path, key: str = "do") -> tuple[Tag]:
        """Return the one child of a decorator."""
        return (self.node(data[key], (*path, key)),)

    def times(self, value: Any, path: Path) -> str:
        """Return how often, as a number or a variable."""
        found = _NAME.fullmatch(value) if isinstance(value, str) else None
        if found:
            return f"{{{found[1]}}}"
        if isinstance(value, str):
            what = "an expression for how often"
            self.refuse(path, what, "'set' a variable to it first, and give its name")
        return str(value)

    def milliseconds(self, value: Any) -> str | None:
        """Return seconds as milliseconds, or None where they are none."""
        found = _THOUSANDTH.fullmatch(value) if isinstance(value, str) else None
        if found:
            return f"{{{found[1]}}}"
        if isinstance(value, str) or value * 1000 > _LARGEST_MSEC:
            return None
        whole = round(value * 1000)
        return str(whole) if whole / 1000 == value else None

    def condition(self, value: Any) -> Tag:
        """Return a condition as a node that asks it."""
        code = _code(value)
        if code is not None:
            return Tag("ScriptCondition", {"code": code})
        attributes = {"condition": written_value(value)}
        self.used.setdefault("check", {}).update(dict.fromkeys(attributes))
        return Tag("check", attributes)


def _code(value: Any) -> str | None:
    """Return a condition as a script, or None where it has none that comes back as the same."""
    if isinstance(value, bool):
        return "true" if value else "false"
    code = to_script(value)
    return code if code is not None and literal(code) == value else None


def _sequence(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    tag = "Sequence" if data.get("memory", True) else "ReactiveSequence"
    return Tag(tag, {}, writer.children("sequence", data, path))


def _fallback(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    tag = "Fallback" if data.get("memory", True) else "ReactiveFallback"
    return Tag(tag, {}, writer.children("fallback", data, path))


def _parallel(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    children = writer.children("parallel", data, path)
    succeed = data.get("succeed_when", "all")
    if isinstance(succeed, list):
        hint = "write 'all' or 'any', or put those that count into a parallel of their own"
        writer.refuse((*path, "succeed_when"), "children that count, by name", hint)
        return Tag("Parallel", {}, children)
    policy = (succeed, data.get("fail_when", "any"), data.get("rest", "halt"))
    if policy not in _PARALLELS:
        shown = f"'succeed_when: {policy[0]}', 'fail_when: {policy[1]}' and 'rest: {policy[2]}'"
        hint = "let the rest halt; or with 'rest: finish' write all and any, or any and impossible"
        writer.refuse((*path, "rest"), f"{shown} together", hint, key=True)
        return Tag("Parallel", {}, children)
    tag, attributes = _PARALLELS[policy]
    return Tag(tag, attributes, children)


def _repeat(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    times = writer.times(data["repeat"]["count"], (*path, "repeat", "count"))
    return Tag("Repeat", {"num_cycles": times}, writer.child(data, path))


def _retry(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    settings = data["retry"]
    if settings.get("pause", 0) != 0:
        hint = "leave it out, or put a 'wait' before what is tried"
        writer.refuse((*path, "retry", "pause"), "a pause between attempts", hint, key=True)
    times = writer.times(settings["attempts"], (*path, "retry", "attempts"))
    return Tag("RetryUntilSuccessful", {"num_attempts": times}, writer.child(data, path))


def _timeout(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    milliseconds = writer.milliseconds(data["timeout"])
    if milliseconds is None:
        hint = "write a number of seconds with at most three decimals, or '$NAME / 1000'"
        writer.refuse((*path, "timeout"), "a limit that is no number of milliseconds", hint)
    return Tag("Timeout", {"msec": milliseconds or "0"}, writer.child(data, path))


def _invert(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    return Tag("Inverter", {}, writer.child(data, path, "invert"))


def _force(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    tag = "ForceSuccess" if data["force"] == "success" else "ForceFailure"
    return Tag(tag, {}, writer.child(data, path))


def _guard(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    children = (writer.condition(data["guard"]), *writer.child(data, path))
    return Tag("WhileDoElse", {}, children)


def _when(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    question, child = data["when"], writer.child(data, path)
    code = _code(question)
    if data.get("else") is not None:
        (other,) = writer.child(data, path, "else")
        if other == Tag("AlwaysSuccess"):
            other = Tag("ScriptCondition", {"code": "true"})
        return Tag("IfThenElse", {}, (writer.condition(question), *child, other))
    if code is not None:
        return Tag("Precondition", {"if": code, "else": "SUCCESS"}, child)
    children = (writer.condition(question), *child, Tag("AlwaysSuccess"))
    return Tag("IfThenElse", {}, children)


def _check(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    question = data["check"]
    if isinstance(question, bool):
        return Tag("AlwaysSuccess" if question else "AlwaysFailure")
    code = _code(question)
    return (
        writer.leaf("check", data, path) if code is None else Tag("ScriptCondition", {"code": code})
    )


def _set(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    code = written_assignments(data["set"])
    return writer.leaf("set", data, path) if code is None else Tag("Script", {"code": code})


def _wait(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    milliseconds = writer.milliseconds(data["wait"])
    if milliseconds is None:
        return writer.leaf("wait", data, path)
    return Tag("Sleep", {"msec": milliseconds})


def _tree(writer: NodeWriter, data: dict[str, Any], path: Path) -> Tag:
    use = data["tree"] if isinstance(data["tree"], dict) else {"name": data["tree"]}
    attributes = {"ID": use["name"]}
    types = writer.signatures[use["name"]].types
    for name, value in use.get("inputs", {}).items():
        word = types[name]
        said = _given(value, word or "list")
        if said is None:
            what = f"what '{name}' is given"
            hint = "'set' a variable to it first, and give that"
            writer.refuse((*path, "tree", "inputs", name), what, hint)
        attributes[name] = said or ""
    for name, variable in data.get("outputs", {}).items():
        attributes[name] = f"{{{variable}}}"
    return Tag("SubTree", attributes)


def _given(value: Any, word: str) -> str | None:
    """Return what a tree is given as an attribute, or None where none can say it."""
    found = _NAME.fullmatch(value) if isinstance(value, str) else None
    if found and value not in ("true", "false", "pi"):
        return f"{{{found[1]}}}"
    if word == "text" and isinstance(value, str):
        inner = value[1:-1]
        is_plain = inner and not (inner[0] == "{" and inner[-1] == "}")
        return inner if is_plain and text_constant(inner) == value else None
    return None if isinstance(value, str) else written_port_value(value, word)


def _below(kind: str, data: dict[str, Any], path: Path) -> list[tuple[Path, dict[str, Any]]]:
    """Return the nodes within one that cannot be said."""
    if isinstance(data[kind], list):
        return [((*path, kind, i), one) for i, one in enumerate(data[kind])]
    return [((*path, "do"), data["do"])] if "do" in data else []


_WRITE: dict[str, Callable[[NodeWriter, dict[str, Any], Path], Tag]] = {
    "sequence": _sequence,
    "fallback": _fallback,
    "parallel": _parallel,
    "repeat": _repeat,
    "retry": _retry,
    "timeout": _timeout,
    "invert": _invert,
    "force": _force,
    "guard": _guard,
    "when": _when,
    "check": _check,
    "set": _set,
    "wait": _wait,
    "tree": _tree,
}
