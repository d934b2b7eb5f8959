#!/usr/bin/env python3
"""Write what docs/ takes from the code: tables of faults, nature, limits, keys, and a picture.

A test compares each file with the result; `make generated` writes them.
"""

from __future__ import annotations

import json
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from itertools import groupby
from pathlib import Path
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from action_servers.core.action import action  # noqa: E402 - from the root
from action_servers.core.limits import NumberLimit  # noqa: E402
from action_servers.robot_io.messages import generated_type  # noqa: E402
from bt_mission.base.actions import declared  # noqa: E402
from bt_mission.base.error_catalogue import CatalogueEntry, catalogue, shown  # noqa: E402
from bt_mission.base.nature import QUANTITIES, NatureQuantity  # noqa: E402
from bt_mission.language.action_names import ACTION_NAMES  # noqa: E402
from bt_mission.robots.model import load_robot  # noqa: E402
from bt_mission.scenarios.faults import FAULTS  # noqa: E402
from bt_mission.scenarios.faults.drawing import GROUPS  # noqa: E402
from bt_mission.scenarios.faults.kind import FaultKind  # noqa: E402
from bt_mission.scenarios.fleets.file import fleet_schema  # noqa: E402
from bt_mission.sessions.file_checks import robot_schema, world_schema  # noqa: E402
from bt_mission.views.tui.keys import CHOOSING, LEAVING, LOOKING, PLAYING, REQUESTS  # noqa: E402
from tools.draw_layers import draw  # noqa: E402

DOCS = ROOT / "docs"
SEARCH = DOCS / "reference" / "search.md"
"""A page of a command, which goes with it."""


# ---- tables within pages -------------------------------------------


LASTING = " [lasting s]"
"""The parameter that most faults have."""


def fault_list() -> str:
    """Return the faults of each area, and first a table of what many parameters mean."""
    at_once = [f"`{name}`" for name, kind in FAULTS.items() if LASTING not in kind.usage]
    meanings = {"lasting": f"s; all but {', '.join(at_once)} take it", **_shared_parameters()}
    rows = [
        f"| `{name}` | {text[:1].lower()}{text[1:].rstrip('.')} |"
        for name, text in meanings.items()
    ]
    head = ["Parameters of several faults:", "", "| parameter | meaning |", "|---|---|"]
    parts = ["\n".join([*head, *rows])]
    for area in dict.fromkeys(known.area for known in FAULTS.values()):
        items = [
            f"- `{known.usage.replace(LASTING, '')}`: {_effect(known)}"
            for known in FAULTS.values()
            if known.area == area
        ]
        parts.append("\n".join([f"**{area}**", "", *items]))
    return "\n\n".join(parts)


def fault_groups() -> str:
    """Return the table of the groups that a search draws faults from."""
    rows = [f"| `{name}` | {', '.join(members)} |" for name, members in GROUPS.items()]
    return "\n".join(["| group | faults |", "|---|---|", *rows])


def _effect(kind: FaultKind) -> str:
    shared = _shared_parameters()
    arguments = [
        f"`{parameter.name}`: {parameter.text[:1].lower()}{parameter.text[1:]}"
        for parameter in kind.parameters.values()
        if parameter.text and shared.get(parameter.name) != parameter.text
    ]
    return " ".join([kind.text, *arguments])


@cache
def _shared_parameters() -> Mapping[str, str]:
    """Return the meaning of each parameter that several faults have, by its name."""
    meanings: dict[str, Counter[str]] = defaultdict(Counter)
    for kind in FAULTS.values():
        for parameter in kind.parameters.values():
            meanings[parameter.name][parameter.text] += 1
    most = {name: texts.most_common(1)[0] for name, texts in meanings.items()}
    return {name: text for name, (text, faults) in most.items() if text and faults > 1}


def nature_table() -> str:
    """Return the table of nature's quantities, and the one of the sources of their numbers."""
    head = "| quantity | unit | mild | usual | harsh | drawn | what it is |"
    quantities = "\n".join([head, "|---" * 7 + "|", *map(_quantity, QUANTITIES)])
    measured: dict[str, list[str]] = defaultdict(list)
    for quantity in QUANTITIES:
        if not quantity.source.endswith(ASSUMED):
            measured[quantity.source].append(f"`{quantity.name}`")
    rows = [f"| {', '.join(names)} | {source} |" for source, names in measured.items()]
    rows.append("| all others | estimates of the authors |")
    sources = "\n".join(["| quantities | source of the numbers |", "|---|---|", *rows])
    return f"{quantities}\n\n{sources}"


