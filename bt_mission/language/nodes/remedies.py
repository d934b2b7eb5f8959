"""The commonest mistakes in nodes, and what to write instead."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from bt_mission.base.commands import hints, page
from bt_mission.base.diagnostics import LIKENED_NAMES, describe, did_you_mean, listed, quoted
from bt_mission.language.action_names import ACTION_NAMES

_GUARD = "'guard: CONDITION' runs its 'do' as long as a condition holds"
_WHEN = "'when: CONDITION' runs its 'do' if a condition holds, else its 'else'"
_ELSE_IF = "write 'else:' beside 'when', with another 'when' below it"
_FINALLY = "write 'finally: {timeout: 10}' with a 'do', and the clean-up under 'then'"
TYPE_OF_TOPIC = "; ".join(
    ["write 'type: sensor_msgs/msg/BatteryState' or the like", *hints("topic_type")]
)
_PARALLEL = "write 'parallel'"

OTHER_WORDS = {
    "selector": "write 'fallback'",
    "priority": "write 'fallback'",
    "try": "write 'fallback'",
    "or": "write 'fallback'",
    "if": _WHEN,
    "switch": _WHEN,
    "case": _WHEN,
    "unless": _WHEN,
    "elseif": _ELSE_IF,
    "elif": _ELSE_IF,
    "while": f"write 'repeat: {{while: CONDITION}}'; {_GUARD}",
    "until": "write 'repeat: {until: CONDITION}'; 'wait_for' waits for a message",
    "loop": "write 'repeat: {count: 3}', '{while: ...}' or '{until: ...}'",
    "for": "write 'for_each: {place: [1, 2]}', or 'repeat: {count: 3}'",
    "foreach": "write 'for_each: {place: [1, 2]}'",
    "condition": "write 'check: CONDITION'",
    "assert": "write 'check: CONDITION'",
    "not": "write 'invert'",
    "inverter": "write 'invert'",
    "succeeder": "write 'force: success'",
    "simultaneous": _PARALLEL,
    "concurrent": _PARALLEL,
    "and": "write 'sequence'",
    "steps": "write 'sequence'",
    "ensure": _FINALLY,
    "cleanup": _FINALLY,
    "defer": _FINALLY,
    "sleep": "write 'wait: SECONDS'",
    "delay": "write 'wait: SECONDS'",
    "pause": "write 'wait: SECONDS'",
    "print": "write 'log: TEXT'",
    "say": "write 'log: TEXT'",
    "echo": "write 'log: TEXT'",
    "let": "write 'set: {NAME: VALUE}'",
    "assign": "write 'set: {NAME: VALUE}'",
    "follow": "write it at the head of the mission, or of a named tree, beside 'inputs'",
    "subscribe": "write 'wait_for' for one message; a variable follows a topic by 'follow' at the "
    "head of the mission",
    "call": "write 'service' for a service, 'tree' for a named tree",
    "subtree": "write 'tree: NAME'",
    "random": "write 'choose'",
    "drive": "write 'move', 'drive_on_heading' or 'explore_forward'",
    "forward": "write 'move', 'drive_on_heading' or 'explore_forward'",
    "rotate": "write 'turn'",
    "goto": "write 'navigate_to_pose: {pose: [x, y, yaw]}'",
    "navigate": "write 'navigate_to_pose: {pose: [x, y, yaw]}'",
}
"""Replacements for words of other languages and libraries, in small letters and without signs."""

OTHER_MODIFIERS = {
    "timeout": "write a node 'timeout: SECONDS' with this one under its 'do'",
    "elseif": _ELSE_IF,
    "elif": _ELSE_IF,
    "otherwise": "write 'else'",
    "then": "write 'do'",
    "body": "write 'do'",
    "child": "write 'do'",
    "children": "write the children as the list of 'sequence'",
    **dict.fromkeys(
        ("retries", "retry", "attempts", "maxretries", "maxattempts", "numattempts"),
        "write 'retry: {attempts: 3}' with this node under its 'do'",
    ),
    **dict.fromkeys(
        ("onfailure", "onerror", "onabort", "catch", "recovery"),
        "write a 'fallback' with this node first, and behind it what to do after a failure",
    ),
    "onsuccess": "write a 'sequence' with this node first, and behind it what to do then",
    **dict.fromkeys(
        ("condition", "precondition", "skipif", "onlyif", "if"),
        "write 'when: CONDITION' with this node under its 'do'",
    ),
    **dict.fromkeys(("times", "count"), "write 'repeat: {count: 3}' with this node under its 'do'"),
    **dict.fromkeys(
        ("params", "parameters", "args", "arguments", "goal", "fields"),
        "write the fields of the goal under the type of the node, such as 'turn: {angle: 90}'",
    ),
    "result": "write 'outputs: {FIELD: VARIABLE}'",
    "output": "write 'outputs: {FIELD: VARIABLE}'",
    "description": "use 'name', or a comment",
    "id": "write 'name'",
}
"""The same for words beside a type of node."""

_TYPES = frozenset(("type", "kind", "node", "nodetype", "class"))
"""Keys whose value is the type of a node in other languages."""

OTHER_KEYS: dict[str, dict[str, str]] = {
    "mission": {
        **dict.fromkeys(("name", "title", "id"), "mission"),
        **dict.fromkeys(
            ("variables", "vars", "params", "parameters", "args", "arguments", "blackboard"),
            "inputs",
        ),
        **dict.fromkeys(
            ("root", "behaviortree", "bt", "main", "steps", "children", "plan", "do"),
            "tree",
        ),
        **dict.fromkeys(("subtrees", "functions", "macros", "behaviors", "behaviours"), "trees"),
        **dict.fromkeys(("imports", "import", "includes", "use"), "include"),
        **dict.fromkeys(
            ("requires", "require", "assertions", "asserts", "properties", "specification"),
            "requirements",
        ),
        **dict.fromkeys(("waypoints", "locations", "poses", "goals", "positions"), "places"),
        **dict.fromkeys(("environment", "scene", "simulation"), "world"),
        **dict.fromkeys(("robotmodel", "model", "platform"), "robot"),
        **dict.fromkeys(("topics", "subscribe", "subscriptions"), "follow"),
        **dict.fromkeys(("timeout", "timeouts", "defaults"), "limits"),
        "comment": "description",
    },
    "tree": {
        **dict.fromkeys(("tree", "root", "body", "steps", "children", "nodes"), "do"),
        **dict.fromkeys(("params", "parameters", "args", "arguments", "requires"), "needs"),
        **dict.fromkeys(("defaults", "variables", "vars"), "inputs"),
        **dict.fromkeys(("returns", "return", "results", "output"), "outputs"),
    },
    "repeat": {
        **dict.fromkeys(("times", "n", "number", "cycles", "numcycles", "max", "rounds"), "count"),
        **dict.fromkeys(("condition", "if", "aslongas"), "while"),
    },
    "retry": {
        **dict.fromkeys(
            ("count", "times", "n", "max", "retries", "tries", "maxattempts", "numattempts"),
            "attempts",
        ),
        **dict.fromkeys(("delay", "wait", "backoff", "sleep"), "pause"),
    },
}
"""Keys of other tools in a mission, a named tree or a node, with ours."""

EXAMPLES: Mapping[str, Mapping[str, Any]] = {
    "finally": {"timeout": 5},
    "repeat": {"count": 3},
    "retry": {"attempts": 3},
}
"""Fields of types of nodes, besides those of goals."""

ALL_KINDS = page("nodes", "'") + " lists all"
NEAREST = 3


def bare_word(word: str) -> str:
    """Return a word in small letters, without blanks and signs: "else if" and "ElseIf" are one."""
    return "".join(character for character in word.lower() if character.isalnum())


def unknown_key(owner: str, key: str, kinds: Collection[str] = ()) -> str | None:
    """Return what to write instead of a key of another tool; None where nothing is known.

    Args:
        owner: The part of the file: "mission", "tree", or a type of node.
        key: The key.
        kinds: Every type of node.
    """
    word = bare_word(key[:100])
    if ours := OTHER_KEYS.get(owner, {}).get(word):
        return f"write '{ours}'"
    if owner == "mission" and (key in kinds or word in OTHER_WORDS):
        return f"write it under 'tree': {OTHER_WORDS.get(word) or quoted(key + ': ...')}"
    return None


def unknown_kind(
    data: Mapping[str, Any], key: str, kinds: Collection[str], modifiers: Collection[str]
) -> tuple[str, str]:
    """Return what is wrong with a node that has no known type, and what to write instead.

    Args:
        data: The node.
        key: Its key that may name a type.
        kinds: Every type of node.
        modifiers: What stands beside a type.
    """
    known = list(kinds)[:LIKENED_NAMES]
    if bare_word(key[:100]) in _TYPES and isinstance(data[key], str):
        written = data[key][:100]
        other = OTHER_WORDS.get(bare_word(written)) or did_you_mean(written.lower(), known)
        name = written.lower() if written.lower() in kinds else None
        hint = f"write '{name}: ...'" if name else other or f"write '{quoted(written)[1:-1]}: ...'"
        return f"the type of a node is its key, not the value of {quoted(key)}", hint
    instead = OTHER_WORDS.get(bare_word(key[:100]))
    if key in modifiers:
        hint = f"{quoted(key)} is a modifier: write it beside the type of its node"
        return f"no node type beside {quoted(key)}", hint
    if instead is not None:
        return f"unknown node type {quoted(key)}", instead
    import difflib  # noqa: PLC0415 - for errors alone

    near = difflib.get_close_matches(key[:100], known, n=NEAREST, cutoff=0.0)
    message = f"unknown node type {quoted(key)} (nearest: {listed(near)}; {ALL_KINDS})"
    return message, did_you_mean(key, known) or ""


def two_kinds(first: str, second: str, around: Sequence[str]) -> str:
    """Return what to do with two types of node in one; `around` are those that take a `do`."""
    if len(around) != 1:
        return "make each a separate item, with '- ' before it"
    outer = around[0]
    inner = second if outer == first else first
    return f"make {quoted(outer)} a separate item, and put {quoted(inner)} under its 'do'"


def unknown_modifier(key: str, modifiers: Iterable[str]) -> str | None:
    """Return what to write instead of a modifier that a type of node does not have."""
    return OTHER_MODIFIERS.get(bare_word(key[:100])) or did_you_mean(key, modifiers)


def beside(key: str, kind: str) -> str:
    """Return what to do with a modifier that stands among the fields of its node."""
    return f"{quoted(key)} is a modifier: write it beside {quoted(kind)}, not inside it"


def example_of(kind: str) -> Mapping[str, Any]:
    """Return fields of a type of node: the first is meant where it gets one value; or nothing."""
    known = ACTION_NAMES.get(kind)
    return EXAMPLES.get(kind, {}) if known is None else known.example


def lone_value(kind: str, value: Any) -> tuple[str, str] | None:
    """Return what is wrong with one value where a type takes fields, and a hint; else None."""
    if isinstance(value, dict) or not (example := example_of(kind)):
        return None
    message = f"expected a mapping, got {describe(value)}"
    name, usual = next(iter(example.items()))
    if isinstance(value, int | float) and isinstance(usual, list | dict):
        fields = ", ".join(f"{field}: {part}" for field, part in example.items())
        return message, f"write for example '{kind}: {{{fields}}}'"
    is_value = isinstance(value, int | float | list) or str(value).startswith("$")
    shown = str(value) if is_value and len(str(value)) <= 40 else "..."
    return message, f"write '{kind}: {{{name}: {shown}}}'"


LIST_OF_NODES = "put 'sequence:' before the list, to run its nodes one after another"
NO_DASHES = "put '- ' before each node, and indent its content"
