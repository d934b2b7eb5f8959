#!/usr/bin/env python3
"""Write docs/reference/api.md: every public name, with its signature and docstring.

A test compares the file with what this script writes. Docstrings are read from the sources; nothing
is written by hand but the introductions below.
"""

from __future__ import annotations

import enum
import importlib
import inspect
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
PAGE = ROOT / "docs" / "reference" / "api.md"

MODULES = {
    "bt_mission": "Load, check and run missions.",
    "bt_mission.testing": "Test missions with pytest; docs/reference/testing.md shows how.",
    "bt_mission.testing.generators.strategies": "Property-based tests with hypothesis.",
    "action_servers": "Write maneuvers and actions of your own.",
}
HEAD = """\
# Python API

Every public name of bt-mission, generated from the docstrings by `tools/make_api_reference.py`.
Import from these modules only: what lies deeper may move. Importing them loads neither rclpy
nor MuJoCo; a name is loaded when it is first used.
"""
WIDTH, LONGEST_DEFAULT = 88, 60
SECTION = re.compile(r"^(Args|Attributes|Returns|Raises):\n((?: {4}.*(?:\n|$))+)", re.MULTILINE)
REFERENCE = re.compile(r":\w+:`~?(?:[\w.]+\.)?(\w+)`")


def _as_list(section: re.Match[str]) -> str:
    """Return a section of a Google docstring as a Markdown list."""
    entries = re.sub(r"\n {5,}", " ", section[2])
    if section[1] == "Returns":
        return f"**Returns** {entries.strip()}\n"
    items = re.sub(r"(?m)^ {4}(\*{0,2}\w+): ", r"- `\1`: ", entries)
    return f"**{section[1]}**\n\n{items}"


def text_of(thing: Any) -> str:
    """Return a docstring as Markdown: cross references and double backquotes as code."""
    text = SECTION.sub(_as_list, inspect.cleandoc(thing.__doc__ or ""))
    return REFERENCE.sub(r"`\1`", text).replace("``", "`").replace("::\n", ":\n")


def _annotation(shown: Any) -> str:
    """Return an annotation without the paths of modules."""
    text = shown if isinstance(shown, str) else inspect.formatannotation(shown)
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", text)


def _parameter(one: inspect.Parameter) -> str:
    stars: dict[Any, str] = {one.VAR_POSITIONAL: "*", one.VAR_KEYWORD: "**"}
    text: str = stars.get(one.kind, "") + one.name
    if one.annotation is not one.empty:
        text += f": {_annotation(one.annotation)}"
    if one.default is not one.empty:
        default = repr(one.default)
        text += (
            " = ..."
            if default.startswith("<") or len(default) > LONGEST_DEFAULT
            else f" = {default}"
        )
    return text


def signature_of(name: str, thing: Any) -> str:
    """Return a call as one writes it: on one line where it is short, else a parameter a line."""
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return name
    shown, has_star = [], False
    for one in signature.parameters.values():
        if one.name == "self" or one.name.startswith("_"):
            continue
        if one.kind is one.KEYWORD_ONLY and not has_star:
            shown.append("*")
        has_star = has_star or one.kind in (one.KEYWORD_ONLY, one.VAR_POSITIONAL)
        shown.append(_parameter(one))
    result = signature.return_annotation
    end = (
        "" if result is signature.empty or inspect.isclass(thing) else f" -> {_annotation(result)}"
    )
    line = f"{name}({', '.join(shown)}){end}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"{name}(", *(f"    {one}," for one in shown), f"){end}"])


def public_members(thing: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties that a class defines itself, in their order."""
    for name, member in vars(thing).items():
        if name.startswith("_") or "<lambda>" in getattr(member, "__qualname__", ""):
            continue
        if isinstance(member, classmethod | staticmethod):
            yield name, member.__func__
        elif inspect.isfunction(member) or isinstance(member, property):
            yield name, member


def _call(name: str, thing: Any) -> Iterator[str]:
    yield from ("```python", signature_of(name, thing), "```", "")


def described(name: str, thing: Any) -> Iterator[str]:
    """Yield the lines about one public name."""
    if inspect.isclass(thing):
        yield from (f"### class `{name}`", "")
        is_plain = issubclass(thing, Exception | enum.Enum) or getattr(thing, "_is_protocol", False)
        if not is_plain and not hasattr(thing, "model_fields"):
            yield from _call(name, thing)
        yield from (text_of(thing), "")
        if issubclass(thing, enum.Enum):
            yield from (f"- `{one.name}` = `{one.value!r}`" for one in thing)
            yield ""
            return
        for member_name, member in public_members(thing):
            yield from (f"#### `{name}.{member_name}`", "")
            if isinstance(member, property):
                yield from (text_of(member.fget), "")
            else:
                yield from (*_call(member_name, member), text_of(member), "")
    elif callable(thing):
        yield from (f"### `{name}`", "", *_call(name, thing), text_of(thing), "")
    else:
        yield from (f"### `{name}`", "", f"A `{type(thing).__name__}`.", "")


def page() -> str:
    """Return the page."""
    lines = [HEAD]
    for module_name, purpose in MODULES.items():
        module = importlib.import_module(module_name)
        lines += [f"## `{module_name}`", "", purpose, ""]
        for name in module.__all__:
            lines += described(name, getattr(module, name))
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE)
    return 0


if __name__ == "__main__":
    sys.exit(main())
