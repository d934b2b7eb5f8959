"""The commonest mistakes in nodes, and what to write instead."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence
from typing import Any

from bt_mission.core.diagnostics import LIKENED_NAMES, describe, did_you_mean, listed, quoted
from bt_mission.language.action_names import ACTION_NAMES

_GUARD = "'guard: CONDITION' runs its 'do' as long as a condition holds"
_WHEN = "'when: CONDITION' runs its 'do' if a condition holds, else its 'else'"
_ELSE_IF = "write 'else:' beside 'when', with another 'when' below it"
_FINALLY = "write 'finally: {timeout: 10}' with a 'do', and the clean-up under 'then'"
TYPE_OF_TOPIC = (
    "write 'type: sensor_msgs/msg/BatteryState' or the like; 'bt-mission topics list' names the "
    "types of a running graph"
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
}
"""The same for words beside a type of node."""

FIRST_FIELDS = {
    "finally": "timeout",
    "repeat": "count",
    "retry": "attempts",
    **{kind: next(iter(action.example)) for kind, action in ACTION_NAMES.items() if action.example},
}
"""The field that is meant where a type of node with fields gets one value."""

ALL_KINDS = "'bt-mission docs nodes' lists all"
NEAREST = 3


def bare_word(word: str) -> str:
    """Return a word in small letters, without blanks and signs: "else if" and "ElseIf" are one."""
    return "".join(character for character in word.lower() if character.isalnum())


def unknown_kind(key: str, kinds: Iterable[str], modifiers: Collection[str]) -> tuple[str, str]:
    """Return what is wrong with a node that has no known type, and what to write instead."""
    known = list(kinds)[:LIKENED_NAMES]
    instead = OTHER_WORDS.get(bare_word(key[:100]))
    if key in modifiers:
        hint = f"{quoted(key)} is a modifier: write it beside the type of its node"
        return f"no node type beside {quoted(key)}", hint
    if instead is not None:
        return f"unknown node type {quoted(key)}", instead
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


def lone_value(kind: str, value: Any) -> tuple[str, str] | None:
    """Return what is wrong with one value where a type takes fields, and a hint; else None."""
    name = FIRST_FIELDS.get(kind)
    if name is None or isinstance(value, dict):
        return None
    is_value = isinstance(value, int | float | list) or str(value).startswith("$")
    shown = str(value) if is_value and len(str(value)) <= 40 else "..."
    message = f"expected a mapping, got {describe(value)}"
    return message, f"write '{kind}: {{{name}: {shown}}}'"


LIST_OF_NODES = "put 'sequence:' before the list, to run its nodes one after another"
NO_DASHES = "put '- ' before each node, and indent its content"
