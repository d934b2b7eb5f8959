"""Names that a shell completes: of shipped files and one's own, of inputs, of the running graph."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_mission.cli.commands import COMMANDS
from bt_mission.core.errors import BtMissionError
from bt_mission.core.files import fleets, is_file, is_scenario, look_for, names, scenarios

if TYPE_CHECKING:
    from bt_mission.graph_tools.live_names import LiveKind

_PLAIN_NAME = re.compile(r"[\w.+@%/-]+(=[\w.+@%/-]*)?", re.ASCII)
"""Names that a shell takes as they are: it expands `$(...)` and blanks in what it completes."""


def known(kind: str, line: str = "") -> list[str]:
    """Return the names of a kind that fit a command line so far; what a shell expands is left out.

    Nothing is said of what cannot be read or is not there: somebody is typing.

    Raises:
        KeyError: For a kind that is none of :data:`KINDS`.
    """
    try:
        found = KINDS[kind](_words(line))
    except BtMissionError:
        return []
    return [name for name in found if _PLAIN_NAME.fullmatch(name)]


def _words(line: str) -> list[str]:
    """Split a command line as far as it goes: its last quotes may be open."""
    try:
        return shlex.split(line)
    except ValueError:
        return re.split(r"[\s'\"]+", line)


def _runs(_: list[str]) -> list[str]:
    return [*names("missions"), *scenarios(), *fleets()]


def _listed(_: list[str]) -> list[str]:
    from bt_mission.core.file_index import list_files

    return [one.name for one in list_files("missions")]


def _inputs(words: list[str]) -> list[str]:
    """Name the inputs of the first mission or scenario of the line."""
    program, *rest = words or [""]
    given = rest if Path(program).name == "bt-mission" else words
    if given and given[0] in COMMANDS:  # a shipped mission has the name of a command
        given = given[1:]
    for word in given:
        path = None if word.startswith("-") else look_for("missions", word)
        if path is not None:
            return [
                text
                for name, places in _inputs_of(path).items()
                for text in (f"{name}=", *(f"{name}={place}" for place in places))
            ]
    return []


def _inputs_of(path: Path) -> dict[str, list[str]]:
    """Read the inputs of a mission, or of the one of a scenario, without checking it.

    Those that hold the name of a place have the names of all places.
    """
    from bt_mission.core.yaml.document import read

    if path.suffix == ".xml":
        return {}
    if is_scenario(path):
        data = _mapping(read(path).data)
        name = str(data.get("mission") or "")
        beside = path.parent / name
        inner = beside if is_file(beside) else look_for("missions", name, path)
        return {} if inner is None or is_scenario(inner) else _inputs_of(inner)
    from bt_mission.language.expressions.places import Places
    from bt_mission.language.places import zones_of_file

    data = _mapping(read(path).data)
    zones = zones_of_file(str(data.get("world") or ""), str(path))
    own = {str(name): (0.0, 0.0, 0.0) for name in _mapping(data.get("places"))}
    places = Places(own, lambda: zones)
    return {
        str(name): sorted(places.all) if isinstance(value, str) and places.find(value) else []
        for name, value in _mapping(data.get("inputs")).items()
    }


def _mapping(value: Any) -> Mapping[Any, Any]:
    return value if isinstance(value, dict) else {}


def _live(kind: LiveKind) -> Callable[[list[str]], list[str]]:
    """Make the lookup of a kind of names of the graph that the line is about."""

    def look(words: list[str]) -> list[str]:
        from bt_mission.core.dds.discovery import restrict_discovery
        from bt_mission.core.dds.middleware import prepare_middleware

        restrict_discovery(network="--network" in words)
        prepare_middleware()
        from bt_mission.graph_tools.live_names import live_names

        return live_names(kind)

    return look


KINDS: Mapping[str, Callable[[list[str]], list[str]]] = {
    "missions": lambda _: names("missions"),
    "runs": _runs,
    "listed": _listed,
    "worlds": lambda _: names("worlds"),
    "robots": lambda _: names("robots"),
    "parameters": lambda _: names("parameters"),
    "inputs": _inputs,
    "actions": _live("actions"),
    "topics": _live("topics"),
    "services": _live("services"),
    "executives": _live("executives"),
    "namespaces": _live("namespaces"),
}
"""What is completed by name; runs are missions, scenarios and fleets, listed all of `missions`."""

FILES = ("missions", "runs", "listed", "worlds", "robots", "parameters")
"""Those for which a file of one's own will do, too."""
