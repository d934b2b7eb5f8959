"""A parameter file of ROS, read with the place of every value."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_mission.core.diagnostics import Diagnostic, InputError, did_you_mean, in_order, listed
from bt_mission.core.yaml.document import Document, read

ANY_NODE = "/**"
NODES = ("bt_mission_servers", "bt_mission_arbiter", "bt_mission_mapper")
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
        """Raise InputError where a name is not among the known: ROS passes over a typing error."""
        faults = [
            self.document.diagnostic(
                "BT-806",
                self.places[name],
                f"no such parameter '{name}' (known: {listed(sorted(known))})",
                hint=did_you_mean(name, sorted(known)),
                key=True,
            )
            for name in self.values
            if name not in known
        ]
        if faults:
            raise InputError(in_order(faults))


def read_parameters(path: str | Path, node: str) -> ParameterFile:
    """Read the values for a node in a parameter file: below `/**`, and below the node's name.

    Sections of other nodes of this project are skipped. Raises InputError with every mistake and
    its place.
    """
    document = read(path)
    faults: list[Diagnostic] = []
    values: dict[str, Any] = {}
    places: dict[str, Keys] = {}
    sections = document.data if isinstance(document.data, dict) else {}
    if not sections:
        faults.append(
            document.diagnostic("BT-806", (), f"expected '{ANY_NODE}:' or '{node}:', got neither")
        )
    for section, content in sections.items():
        if section not in {ANY_NODE, *NODES}:
            message = f"no such node '{section}' (known: {listed([ANY_NODE, *NODES])})"
            hint = did_you_mean(str(section), NODES)
            faults.append(document.diagnostic("BT-806", (section,), message, hint=hint, key=True))
        elif not isinstance(content, dict) or set(content) != {PARAMETERS}:
            faults.append(
                document.diagnostic("BT-806", (section,), f"expected only '{PARAMETERS}:' here")
            )
        elif section in {ANY_NODE, node} and isinstance(content[PARAMETERS], dict):
            for keys, value in _leaves(content[PARAMETERS], (section, PARAMETERS)):
                name = ".".join(str(key) for key in keys[2:])
                values[name], places[name] = value, keys
                if not isinstance(value, bool | int | float | str):
                    faults.append(
                        document.diagnostic("BT-806", keys, f"expected a value for '{name}'")
                    )
    if faults:
        raise InputError(in_order(faults))
    return ParameterFile(document, values, places)


def _leaves(data: Mapping[str, Any], above: Keys) -> Iterator[tuple[Keys, Any]]:
    for key, value in data.items():
        if isinstance(value, dict) and value:
            yield from _leaves(value, (*above, key))
        else:
            yield (*above, key), value
