"""A parameter file of ROS, read with the place of every value."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_mission.base.diagnostics import Diagnostic, InputError, did_you_mean, in_order, listed
from bt_mission.base.yaml.document import Document, read

ANY_NODE = "/**"
NODES = (
    "bt_mission",
    "bt_mission_sim",
    "bt_mission_servers",
    "bt_mission_arbiter",
    "bt_mission_mapper",
)
"""The nodes of this project."""
PARAMETERS = "ros__parameters"

Keys = tuple[str | int, ...]


@dataclass(frozen=True)
class ParameterFile:
    """Values by their dotted names ("topics.scan"), as written for one node."""

    document: Document
    values: Mapping[str, Any]
    places: Mapping[str, Keys]

    def diagnostic(self, name: str, message: str, hint: str | None = None) -> Diagnostic:
        """Return a diagnostic at the value of that name."""
        return self.document.diagnostic("BT-806", self.places[name], message, hint=hint)

    def refuse_unknown(self, known: Collection[str]) -> None:
        """Raise InputError where a name is not among the known: ROS passes over a typing error.

        A wildcard may also name parameters of other nodes, unless it nearly names a known one.
        """
        diagnostics = [
            self.document.diagnostic(
                "BT-806",
                self.places[name],
                f"no such parameter '{name}' (known: {listed(sorted(known))})",
                hint=did_you_mean(name, sorted(known)),
                key=True,
            )
            for name in self.values
            if name not in known
            and (_is_node(self.places[name]) or did_you_mean(name, sorted(known)))
        ]
        if diagnostics:
            raise InputError(in_order(diagnostics))


def read_parameters(path: str | Path, node: str, namespace: str = "") -> ParameterFile:
    """Read the values for a node in a parameter file: below every section that names it, as in ROS.

    A section names a node by its full name, also nested by namespaces, or with the wildcards `*`
    and `**`. Sections of other nodes are skipped. Raises InputError with every mistake and its
    place; a name that differs little from a known one is one.
    """
    document = read(path)
    diagnostics: list[Diagnostic] = []
    values: dict[str, Any] = {}
    places: dict[str, Keys] = {}
    sections = dict(_sections(document.data, ()))
    full_name = "/".join(("", *filter(None, namespace.split("/")), node))
    if not any(_is_ours(keys) for keys in sections):
        what = f"'{ANY_NODE}:' or '{node}:'"
        diagnostics.append(document.diagnostic("BT-806", (), f"expected {what}, got neither"))
    for keys, content in sections.items():
        hint = did_you_mean(str(keys[-1]).rpartition("/")[2], NODES)
        if not _is_ours(keys):
            if hint is not None:
                message = f"no such node '{keys[-1]}' (known: {listed([ANY_NODE, *NODES])})"
                diagnostic = document.diagnostic("BT-806", keys, message, hint=hint, key=True)
                diagnostics.append(diagnostic)
        elif set(content) != {PARAMETERS}:
            diagnostics.append(
                document.diagnostic("BT-806", keys, f"expected only '{PARAMETERS}:' here")
            )
        elif _names(keys, full_name) and isinstance(content[PARAMETERS], dict):
            for below, value in _leaves(content[PARAMETERS], (*keys, PARAMETERS)):
                name = ".".join(str(key) for key in below[len(keys) + 1 :])
                values[name], places[name] = value, below
                if not isinstance(value, bool | int | float | str):
                    diagnostics.append(
                        document.diagnostic("BT-806", below, f"expected a value for '{name}'")
                    )
    if diagnostics:
        raise InputError(in_order(diagnostics))
    return ParameterFile(document, values, places)


def _sections(data: Any, above: Keys) -> Iterator[tuple[Keys, dict[Any, Any]]]:
    """Yield the sections of nodes, at the top and below namespaces; and ours without parameters."""
    for key, content in data.items() if isinstance(data, dict) else ():
        keys = (*above, key)
        if not isinstance(content, dict):
            if _is_ours(keys):
                yield keys, {}
        elif PARAMETERS in content or _is_ours(keys):
            yield keys, content
        else:
            yield from _sections(content, keys)


def _is_ours(keys: Keys) -> bool:
    """Return whether a section is of one of our nodes, or of several nodes by a wildcard."""
    last = str(keys[-1]).rpartition("/")[2]
    return last in NODES or last in {"*", "**"}


def _is_node(place: Keys) -> bool:
    """Return whether the section of a value names a single node."""
    section = place[: place.index(PARAMETERS)]
    return "*" not in "/".join(map(str, section))


def _names(keys: Keys, full_name: str) -> bool:
    """Return whether a section names a node: `*` is any part of a name, `**` any number of them."""
    parts = filter(None, "/".join(map(str, keys)).split("/"))
    wild = {"*": "/[^/]+", "**": "(?:/[^/]+)*"}
    return bool(
        re.fullmatch("".join(wild.get(part, f"/{re.escape(part)}") for part in parts), full_name)
    )


def _leaves(data: Mapping[str, Any], above: Keys) -> Iterator[tuple[Keys, Any]]:
    for key, value in data.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, (*above, key))
        else:
            yield (*above, key), value
