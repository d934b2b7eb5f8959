"""What the records of a journal come to: where a mission stood when the last one was written."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from bt_mission.core.errors import BtMissionError
from bt_mission.executive.journal.file import FORMAT

if TYPE_CHECKING:
    from bt_mission.language.mission import Mission

Record = dict[str, Any]


@dataclass
class JournalState:
    """Nodes, variables, random generators and goals, as JSON.

    Args:
        head: The first record: whose journal this is.
        nodes: Path to status, what the node remembers, and the ROS time of that, ns.
        values: Path of the tree with variables of its own (the root's is ``0``), to its variables.
        generators: Name to state.
        requirements: What each had come to, by its name.
        goals: UUID to the record of a goal whose end is not confirmed.
        time_ns: ROS time of the newest record.
        end: How the mission ended, where it has.
    """

    head: Record
    nodes: dict[str, list[Any]] = field(default_factory=dict)
    values: dict[str, dict[str, Any]] = field(default_factory=dict)
    generators: dict[str, Any] = field(default_factory=dict)
    goals: dict[str, Record] = field(default_factory=dict)
    requirements: dict[str, Record] = field(default_factory=dict)
    time_ns: int = 0
    end: Record | None = None

    def take(self, record: Record) -> None:
        """Take the next record in."""
        self.time_ns = record.get("t", self.time_ns)
        self.nodes.update(record.get("nodes", {}))
        self.generators.update(record.get("random", {}))
        self.requirements.update(record.get("requirements", {}))
        for path, values in record.get("values", {}).items():
            self.values.setdefault(path, {}).update(values)
        for path, names in record.get("gone", {}).items():
            for name in names:
                self.values.get(path, {}).pop(name, None)
        for goal in record.get("sent", ()):
            self.goals[goal["id"]] = goal
        for goal_id in record.get("ended", ()):
            self.goals.pop(goal_id, None)
        self.end = record.get("end", self.end)

    def in_short(self) -> list[Record]:
        """The fewest records that tell the same story."""
        return [
            self.head,
            {
                "t": self.time_ns,
                "nodes": self.nodes,
                "values": self.values,
                "random": self.generators,
                "sent": list(self.goals.values()),
                "requirements": self.requirements,
            },
        ]


def head_of(mission: Mission, namespace: str) -> Record:
    """The first record of a mission's journal."""
    digest = hashlib.sha256()
    documents = dict.fromkeys(tree.document.lines for tree in mission.all_trees)
    for lines in documents:
        digest.update("\n".join(lines).encode() + b"\0")
    return {
        "format": FORMAT,
        "mission": mission.name,
        "sources": digest.hexdigest(),
        "inputs": dict(mission.inputs),
        "seed": mission.seed,
        "namespace": namespace,
    }


def told(records: list[Record], head: Mapping[str, Any], path: object) -> JournalState:
    """The story of these records, for a mission that goes on with it.

    Args:
        head: Of the mission that is to go on.

    Raises:
        BtMissionError: When it is another mission's, or has come to its end.
    """
    story = JournalState(records[0])
    for record in records[1:]:
        story.take(record)
    theirs = story.head
    if theirs["mission"] != head["mission"]:
        raise BtMissionError(f"{path}: the journal of another mission, '{theirs['mission']}'")
    if theirs["sources"] != head["sources"]:
        raise BtMissionError(f"{path}: the mission file has changed since this journal was begun")
    for key, option in (("inputs", "--set"), ("seed", "--seed"), ("namespace", "--namespace")):
        if theirs[key] != head[key]:
            raise BtMissionError(
                f"{path}: the journal of a run with other {key}: {theirs[key]!r}, not "
                f"{head[key]!r} ({option})"
            )
    if story.end is not None:
        status, reason = story.end["status"], story.end["reason"]
        why = f": {reason}" if reason else ""
        raise BtMissionError(f"{path}: this mission has ended: {status}{why}; start it anew")
    return story