ASSUMED = "(an assumption)"
"""Ends the source of a quantity without a measurement."""


def _quantity(quantity: NatureQuantity) -> str:
    values = " | ".join(f"{value:g}" for value in (quantity.mild, quantity.usual, quantity.harsh))
    cells = (f"`{quantity.name}`", quantity.unit, values, quantity.shape, quantity.text)
    return f"| {' | '.join(cells)} |"


def limit_table() -> str:
    """Return the table of the limits of goals, of a Waffle and servers without parameters.

    Actions with the same limit of a field share a row.
    """
    waffle = load_robot("waffle")
    actions: dict[tuple[str, str, str], list[str]] = defaultdict(list)
    for name in declared():
        for limit in action(name).limits_with(waffle):
            zero = limit.zero if isinstance(limit, NumberLimit) else ""
            accepted = f"{limit.words}; 0: {zero}" if zero else limit.words
            source = _PARAMETER.sub(r"`\1`", limit.source)
            actions[limit.field, accepted, source].append(f"`{name}`")
    rows = [
        f"| {', '.join(names)} | `{field}` | {accepted} | {source} |"
        for (field, accepted, source), names in actions.items()
    ]
    return "\n".join(["| action | field | accepted | limit |", "|---|---|---|---|", *rows])


_PARAMETER = re.compile(r"parameter (\w+) of the servers")


def action_examples() -> str:
    """Return a node for each action with a short name, with the example of its declaration."""
    in_a_line = partial(yaml.safe_dump, default_flow_style=True, sort_keys=False)
    nodes = [
        f"- {kind}: {in_a_line(dict(action_name.example)).strip()}\n  timeout: 300"
        for kind, action_name in ACTION_NAMES.items()
        if action_name.example
    ]
    return "\n".join(["```yaml", *nodes, "```"])


def actions_page(page: str) -> str:
    """Return the page of actions with its examples and the limits of goals."""
    page = between("examples of goals", action_examples(), page)
    return between("limits of goals", limit_table(), page)


def nav2_table() -> str:
    """Return the actions of Nav2 that are served, with their fields and error codes."""
    rows = ["| action | goal | feedback | result | error codes |", "|---|---|---|---|---|"]
    for name, known in declared().items():
        package, _, type_name = known.known.type.partition("/action/")
        if package != "nav2_msgs":
            continue
        parts = generated_type(known.known.type)
        fields = [
            ", ".join(f"`{field}`" for field in part.get_fields_and_field_types())
            for part in (parts.Goal, parts.Feedback, parts.Result)
        ]
        codes = ", ".join(map(str, map(int, action(name).codes))) or "0 only"
        rows.append(f"| `/{name}`: `{type_name}` | {' | '.join(fields)} | {codes} |")
    return "\n".join(rows)


def key_table() -> str:
    """Return the keys of the full-screen views, those of both views last."""
    groups = {
        "running mission": (*REQUESTS, *CHOOSING),
        "recording": PLAYING,
        "both": (*LOOKING, *LEAVING),
    }
    rows = ["| key | action |", "|---|---|"]
    for view, keys in groups.items():
        rows.append(f"| **{view}** | |")
        rows += [f"| `{key.shown}` | {key.help} |" for key in keys if key.help]
    return "\n".join(rows)


def between(name: str, table: str, page: str) -> str:
    """Return a page with a table between the comments ``begin NAME`` and ``end NAME``."""
    begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
    before, _, rest = page.partition(begin)
    _, mark, after = rest.partition(end)
    if not mark:
        raise SystemExit(f"expected '{begin}' and '{end}' in the page")
    return f"{before}{begin}\n\n{table}\n\n{end}{after}"


# ---- the page of keys --------------------------------------------------------------------------

HEAD = """# Keys of files

All keys of worlds, robots and fleets. This page is generated (`make generated`). Other files:

| file | keys |
|---|---|
| mission | [Mission language](mission-language.md#the-file) |
| scenario | [Scenarios](scenarios.md) |
| requirements | [Requirements](requirements.md) |
| ranges | [Ranges](ranges.md#keys) |

`bt-mission check FILE...` recognizes each kind by its content and checks it. `bt-mission schema
KIND` prints its JSON Schema, for editors with a YAML language server.

Keys in bold are required. A default follows its key. `0 to 1` includes both ends; `string (≤ 60)`
has at most 60 characters; `3 x > 0` is a list of three positive numbers.
"""

