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
    "action_servers": "Write maneuvers and actions of your own.",
}
HEAD = """\
# Python API

Every public name of bt-mission, generated from the docstrings by `tools/make_api_reference.py`.
Import from these three modules only: what lies deeper may move. Importing them loads neither rclpy
nor MuJoCo; a name is loaded when it is first used.
"""
REFERENCE = re.compile(r":\w+:`~?(?:[\w.]+\.)?(\w+)`")


def text_of(thing: Any) -> str:
    """Return a docstring as Markdown: cross references and double backquotes as code."""
    text = inspect.cleandoc(thing.__doc__ or "")
    return REFERENCE.sub(r"`\1`", text).replace("``", "`").replace("::\n", ":\n")


def signature_of(thing: Any) -> str:
    """Return a signature without quotes and module paths."""
    try:
        shown = str(inspect.signature(thing))
    except (TypeError, ValueError):
        return ""
    shown = re.sub(r"<object object at \w+>", "...", shown)
    return re.sub(r"\b(?:[a-z_]\w*\.)+(?=[A-Za-z])", "", shown).replace("'", "")


def public_members(thing: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties that a class defines itself, in their order."""
    for name, member in vars(thing).items():
        if name.startswith("_"):
            continue
        if isinstance(member, classmethod | staticmethod):
            yield name, member.__func__
        elif inspect.isfunction(member) or isinstance(member, property):
            yield name, member


def described(name: str, thing: Any) -> Iterator[str]:
    """Yield the lines about one public name."""
    if inspect.isclass(thing):
        plain = issubclass(thing, Exception | enum.Enum) or getattr(thing, "_is_protocol", False)
        yield from (
            f"### class `{name}{'' if plain else signature_of(thing)}`",
            "",
            text_of(thing),
            "",
        )
        if issubclass(thing, enum.Enum):
            yield from (f"- `{one.name}` = `{one.value!r}`" for one in thing)
            yield ""
            return
        for member_name, member in public_members(thing):
            kind = isinstance(member, property)
            shown = member_name if kind else f"{member_name}{signature_of(member)}"
            yield from (f"#### `{shown}`", "", text_of(member.fget if kind else member), "")
    elif callable(thing):
        yield from (f"### `{name}{signature_of(thing)}`", "", text_of(thing), "")
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
