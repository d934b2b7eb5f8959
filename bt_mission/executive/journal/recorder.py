"""Writes down, after each tick that changes anything, where a mission stands."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.cleanup import Finally
from bt_mission.behaviours.decorators import Subtree
from bt_mission.behaviours.runtime import Runtime, Scope
from bt_mission.behaviours.snapshot import save
from bt_mission.core.errors import BtMissionError
from bt_mission.core.stamps import NS
from bt_mission.executive.executive import Executive
from bt_mission.executive.journal.file import JournalFile
from bt_mission.executive.journal.state import JournalState, Record
from bt_mission.executive.journal.values import Pack, encode, pack_generator
from bt_mission.executive.status import Change, MissionStatus
from bt_mission.goals.goal import Goal
from bt_mission.requirements.monitor import RequirementResult
from bt_mission.requirements.resumption import written

HEARTBEAT_NS = NS
"""The journal shows at least this often that the mission's time goes on."""


class JournalRecorder:
    """Follows an executive. A goal stands in the journal before it is sent.

    Args:
        file: Where to write.
        story: What stands there already, if only its head.
        executive: Whom to follow; a journal that cannot be written ends its mission.
        runtime: Its clock and variables.
        pack: A message as JSON, None for what is no message.
        requirements: Returns what the mission's requirements have come to.
    """

    def __init__(
        self,
        file: JournalFile,
        story: JournalState,
        executive: Executive,
        runtime: Runtime,
        pack: Pack,
        requirements: Callable[[], Iterable[RequirementResult]] = tuple,
    ) -> None:
        self._file = file
        self._story = story
        self._executive = executive
        self._runtime = runtime
        self._pack = pack
        self._requirements = requirements
        self._dirty: dict[Behaviour, None] = {}
        self._scopes = _scopes(executive, runtime.scope)
        self._known: dict[str, dict[str, Any]] = {path: {} for path in self._scopes}
        self._is_broken = False
        self._has_ended = False
        executive.listeners.append(self._on_change)
        executive.goal_listeners.append(self._on_goal)
        executive.after_tick.append(self._after_tick)

    # ---- what happens ----------------------------------------------------------------------

    def _on_change(self, change: Change) -> None:
        node: Behaviour | None = change.node
        while node is not None and node not in self._dirty:
            self._dirty[node] = None
            node = node.parent

    def _on_goal(self, what: str, goal: Goal) -> None:
        if what == "sent":
            # Its leaf remembers it from this tick on.
            self._dirty |= dict.fromkeys(self._executive.running_leaves)
            name, kind = goal.goal_client.name, goal.goal_client.type_name
            sent = {"id": goal.id.hex(), "action": name, "type": kind, "owner": goal.owner}
            self._write({"t": self._runtime.now_ns, "sent": [sent]})

    def _after_tick(self) -> None:
        now_ns = self._runtime.now_ns
        if not self._executive.started_ns:
            return  # what it is to go on from stands here already
        if self._executive.is_resumable:
            return  # it can go on from before the tick that ended it
        if self._executive.is_done or self._executive.status is MissionStatus.OBSERVING:
            if not self._has_ended:
                end = {"status": str(self._executive.verdict), "reason": self._executive.reason}
                self._write({"t": now_ns, "end": end})
            self._has_ended = True
            return
        judged, has_news = self._judged()
        if self._dirty or self._ended_goals():
            self._write(self._changes(now_ns) | judged)
        elif has_news or now_ns - self._story.time_ns >= HEARTBEAT_NS:
            self._write({"t": now_ns} | judged)

    def _judged(self) -> tuple[Record, bool]:
        """Return the requirements that have changed, and whether one has another verdict."""
        known = self._story.requirements
        new = {
            name: one
            for name, one in written(self._requirements()).items()
            if known.get(name) != one
        }
        has_news = any(
            one["verdict"] != known.get(name, one)["verdict"] for name, one in new.items()
        )
        return {"requirements": new} if new else {}, has_news

    # ---- records ---------------------------------------------------------------------------

    def _changes(self, now_ns: int) -> Record:
        record: Record = {"t": now_ns, "nodes": {}, "ended": self._ended_goals()}
        for node in self._dirty:
            is_detached = isinstance(node, Finally) and node.is_detached
            lasts = node.status is Status.RUNNING or is_detached
            state = save(node, now_ns) if lasts else {}
            for name in ("elements", "values"):
                if name in state:
                    state[name] = encode(state[name], self._pack)
            record["nodes"][self._executive.path_of(node)] = [node.status.value, state, now_ns]
        self._dirty = {}
        for path, scope in self._scopes.items():
            known, values = self._known[path], scope.written()
            new = {
                name: value
                for name, value in values.items()
                if name not in known or known[name] is not value
            }
            gone = [name for name in known if name not in values]
            if new:
                encoded = {name: encode(value, self._pack) for name, value in new.items()}
                record.setdefault("values", {})[path] = encoded
            if gone:
                record.setdefault("gone", {})[path] = gone
            if new or gone:
                self._known[path] = values
        for name, generator in self._runtime.scope.generators.items():
            if generator.was_drawn:
                generator.was_drawn = False
                record.setdefault("random", {})[name] = pack_generator(generator)
        return record

    def _ended_goals(self) -> list[str]:
        open_goals = self._runtime.ledger.open_goals
        if len(open_goals) == len(self._story.goals):  # every open goal is in the story
            return []
        still = {goal.id.hex() for goal in open_goals}
        return [goal_id for goal_id in self._story.goals if goal_id not in still]

    def _write(self, record: Record) -> None:
        if self._is_broken:
            return
        self._story.take(record)
        try:
            self._file.append(record)
            if self._file.is_long:
                self._file.rewrite(self._story.in_short())
        except BtMissionError as error:
            self._is_broken = True
            self._executive.fail(str(error))


def _scopes(executive: Executive, scope: Scope) -> dict[str, Scope]:
    """The variables of the mission and of each named tree in it, by the path of the tree."""
    inner = {
        executive.path_of(node): node.inner for node in executive.nodes if isinstance(node, Subtree)
    }
    return {"": scope, **inner}