KINDS: Mapping[str, tuple[str, Any]] = {
    "world": ("Worlds", world_schema),
    "robot": ("Robots", robot_schema),
    "fleet": ("Fleets", fleet_schema),
}
"""The kinds of file: how each is called, and what gives its schema."""


def keys_page() -> str:
    """Return the page of the keys of files, from the models that read them."""
    parts = [HEAD]
    seen: set[str] = set()
    for kind, (title, schema) in KINDS.items():
        parts.append(f"## {title}\n\n`bt-mission schema {kind}`\n")
        parts += _tables(schema(), seen)
    return "\n".join(parts)


def _tables(schema: Mapping[str, Any], seen: set[str]) -> Iterator[str]:
    """Yield a table for a file, and a list for each part of it that has none yet."""
    definitions = schema.get("$defs", {})
    rows = [f"| {names} | {value} |" for names, value in _keys(schema, definitions)]
    yield "\n".join([*_description(schema), "| key | value |", "|---|---|", *rows, ""])
    for name, part in definitions.items():
        if "properties" in part and name not in seen:
            seen.add(name)
            items = [f"- {names}: {value}" for names, value in _keys(part, definitions)]
            yield "\n".join([f"### {_words(name)}", "", *_description(part), *items, ""])


def _description(part: Mapping[str, Any]) -> list[str]:
    text = " ".join(part.get("description", "").split())
    return [text, ""] if text else []


