"""Snapshots of a tree of py_trees_ros as what an executive of ours would tell.

Looks only at attributes, so whatever has the fields will do. What peers send may be broken: parents
that are not there, circles, ids twice. Then what hangs together with the root is shown.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from py_trees.common import Status

from bt_mission.core.stamps import to_ns as time_ns
from bt_mission.events import events
from bt_mission.events import messages as told

STATUSES = {1: Status.INVALID, 2: Status.RUNNING, 3: Status.SUCCESS, 4: Status.FAILURE}
"""By the values of ``py_trees_ros_interfaces/msg/Behaviour``."""

STATES = {
    Status.INVALID: "idle",
    Status.RUNNING: "running",
    Status.SUCCESS: "success",
    Status.FAILURE: "failure",
}
"""Of the mission, by the root's status."""

UNREADABLE = "unreadable"
"""The mission's state while there is no tree to show."""

MOST_NODES = 5_000
"""Of a tree; the path of each is kept, and they may all lie below one another."""

VALUE_CHARACTERS = 200
"""Of a variable's value."""


class SnapshotReader:
    """Reads one snapshot after another of one tree.

    A tree that was changed counts as a new run. Times count from the first snapshot.
    """

    def __init__(self) -> None:
        self._shape: object = None
        self._runs = 0
        self._run = ""
        self._mission = ""
        self._sequence = 0
        self._known: list[told.NodeStatus] = []
        self._since_ns: list[int] = []
        self._state: tuple[str, str] | None = None

    def take(self, snapshot: Any) -> list[told.Told]:
        """Return what a ``BehaviourTree`` tells beyond those before it."""
        at_ns = time_ns(snapshot.statistics.stamp)
        nodes, fault = _arranged(snapshot.behaviours)
        if not nodes:
            self._run, self._shape = "", None
            return [*self._changed_state(at_ns, UNREADABLE, fault)]
        news = [*self._changed_tree(at_ns, nodes)]
        details = told.DetailsUpdate(
            at_ns,
            self._run,
            snapshot.statistics.count,
            None,
            tuple(self._progress(nodes)),
            (),
            tuple(
                (one.key, one.value[:VALUE_CHARACTERS])
                for one in snapshot.blackboard_on_visited_path
            ),
            (),
        )
        news += self._changed_statuses(at_ns, nodes)
        news.append(details)
        root = _status(nodes[0][0])
        return [*news, *self._changed_state(at_ns, STATES[root], fault)]

    def refused(self, why: str) -> list[told.Told]:
        """Return that there is no stream, where that is news."""
        return [*self._changed_state(0, UNREADABLE, why)]

    def statuses(self) -> list[told.Told]:
        """Return the statuses that are known."""
        known = tuple(self._known)
        return [told.Statuses(self._run, self._sequence, known)] if self._run else []

    def _changed_tree(self, at_ns: int, nodes: Sequence[_Node]) -> Iterator[told.Told]:
        shape = [
            (bytes(one.own_id.uuid), one.name, one.class_name, parent) for one, parent in nodes
        ]
        if shape == self._shape:
            return
        self._shape, self._sequence, self._runs = shape, 0, self._runs + 1
        self._state = None
        self._run, self._mission = f"{shape[0][0].hex()}-{self._runs}", nodes[0][0].name
        self._known = [_standing(index, one) for index, (one, _) in enumerate(nodes)]
        self._since_ns = [at_ns] * len(nodes)
        yield events.MissionStarted(at_ns, self._run, self._mission, tuple(_infos(nodes)))
        yield from self.statuses()

    def _changed_statuses(self, at_ns: int, nodes: Sequence[_Node]) -> Iterator[told.Told]:
        """Tell of changes; what a node that runs on says is progress, and no change."""
        changes = []
        for index, (one, _) in enumerate(nodes):
            now, before = _standing(index, one), self._known[index]
            if now == before:
                continue
            self._known[index] = now
            if now.status is not before.status:
                self._since_ns[index] = at_ns
            if now.status is not before.status or now.status is not Status.RUNNING:
                changes.append(now)
        if changes:
            self._sequence += 1
            yield told.Changes(at_ns, self._run, self._sequence, tuple(changes))

    def _progress(self, nodes: Sequence[_Node]) -> Iterator[events.NodeProgress]:
        """Tell what the nodes say that ran before, and still do."""
        for index, (one, _) in enumerate(nodes):
            known = self._known[index]
            if known.status is Status.RUNNING and _status(one) is Status.RUNNING:
                since_ns = self._since_ns[index]
                yield events.NodeProgress(index, since_ns, one.message, "", 0.0, 0.0)

    def _changed_state(self, at_ns: int, status: str, reason: str) -> Iterator[told.Told]:
        if self._state != (status, reason):
            self._state = (status, reason)
            yield events.MissionStateChanged(at_ns, self._run, self._mission, status, reason)


_Node = tuple[Any, int]
"""A ``Behaviour`` and its parent's index."""


def _arranged(behaviours: Sequence[Any]) -> tuple[list[_Node], str]:
    """Return the nodes depth first, the root first, and what is wrong with them."""
    by_id: dict[bytes, Any] = {}
    for one in behaviours:
        by_id.setdefault(bytes(one.own_id.uuid), one)
    parents = {key: bytes(one.parent_id.uuid) for key, one in by_id.items()}
    roots = [key for key, parent in parents.items() if not any(parent)]
    roots = roots or [key for key, parent in parents.items() if parent not in by_id]
    if not roots:
        what = "every node has a parent" if behaviours else "it is empty"
        return [], f"its snapshot has no root: {what}"
    found: list[_Node] = []
    waiting, seen = [(roots[-1], 0)], {roots[-1]}
    while waiting and len(found) < MOST_NODES:
        key, parent = waiting.pop()
        index = len(found)
        found.append((by_id[key], parent))
        named = dict.fromkeys(bytes(child.uuid) for child in by_id[key].child_ids)
        below = [child for child in named if child in by_id and child not in seen]
        seen.update(below)
        waiting += [(child, index) for child in reversed(below)]
    count, lost = len(behaviours), len(behaviours) - len(found)
    if waiting:
        return found, f"only the first {len(found):,} of its {count:,} nodes are shown"
    return found, f"{lost:,} of its {count:,} nodes are not connected to the root" if lost else ""


def _infos(nodes: Sequence[_Node]) -> Iterator[events.NodeInfo]:
    paths: list[str] = []
    counts = [0] * len(nodes)
    for index, (one, parent) in enumerate(nodes):
        path = f"{paths[parent]}.{counts[parent]}" if index else "0"
        counts[parent] += bool(index)
        paths.append(path)
        yield events.NodeInfo(one.name, one.class_name.rpartition(".")[2], path, parent)


def _standing(index: int, one: Any) -> told.NodeStatus:
    return told.NodeStatus(index, _status(one), one.message)


def _status(one: Any) -> Status:
    """Return the status of a node; a code that a newer peer may have counts as none."""
    return STATUSES.get(one.status, Status.INVALID)
