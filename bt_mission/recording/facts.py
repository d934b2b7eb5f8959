"""What a recorder has written down of a run besides messages: facts at its start, a summary."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pydantic_core import PydanticCustomError

from bt_mission.core.nature_field import read_nature

FACTS, SUMMARY = "bt_mission", "bt_mission_summary"
"""The names of the metadata records."""

MISSIONS = "missions"
"""The fact that names the executives' nodes, where several missions are in a recording."""

LARGEST_NS = 2**63 - 1
"""Times of ROS are no larger, ns."""


def note_of(kind: str, node: str) -> str:
    """Return the name of the record about one of several missions, by its executive's node."""
    return f"{kind} {node}"


def robot_of(node: str) -> str:
    """Return the robot of an executive's node: its namespace; empty of a robot without one."""
    return node.rpartition("/")[0].strip("/")


IsValid = Callable[[Any], bool]


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) <= LARGEST_NS


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value <= LARGEST_NS


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_mapping(value: Any) -> bool:
    return isinstance(value, dict)


def _is_hull(value: Any) -> bool:
    return isinstance(value, list) and len(value) == 3 and all(map(_is_number, value))


def _is_list(value: Any) -> bool:
    return isinstance(value, list)


def _is_texts(value: Any) -> bool:
    return _is_list(value) and all(map(_is_text, value))


def _is_requirements(value: Any) -> bool:
    return _is_list(value) and all(map(_is_mapping, value))


def _is_pair_of_texts(value: Any) -> bool:
    return _is_list(value) and len(value) == 2 and all(isinstance(one, str) for one in value)


def _is_nature(value: Any) -> bool:
    try:
        read_nature(value)
    except PydanticCustomError:
        return False
    return isinstance(value, dict)


_STAGE: Mapping[str, IsValid] = {
    "sensor_seed": _is_count,
    "start": lambda value: value is None or _is_hull(value),
    "nature": _is_nature,
    "props": _is_count,
    "without": _is_list,
    "has_tools": lambda value: isinstance(value, bool),
    "is_visible": lambda value: isinstance(value, bool),
    "robots": _is_list,
    "nodes": lambda value: _is_list(value) and all(map(_is_pair_of_texts, value)),
}


def _is_stage(value: Any) -> bool:
    return isinstance(value, dict) and all(
        name in value and is_valid(value[name]) for name, is_valid in _STAGE.items()
    )


def _or_none(is_valid: IsValid) -> IsValid:
    return lambda value: value is None or is_valid(value)


_KNOWN: Mapping[tuple[str, str], IsValid] = {
    (FACTS, "start_ns"): _is_count,
    (FACTS, "robot_hull"): _or_none(_is_hull),
    (FACTS, "versions"): _is_mapping,
    (FACTS, "inputs"): _is_mapping,
    (FACTS, "stage"): _is_stage,
    (FACTS, "simulation"): _is_mapping,
    (FACTS, "requirements"): _is_requirements,
    (FACTS, "changes"): _is_list,
    (FACTS, "faults"): _is_texts,
    (FACTS, MISSIONS): _is_texts,
    (SUMMARY, "virtual_s"): _is_number,
    (SUMMARY, "wall_s"): _is_number,
    (SUMMARY, "distance_travelled_m"): _or_none(_is_number),
    (SUMMARY, "goals_left_behind"): _is_count,
    (SUMMARY, "collisions"): _or_none(_is_count),
    (SUMMARY, "trace_sha256"): _is_text,
    (SUMMARY, "requirements"): _is_list,
    (SUMMARY, "missing"): _is_text,
}
"""What is read of the values that are JSON, and what each has to be."""


class RunFacts:
    """The facts of a run, as values. What is not as our recorder writes it is left out, and named.

    Args:
        notes: The metadata records of a file, by name.
        node: Of which executive's mission, where there are several; empty is the first.
    """

    def __init__(self, notes: Mapping[str, Mapping[str, str]], node: str = "") -> None:
        self.texts: Mapping[str, str] = notes.get(note_of(FACTS, node), notes.get(FACTS, {}))
        """As they are in the file."""
        self.unread: list[str] = []
        """The names of those that cannot be read."""
        self.summary: Mapping[str, Any] = self._values(
            SUMMARY, notes.get(note_of(SUMMARY, node), notes.get(SUMMARY, {}))
        )
        """What the run came to; empty where it was not told."""
        known = [name for note, name in _KNOWN if note == FACTS]
        texts = {name: self.texts[name] for name in known if name in self.texts}
        self._facts = self._values(FACTS, texts)
        self._first = notes.get(FACTS, {})

    @property
    def node(self) -> str:
        """Full name of the executive's node; empty where no recorder of ours has made the file."""
        return self.texts.get("node", "")

    @property
    def missions(self) -> Sequence[str]:
        """The nodes of the executives whose missions are in the file; the first is shown first."""
        found = self._values(FACTS, {MISSIONS: self._first.get(MISSIONS, "[]")}).get(MISSIONS)
        return found or ([self.node] if self.node else [])

    @property
    def namespace(self) -> str:
        """Of the robot."""
        return self.texts.get("namespace", "/")

    @property
    def start_ns(self) -> int | None:
        """ROS time from which a simulation counts, ns; None against servers of others."""
        return self._facts.get("start_ns") if "world" in self.texts else None

    @property
    def hull(self) -> tuple[float, float, float] | None:
        """Front, rear and half width of the robot, m; None where it is not known."""
        found = self._facts.get("robot_hull")
        return None if found is None else (found[0], found[1], found[2])

    @property
    def versions(self) -> Mapping[str, Any]:
        """Of what has carried the run out."""
        return self._mapping("versions")

    @property
    def inputs(self) -> Mapping[str, Any]:
        """Of the mission."""
        return self._mapping("inputs")

    @property
    def stage(self) -> Mapping[str, Any] | None:
        """Of the simulation, what a run depends on; None of a live run, and in old recordings."""
        return self._facts.get("stage")

    @property
    def changes(self) -> Sequence[Any]:
        """What was changed in the run while it was under way, where it is a fork of another."""
        found: Sequence[Any] = self._facts.get("changes", ())
        return found

    @property
    def faults(self) -> Sequence[str]:
        """What was made to go wrong in the run, as it is written."""
        found: Sequence[str] = self._facts.get("faults", ())
        return found

    @property
    def simulation(self) -> Mapping[str, Any]:
        """How states of the simulation are read; empty where none were recorded."""
        return self._mapping("simulation")

    @property
    def requirements(self) -> Sequence[Mapping[str, Any]]:
        """Of the mission, as :func:`bt_mission.recording.signal_samples.written` has them."""
        found: Sequence[Mapping[str, Any]] = self._facts.get("requirements", ())
        return found

    @property
    def missing(self) -> str:
        """What the recorder could not record; empty where it could everything."""
        return str(self.summary.get("missing", ""))

    def _mapping(self, name: str) -> Mapping[str, Any]:
        found: Mapping[str, Any] = self._facts.get(name, {})
        return found

    def _values(self, note: str, texts: Mapping[str, str]) -> Mapping[str, Any]:
        found = {}
        for name, text in texts.items():
            try:
                value = json.loads(text)
            except (ValueError, RecursionError):
                self.unread.append(name)
                continue
            if _KNOWN.get((note, name), lambda _: True)(value):
                found[name] = value
            else:
                self.unread.append(name)
        return found