def _keys(part: Mapping[str, Any], definitions: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield the keys of a part with their values in words; keys with equal values together."""
    required = part.get("required", ())
    rows: dict[str, list[str]] = {}
    for key, value in part["properties"].items():
        name = f"**`{key}`**" if key in required else f"`{key}`{_default(value)}"
        rows.setdefault(_value(value, definitions), []).append(name)
    for value, names in rows.items():
        yield ", ".join(names), value


def _value(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    """Return the values of a key in words."""
    if "$ref" in value:
        name = value["$ref"].rpartition("/")[2]
        part = definitions.get(name, {})
        return _link(name) if "properties" in part else _value(part, definitions)
    if "enum" in value or "const" in value:
        choices = value.get("enum", [value.get("const")])
        return ", ".join(f"`{choice}`" for choice in choices)
    several = value.get("anyOf") or value.get("oneOf")
    if several:
        words = (_value(schema, definitions) for schema in several if schema.get("type") != "null")
        return " or ".join(dict.fromkeys(words))
    if "x-fault" in value or "x-obstacle" in value:
        return "list ([scenarios](scenarios.md))"
    kind = value.get("type", "anything")
    if isinstance(kind, list):
        return " or ".join(_KINDS.get(type_, type_) for type_ in kind)
    if kind == "array":
        return _array(value, definitions)
    named = [*value.get("patternProperties", {}).values(), value.get("additionalProperties")]
    inner = named[0]
    if kind == "object" and isinstance(inner, Mapping):
        return f"names, each with {_value(inner, definitions)}"
    return _scalar(value)


def _array(value: Mapping[str, Any], definitions: Mapping[str, Any]) -> str:
    if "prefixItems" in value:
        each = {_value(item, definitions) for item in value["prefixItems"]}
        return f"{len(value['prefixItems'])} x {', '.join(each)}"
    inner = value.get("items")
    return f"list of {_value(inner, definitions)}" if inner else "list"


def _scalar(value: Mapping[str, Any]) -> str:
    kind = value.get("type", "anything")
    name = _KINDS.get(kind, kind)
    if "maxLength" in value:
        return f"{name} (≤ {value['maxLength']})"
    words = {"minimum": "≥ {}", "exclusiveMinimum": "> {}", "maximum": "≤ {}"}
    words["exclusiveMaximum"] = "< {}"
    if {"minimum", "maximum"} <= value.keys():
        words |= {"minimum": "{}", "maximum": "to {}"}
    limits = [text.format(f"{value[key]:,.10g}") for key, text in words.items() if key in value]
    names = [] if limits and kind == "number" else [name]
    return " ".join([*names, *limits])


def _default(value: Mapping[str, Any]) -> str:
    default = value.get("default")
    if default is None or isinstance(default, dict) or default in ([], ""):
        return ""
    return f" = {json.dumps(default)}"


def _link(name: str) -> str:
    words = _words(name)
    return f"[{words}](#{words.lower().replace(' ', '-')})"


def _words(name: str) -> str:
    """Return the name of a model in words: `FleetRobotForm` is a fleet robot."""
    short = name.removesuffix("Form").removesuffix("Model")
    words = "".join(
        f" {letter.lower()}" if letter.isupper() else letter for letter in short
    ).strip()
    return words[:1].upper() + words[1:]


_KINDS = {
    "number": "number",
    "integer": "integer",
    "string": "string",
    "boolean": "`true` or `false`",
    "object": "mapping",
    "array": "list",
}


# ---- the pages of errors -----------------------------------------------------------------------

ERRORS_HEAD = """# Errors and warnings

Every error and warning ends with its code, such as `[BT-203]`. A code stands for one kind of
mistake, and never changes. Each code has a cause, a minimal example, a cure and the corrected
example. `bt-mission explain BT-203` prints them; `bt-mission check --json` has the code in `code`
and the address of its explanation in `url`.
"""

ERRORS_PAGE_HEAD = """# BT-{block}: {group}

One of the [groups of errors](../errors.md).
"""


def errors_page() -> str:
    """Return the table of all codes, from their catalogue."""
    rows = ["| code | mistake |", "|---|---|"]
    for page, members in groupby(catalogue().values(), lambda entry: entry.page):
        entries = list(members)
        path = page.removeprefix("reference/")
        rows.append(f"| [**BT-{_block_of(entries)}**]({path}) | **{entries[0].group}** |")
        rows += [f"| [{each.code}]({path}#{each.anchor}) | {each.title} |" for each in entries]
    return "\n".join([ERRORS_HEAD, *rows, ""])


def _block_of(entries: Sequence[CatalogueEntry]) -> str:
    """Return the codes of a page: ``2xx``."""
    return f"{entries[0].code[:-2].removeprefix('BT-')}xx"


def error_pages() -> Mapping[str, str]:
    """Return the page of each block of codes, by its path below docs/."""
    pages: dict[str, str] = {}
    for page, members in groupby(catalogue().values(), lambda entry: entry.page):
        entries = list(members)
        head = ERRORS_PAGE_HEAD.format(block=_block_of(entries), group=entries[0].group)
        pages[page] = "\n".join([head, *map(_entry, entries)])
    return pages


def _entry(entry: CatalogueEntry) -> str:
    text = f"## {entry.code}\n\n{entry.cause}\n\n"
    if entry.wrong:
        text += f"{_block(entry, entry.wrong)}\n"
    text += f"{entry.cure}\n"
    return f"{text}\n{_block(entry, entry.right)}" if entry.right else text


def _block(entry: CatalogueEntry, example: str) -> str:
    language = "console" if entry.is_command else entry.file.rpartition(".")[2]
    return f"```{language}\n{shown(example)}\n```\n"


def _always(text: str) -> Callable[[str], str]:
    return lambda _: text


# ---- the files ---------------------------------------------------------------------------------

GENERATED: Mapping[Path, Callable[[str], str]] = {
    DOCS / "reference" / "scenarios.md": lambda page: between("faults", fault_list(), page),
    **({SEARCH: lambda page: between("faults", fault_groups(), page)} if SEARCH.is_file() else {}),
    DOCS / "reference" / "nature.md": lambda page: between("quantities", nature_table(), page),
    DOCS / "reference" / "actions.md": actions_page,
    DOCS / "reference" / "nav2.md": lambda page: between("served actions", nav2_table(), page),
    DOCS / "reference" / "terminal.md": lambda page: between("keys", key_table(), page),
    DOCS / "reference" / "files.md": lambda _: keys_page(),
    DOCS / "reference" / "errors.md": lambda _: errors_page(),
    **{DOCS / page: _always(text) for page, text in error_pages().items()},
    DOCS / "images" / "layers.svg": lambda _: draw(),
}
"""Each file, and what its text becomes."""


def main() -> None:
    """Write the files; remove pages of errors that no command reports."""
    for path in {*(DOCS / "reference" / "errors").iterdir()} - GENERATED.keys():
        path.unlink()
    for path, text in GENERATED.items():
        before = path.read_text(encoding="utf-8") if path.is_file() else ""
        path.write_text(text(before), encoding="utf-8")
        print(path)


if __name__ == "__main__":
    main()
