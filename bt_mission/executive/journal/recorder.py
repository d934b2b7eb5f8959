"""Writes the state of a mission to the journal after each tick that changes it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.errors import BtMissionError
from bt_mission.base.stamps import NS
from bt_mission.base.verdicts import RequirementResult
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.executive.behaviours.snapshot import save
from bt_mission.executive.events.events import (
    Event,
    GoalChanged,
    NodeChanged,
    NodesReset,
    TreeRevised,
)
from bt_mission.executive.executive import Executive
from bt_mission.executive.journal.store import (
    Journal,
    JournalState,
    Key,
    Pack,
    encode,
    pack_generator,
)
from bt_mission.executive.status import MissionStatus

HEARTBEAT_NS = NS
"""The journal shows at least this often that the mission's time passes."""


class JournalRecorder:
    """Writes the journal of an executive. A goal is in the journal before it is sent.

    Args:
        journal: The journal to write.
        state: The state of a resumed mission.
        executive: A journal that cannot be written ends its mission.
        runtime: Its clock and variables.
        pack: Returns a message as JSON, None for any other object.
        requirements: Returns the results of the mission's requirements.
        version: Returns the rows of the newest version of the mission.
    """

    def __init__(
        self,
        journal: Journal,
        state: JournalState | None,
        executive: Executive,
        runtime: Runtime,
        pack: Pack,
        requirements: Callable[[], Iterable[RequirementResult]] = tuple,
        version: Callable[[], dict[Key, Any]] = dict,
    ) -> None:
        self._journal = journal
        self._executive = executive
        self._runtime = runtime
        self._pack = pack
        self._requirements = requirements
        self._version = version
        self._heartbeat_ns = 0
        self._goals = dict.fromkeys(state.goals) if state else {}
        self._results = dict(state.requirements) if state else {}
        self._changed: dict[Behaviour, None] = {}
        self._paths: tuple[str, ...] = ()
        self._variables: dict[str, dict[str, Any]] = {}
        self._take_tree()
        self._generators: dict[str, None] = dict.fromkeys(state.generators) if state else {}
        self._is_broken = False
        self._has_ended = False
        executive.events.subscribe(self._take)
        executive.after_tick.append(self._after_tick)

    def _take_tree(self) -> None:
        executive = self._executive
        # The variables of the mission and of each named tree in it, by the path of the tree.
        self._scopes = {"": self._runtime.scope} | {
            executive.path_of(node): node.inner
            for node in executive.nodes
            if isinstance(node, Subtree)
        }
        self._paths = tuple(map(executive.path_of, executive.nodes))

    def _revise(self) -> None:
        """Write the state of the new tree in one transaction with the version of the mission."""
        gone: list[Key] = [("nodes", path) for path in self._paths]
        gone += [
            ("variables", f"{path}/{name}")
            for path, values in self._variables.items()
            for name in values
        ]
        gone += [("generators", name) for name in self._generators]
        self._take_tree()
        self._variables = {}
        for generator in self._runtime.scope.generators.values():
            generator.was_drawn = True
        self._changed = dict.fromkeys(self._executive.nodes)
        rows = self._version() | self._changed_nodes() | self._changed_variables([]) | self._drawn()
        self._write(rows, [key for key in gone if key not in rows])

    def _take(self, event: Event) -> None:
        match event:
            case TreeRevised():
                if self._executive.started_ns:
                    self._revise()
            case NodeChanged(node=index):
                self._note(index)
            case NodesReset(nodes=indices):
                for index in indices:
                    self._note(index)
            case GoalChanged(change="sent", id=goal_id):
                # From this tick on its leaf remembers it.
                self._changed |= dict.fromkeys(self._executive.running_leaves)
                self._goals[goal_id] = None
                kind = self._runtime.ledger.find(goal_id).goal_client.type_name
                sent = {"action": event.action, "type": kind, "owner": event.owner}
                self._write({("goals", goal_id): sent})

    def _note(self, index: int) -> None:
        node: Behaviour | None = self._executive.nodes[index]
        while node is not None and node not in self._changed:
            self._changed[node] = None
            node = node.parent

    def _after_tick(self) -> None:
        if not self._executive.started_ns:
            return  # the journal has what the mission resumes from
        if self._executive.is_resumable:
            return  # it can resume from before the tick that ended it
        if self._executive.status.is_final or self._executive.status is MissionStatus.OBSERVING:
            if not self._has_ended:
                end = {"status": str(self._executive.verdict), "reason": self._executive.reason}
                self._write({("about", "end"): end})
            self._has_ended = True
            return
        rows: dict[Key, Any] = {}
        gone: list[Key] = []
        self._take_results(rows)
        ended = self._ended_goals()
        if self._changed or ended:
            rows |= self._changed_nodes() | self._changed_variables(gone) | self._drawn()
            gone += [("goals", goal_id) for goal_id in ended]
        if rows or gone:
            self._write(rows, gone)

    def _take_results(self, rows: dict[Key, Any]) -> None:
        """Add new verdicts of requirements and premises that came true at once, margins later."""
        now_ns = self._runtime.now_ns
        results = {requirement.name: requirement for requirement in self._requirements()}
        is_late = now_ns - self._heartbeat_ns >= HEARTBEAT_NS
        pairs = [(result, self._results.get(name, result)) for name, result in results.items()]
        if is_late or any(
            (result.verdict, result.unmet) != (before.verdict, before.unmet)
            for result, before in pairs
        ):
            self._heartbeat_ns = now_ns
            rows["about", "time_ns"] = now_ns
            for name, result in results.items():
                if result != self._results.get(name):
                    rows["requirements", name] = vars(result)
            self._results = results

    def _changed_nodes(self) -> dict[Key, Any]:
        now_ns = self._runtime.now_ns
        rows: dict[Key, Any] = {}
        for node in self._changed:
            is_detached = isinstance(node, Finally) and node.is_detached
            lasts = node.status is Status.RUNNING or is_detached
            memory = save(node, now_ns) if lasts else {}
            for name in ("elements", "values"):
                if name in memory:
                    memory[name] = encode(memory[name], self._pack)
            row = {"status": node.status.value, "memory": memory, "saved_ns": now_ns}
            rows["nodes", self._executive.path_of(node)] = row
        self._changed = {}
        return rows

    def _changed_variables(self, gone: list[Key]) -> dict[Key, Any]:
        rows: dict[Key, Any] = {}
        for path, scope in self._scopes.items():
            known, values = self._variables.get(path, {}), scope.written()
            for name, value in values.items():
                if name not in known or known[name] is not value:
                    rows["variables", f"{path}/{name}"] = encode(value, self._pack)
            gone += [("variables", f"{path}/{name}") for name in known if name not in values]
            self._variables[path] = values
        return rows

    def _drawn(self) -> dict[Key, Any]:
        rows: dict[Key, Any] = {}
        for name, generator in self._runtime.scope.generators.items():
            if generator.was_drawn:
                generator.was_drawn = False
                self._generators[name] = None
                rows["generators", name] = pack_generator(generator)
        return rows

    def _ended_goals(self) -> list[str]:
        open_goals = self._runtime.ledger.open_goals
        if len(open_goals) == len(self._goals):  # the journal has every open goal
            return []
        still = {goal.id.hex() for goal in open_goals}
        ended = [goal_id for goal_id in self._goals if goal_id not in still]
        for goal_id in ended:
            del self._goals[goal_id]
        return ended

    def _write(self, rows: dict[Key, Any], gone: Iterable[Key] = ()) -> None:
        if self._is_broken:
            return
        try:
            self._journal.write({("about", "time_ns"): self._runtime.now_ns} | rows, gone)
        except BtMissionError as error:
            self._is_broken = True
            self._executive.fail(str(error))
