"""The facts that a recorder has written besides messages: those of the start, a summary."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import AfterValidator, Field, TypeAdapter
from typing_extensions import TypedDict

from bt_mission.base.nature_field import read_nature

FACTS, SUMMARY = "bt_mission", "bt_mission_summary"
"""The names of the metadata records."""

MISSIONS = "missions"
"""The fact that names the executives' nodes, where several missions are in a recording."""

LARGEST_NS = 2**63 - 1
"""Times of ROS are no larger, ns."""


def note_of(kind: str, node: str) -> str:
    """Return the name of the record of one of several missions, by its executive's node."""
    return f"{kind} {node}"


def robot_of(node: str) -> str:
    """Return the robot of an executive's node: its namespace; empty without one."""
    return node.rpartition("/")[0].strip("/")


Number = Annotated[float, Field(ge=-LARGEST_NS, le=LARGEST_NS, allow_inf_nan=False)]
Count = Annotated[int, Field(ge=0, le=LARGEST_NS)]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]
OwnNode = Annotated[list[str], Field(min_length=3, max_length=3)]
"""The file that names it, its target, and the name of a program or nothing."""


def _with_nature(written: dict[str, Any]) -> dict[str, Any]:
    read_nature(written)
    return written


class StageRobot(TypedDict):
    """A robot of a simulation; a robot alone has no name."""

    name: str
    start: Three | None
    nature: Annotated[dict[str, Any], AfterValidator(_with_nature)]


class StageFacts(TypedDict):
    """The options of a simulation, on which a run depends."""

    sensor_seed: Count
    props: Count
    without: list[Any]
    has_tools: bool
    is_visible: bool
    robots: Annotated[list[StageRobot], Field(min_length=1)]
    nodes: list[OwnNode]


_KINDS: Mapping[str, Mapping[str, Any]] = {
    FACTS: {
        "start_ns": Count,
        "robot_hull": Three | None,
        "versions": dict[str, Any],
        "inputs": dict[str, Any],
        "stage": StageFacts,
        "simulation": dict[str, Any],
        "requirements": list[dict[str, Any]],
        "changes": list[Any],
        "faults": list[str],
        MISSIONS: list[str],
    },
    SUMMARY: {
        "virtual_s": Number,
        "wall_s": Number,
        "distance_travelled_m": Number | None,
        "goals_left_behind": Count,
        "collisions": Count | None,
        "trace_sha256": str,
        "requirements": list[Any],
        "warnings": list[str],
        "missing": str,
    },
}
"""The values that are read as JSON, and their types, by metadata record."""

_KNOWN: Mapping[tuple[str, str], TypeAdapter[Any]] = {
    (note, name): TypeAdapter(kind)
    for note, kinds in _KINDS.items()
    for name, kind in kinds.items()
}


class RunFacts:
    """The facts of a run, as values.

    A value in another form than the recorder's is omitted, and named.

    Args:
        notes: The metadata records of a file, by name.
        node: The executive of one of several missions; empty is the first.
    """

    def __init__(self, notes: Mapping[str, Mapping[str, str]], node: str = "") -> None:
        self.texts: Mapping[str, str] = notes.get(note_of(FACTS, node), notes.get(FACTS, {}))
        """The texts of the file."""
        self.unread: list[str] = []
        """The names of those that cannot be read."""
        self.summary: Mapping[str, Any] = self._values(
            SUMMARY, notes.get(note_of(SUMMARY, node), notes.get(SUMMARY, {}))
        )
        """The result of the run; empty if it is missing."""
        texts = {name: self.texts[name] for name in _KINDS[FACTS] if name in self.texts}
        self._facts = self._values(FACTS, texts)
        self._first = notes.get(FACTS, {})

    @property
    def node(self) -> str:
        """Full name of the executive's node; empty if another recorder has written the file."""
        return self.texts.get("node", "")

    @property
    def missions(self) -> Sequence[str]:
        """The nodes of the executives with missions in the file; the first is shown first."""
        names = self._values(FACTS, {MISSIONS: self._first.get(MISSIONS, "[]")}).get(MISSIONS)
        return names or ([self.node] if self.node else [])

    @property
    def namespace(self) -> str:
        """Of the robot."""
        return self.texts.get("namespace", "/")

    @property
    def start_ns(self) -> int | None:
        """ROS time at which a simulation starts, ns; None for other servers."""
        return self._facts.get("start_ns") if "world" in self.texts else None

    @property
    def hull(self) -> tuple[float, float, float] | None:
        """Front, rear and half width of the robot, m; None if it is not known."""
        footprint = self._facts.get("robot_hull")
        return None if footprint is None else (footprint[0], footprint[1], footprint[2])

    @property
    def versions(self) -> Mapping[str, Any]:
        """The versions of the software that ran it."""
        return self._mapping("versions")

    @property
    def inputs(self) -> Mapping[str, Any]:
        """Of the mission."""
        return self._mapping("inputs")

    @property
    def stage(self) -> Mapping[str, Any] | None:
        """The parameters of the simulation; None for a live run, and in old recordings."""
        return self._facts.get("stage")

    @property
    def changes(self) -> Sequence[Any]:
        """The changes in the run, if it is a fork of another."""
        recorded: Sequence[Any] = self._facts.get("changes", ())
        return recorded

    @property
    def faults(self) -> Sequence[str]:
        """The faults that were injected, as text."""
        recorded: Sequence[str] = self._facts.get("faults", ())
        return recorded

    @property
    def simulation(self) -> Mapping[str, Any]:
        """How to read states of the simulation; empty if none were recorded."""
        return self._mapping("simulation")

    @property
    def requirements(self) -> Sequence[Mapping[str, Any]]:
        """Of the mission, as :func:`bt_mission.recording.signal_samples.written` has them."""
        recorded: Sequence[Mapping[str, Any]] = self._facts.get("requirements", ())
        return recorded

    @property
    def missing(self) -> str:
        """The parts that the recorder could not record; empty if it is complete."""
        return str(self.summary.get("missing", ""))

    def _mapping(self, name: str) -> Mapping[str, Any]:
        recorded: Mapping[str, Any] = self._facts.get(name, {})
        return recorded

    def _values(self, note: str, texts: Mapping[str, str]) -> Mapping[str, Any]:
        values = {}
        for name, text in texts.items():
            known = _KNOWN.get((note, name))
            try:
                values[name] = json.loads(text)
                if known is not None:
                    known.validate_python(values[name], strict=True)
            except (ValueError, RecursionError):
                values.pop(name, None)
                self.unread.append(name)
        return values
