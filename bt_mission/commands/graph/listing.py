"""The content of a graph, as tables for people and as objects for programs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from bt_mission.base.diagnostics import listed
from bt_mission.base.text import columns, escape_control
from bt_mission.commands.graph.graph_query import GraphEntry, Kind
from bt_mission.commands.graph.interface_description import (
    InterfaceDescription,
    InterfaceField,
    InterfacePart,
)
from bt_mission.commands.graph.values import short
from bt_mission.language.message_types import ListOf, MessageShape

NOBODY = "nobody"
FIELD_KEYS = ("name", "type", "unit", "default", "text")


def entry_rows(kind: Kind, entries: Iterable[GraphEntry]) -> Iterator[Sequence[str]]:
    """Return name and type; the servers of actions; the numbers of publishers and subscribers."""
    if kind == "topic":
        yield "topic", "type", "publishers", "subscribers"
    for entry in entries:
        row = [entry.name, listed(entry.types)]
        if kind == "action":
            row.append(listed(entry.offers or [NOBODY]))
        elif kind == "topic":
            row += [str(len(entry.offers)), str(len(entry.uses))]
        yield row


def entry_object(kind: Kind, entry: GraphEntry) -> dict[str, object]:
    """The same for programs, with the nodes of actions and topics."""
    roles = {"action": ("servers", "clients"), "topic": ("publishers", "subscribers")}.get(kind, ())
    nodes = zip(roles, (entry.offers, entry.uses), strict=False)
    return {
        "name": entry.name,
        "types": list(entry.types),
        **{role: list(names) for role, names in nodes},
    }


def info_lines(entry: GraphEntry, about: InterfaceDescription) -> Iterator[str]:
    """The description of an action: its nodes, and the fields of its three messages."""
    yield escape_control(f"{entry.name}  {about.type}")
    if about.text:
        yield f"  {escape_control(about.text)}"
    yield f"served by  {listed(entry.offers or [NOBODY])}"
    yield f"used by    {listed(entry.uses or [NOBODY])}"
    for part in about.parts:
        yield ""
        yield from part_lines(part)


def part_lines(part: InterfacePart) -> Iterator[str]:
    """Return the fields of one message with types, units, defaults, comments, and its constants."""
    fields = part.fields()
    yield part.name if fields else f"{part.name}: no fields"
    yield from columns(
        (
            "  " * (field.depth + 1) + field.name.rpartition(".")[2],
            field.type,
            field.unit,
            "" if part.name in ("result", "feedback", "response") else default_of(field),
            field.text,
        )
        for field in fields
    )
    if part.section.constants:
        yield "  named values"
        yield from columns(
            (f"    {constant.name}", constant.value, constant.type, constant.text)
            for constant in part.section.constants
        )


def default_of(field: InterfaceField) -> str:
    """Return a field's default as text; empty for a message, whose fields have defaults."""
    if isinstance(field.shape, MessageShape):
        return ""
    if isinstance(field.shape, ListOf) and len(field.default) > 8:
        return f"{len(field.default)} items"
    return f"= {short(field.default)}"


def info_object(entry: GraphEntry, about: InterfaceDescription) -> dict[str, object]:
    """The same for programs."""
    return {
        "name": entry.name,
        "type": about.type,
        "text": about.text,
        "servers": list(entry.offers),
        "clients": list(entry.uses),
        **{
            part.name: [{key: getattr(field, key) for key in FIELD_KEYS} for field in part.fields()]
            for part in about.parts
        },
        "constants": {
            part.name: {constant.name: constant.value for constant in part.section.constants}
            for part in about.parts
        },
    }
