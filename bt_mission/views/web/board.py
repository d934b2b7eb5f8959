"""The data that pages receive of a mission, each part with the revision of its last change."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Sequence
from typing import Any, Generic, TypeVar

from py_trees.common import Status

from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control
from bt_mission.executive.events.events import (
    ENDED,
    Event,
    GoalChanged,
    NodeChanged,
    NodeProgressed,
    NodesReset,
    RunStarted,
    StateChanged,
)
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.messages import Map
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.watched_mission import targets
from bt_mission.views.web import encoding

SERIES_VALUES = 2_000
"""Values of a variable that are kept against time; beyond it every second one is dropped."""

MOST_CHANGES = 20_000
"""Changes of nodes that are kept for pages that open late; beyond it, the last of each node."""

LOG_LINES = 500
"""Lines that a page receives when it opens."""

Key = TypeVar("Key", bound=Hashable)

Series = list[tuple[float, float]]
"""Values of a variable with their times, s since the mission's start."""


class _Revised(Generic[Key]):
    """Values by key, the last changed ones last.

    A slow page misses values in between and never the newest; nothing is queued for it.
    """

    def __init__(self) -> None:
        self._kept: dict[Key, tuple[int, Any]] = {}

    def put(self, key: Key, value: Any, revision: int) -> bool:
        """Keep a value. Return whether it differs from the one before."""
        before = self._kept.get(key)
        if before is not None and before[1] == value:
            return False
        self._kept.pop(key, None)
        self._kept[key] = (revision, value)
        return True

    def since(self, revision: int) -> dict[Key, Any]:
        """Return what has changed after a revision, in the order of the changes."""
        changes: list[tuple[Key, Any]] = []
        for key in reversed(self._kept):
            changed, value = self._kept[key]
            if changed <= revision:
                break
            changes.append((key, value))
        return dict(reversed(changes))

    def drop(self, key: Key) -> None:
        """Remove a value; pages that have it keep it."""
        self._kept.pop(key, None)

    def clear(self) -> None:
        """Forget all of them."""
        self._kept.clear()


class _LogLines:
    """The newest lines. A log that has lost its newest lines, as in a replay, is sent again."""

    def __init__(self) -> None:
        self._lines: list[tuple[int, list[Any]]] = []
        """Each line with the revision at which it was added."""
        self._last: LogEntry | None = None
        self._reset_revision = 0

    def show(self, log: Sequence[LogEntry], start_ns: int, revision: int) -> bool:
        """Replace the log. Return whether it differs from the one before."""
        if (log[-1] if log else None) == self._last:
            return False
        new: list[LogEntry] = []
        for entry in reversed(log):
            if entry == self._last or len(new) == LOG_LINES:
                break
            new.append(entry)
        else:
            self._lines.clear()
            self._reset_revision = revision
        self._lines += [(revision, encoding.log_entry(added, start_ns)) for added in reversed(new)]
        del self._lines[:-LOG_LINES]
        self._last = log[-1] if log else None
        return True

    def since(self, revision: int) -> dict[str, Any]:
        """Return the lines added after a revision, and whether they replace the earlier ones."""
        lines: list[list[Any]] = []
        for came, line in reversed(self._lines):
            if came <= revision:
                break
            lines.append(line)
        is_new = self._reset_revision > revision
        if not lines and not is_new:
            return {}
        return {"log": lines[::-1], **({"log_is_new": True} if is_new else {})}


class Board:
    """The data for pages. Fill it with ``show``; a page gets the changes :meth:`since` a revision.

    The revision grows with every change and is never reset, so a page that has lost its connection
    begins at 0 and is then as complete as any other.
    """

    def __init__(self) -> None:
        self.revision = 1
        self._parts: _Revised[str] = _Revised()
        self._nodes: _Revised[int] = _Revised()
        self._goals: _Revised[str] = _Revised()
        self._variables: _Revised[str] = _Revised()
        self._requirements: _Revised[str] = _Revised()
        self._robot: _Revised[str] = _Revised()
        self._log = _LogLines()
        self._changes: list[list[Any]] = []
        self._changes_begin: float | None = None
        self._tree: RunStarted | None = None
        self._sent_tree: dict[str, Any] | None = None
        self._tree_revision = self._values_revision = 1
        self._seen_goals: dict[str, GoalChanged] = {}
        self._seen_variables: dict[str, str] = {}
        self._map: Map | None = None
        self._series: dict[str, Series] = {}

    # ---- what is shown --------------------------------------------------------------------

    def put(self, name: str, value: Any) -> None:
        """Replace a part that is sent as a whole: anything that JSON can hold."""
        self._advance(self._parts.put(name, encoding.shown(value), self._next))

    def show(self, mission: MissionState, touched: Iterable[int] | None) -> None:
        """Replace the mission's state.

        Args:
            touched: Indices of the nodes that may have changed; None if all may have.
        """
        if mission.tree is not self._tree:
            self._begin(mission.tree)
            touched = None
        at, count, has_changed = self._next, len(mission.statuses), False
        for index in range(count) if touched is None else touched:
            if index < count:
                has_changed |= self._nodes.put(index, encoding.node(mission, index), at)
        self._advance(has_changed)
        self._show_values(mission)
        start_ns = mission.tree.time_ns if mission.tree else 0
        self._advance(self._log.show(mission.log, start_ns, self._next))

    def remember(self, mission: MissionState, happened: Iterable[Event]) -> None:
        """Keep the changes of nodes among these events, for pages that open later.

        Args:
            mission: The mission after these events, which :meth:`show` has shown.
        """
        if (tree := mission.tree) is None:
            return
        for event in happened:
            match event:
                case NodeChanged(time_ns, node, status, message):
                    if self._changes_begin is None:
                        # Without a time it is the present: earlier statuses are not known.
                        is_whole = time_ns is not None
                        since_ns = tree.time_ns if is_whole else mission.now_ns
                        self._changes_begin = (since_ns - tree.time_ns) / NS
                    at_ns = mission.now_ns if time_ns is None else time_ns
                    self._add_change(tree, at_ns, node, status, message)
                case NodesReset(time_ns, nodes):
                    for node in nodes:
                        self._add_change(tree, time_ns, node, Status.INVALID, "")
        if len(self._changes) > MOST_CHANGES:
            self._forget_changes()

    def show_robot(
        self, mission: MissionState, parts: Iterable[str] = tuple(encoding.ROBOT_PARTS)
    ) -> None:
        """Show where the robot is sent, its map, and other parts, for pages with an open map.

        Args:
            parts: Names in :data:`encoding.ROBOT_PARTS` of what may have changed.
        """
        at, robot = self._next, mission.robot
        has_changed = self._robot.put("targets", encoding.shown(targets(mission)), at)
        for name in parts:
            has_changed |= self._robot.put(name, encoding.ROBOT_PARTS[name](robot), at)
        if robot.map is not self._map:
            self._map = robot.map
            has_changed |= self._robot.put("grid", encoding.grid(robot.map), at)
        self._advance(has_changed)

    def series(self, name: str) -> Series:
        """The values that a variable has had."""
        return self._series.get(name, [])

    # ---- data for a page ------------------------------------------------------------------

    def since(self, revision: int) -> dict[str, Any]:
        """Return what has changed after a revision; empty without a change."""
        changes: dict[str, Any] = self._parts.since(revision) | self._log.since(revision)
        if self._tree_revision > revision:
            changes["tree"] = self._sent_tree
            changes["past"] = {"begin": self._changes_begin, "changes": self._changes}
        if self._values_revision > revision:
            changes["values_are_new"] = True
        if nodes := self._nodes.since(revision):
            changes["nodes"] = list(nodes.values())
        if goals := self._goals.since(revision):
            changes["goals"] = list(goals.values())
        if variables := self._variables.since(revision):
            changes["variables"] = list(variables.items())
        if requirements := self._requirements.since(revision):
            changes["requirements"] = list(requirements.values())
        return changes

    def robot_since(self, revision: int) -> dict[str, Any]:
        """As :meth:`since`, for the robot and its map."""
        return self._robot.since(revision)

    # ---- inside ---------------------------------------------------------------------------

    @property
    def _next(self) -> int:
        return self.revision + 1

    def _advance(self, has_changed: bool) -> None:  # noqa: FBT001 - what a method has answered
        self.revision += has_changed

    def _begin(self, tree: RunStarted | None) -> None:
        self._tree, self._tree_revision = tree, self._next
        self._sent_tree = None if tree is None else encoding.tree(tree)
        self._nodes.clear()
        self._changes, self._changes_begin = [], None
        self._series.clear()
        self._forget_values()
        self.revision += 1

    def _add_change(
        self, tree: RunStarted, time_ns: int, node: int, status: Status, message: str
    ) -> None:
        time_s = (time_ns - tree.time_ns) / NS
        code = encoding.STATUS_CODES[status]
        self._changes.append([time_s, node, code, escape_control(message)])

    def _forget_changes(self) -> None:
        """Merge the older half of the changes into one for each node, at the time of the last."""
        old, kept = self._changes[: MOST_CHANGES // 2], self._changes[MOST_CHANGES // 2 :]
        self._changes_begin = begin = old[-1][0]
        last = {index: [begin, index, status, message] for _, index, status, message in old}
        self._changes = [*last.values(), *kept]

    def _forget_values(self) -> None:
        self._values_revision = self._next
        for kept in (self._goals, self._variables, self._requirements):
            kept.clear()
        self._seen_goals, self._seen_variables = {}, {}

    def _show_values(self, mission: MissionState) -> None:
        for goal_id in self._seen_goals.keys() - mission.goals.keys():  # a state keeps the newest
            del self._seen_goals[goal_id]
            self._goals.drop(escape_control(goal_id))
        start_ns = mission.tree.time_ns if mission.tree else 0
        has_changed, at = False, self._next
        for goal in mission.goals.values():
            if self._seen_goals.get(goal.id) is not goal:
                self._seen_goals[goal.id] = goal
                has_changed |= self._goals.put(
                    escape_control(goal.id),
                    encoding.goal(goal, mission.goals_changed_ns[goal.id], start_ns),
                    at,
                )
        for name, value in mission.variables.items():
            if self._seen_variables.get(name) != value:
                self._seen_variables[name] = value
                has_changed |= self._variables.put(escape_control(name), escape_control(value), at)
                self._sample(mission, name, value)
        for requirement in mission.requirements:
            shown = encoding.requirement(requirement)
            has_changed |= self._requirements.put(shown["name"], shown, at)
        self._advance(has_changed)

    def _sample(self, mission: MissionState, name: str, value: str) -> None:
        try:
            number = float(value)
        except ValueError:
            return
        values = self._series.setdefault(escape_control(name), [])
        time_s = mission.elapsed_ns / NS
        if not values or time_s > values[-1][0]:
            values.append((time_s, number))
        self._series[escape_control(name)] = thinned(values)


def put_state(board: Board, mission: MissionState, **more: Any) -> None:
    """Put the state of the mission, and the time, on the board."""
    state, tree, charge = mission.state, mission.tree, mission.robot.charge
    verdict, reason = mission.conclusion
    board.put(
        "state",
        {
            "mission": tree.mission if tree else state.mission if state else "",
            "status": mission.status,
            "verdict": verdict,
            "reason": reason,
            "tip": mission.focus,
            "ticks": mission.ticks,
            "goals_sent": mission.goals_sent,
            "breakpoints": mission.breakpoints,
            "charge": None if charge is None else round(charge, 1),
            **more,
        },
    )
    now_ns = mission.now_ns - tree.time_ns if tree else 0
    board.put("clock", {"now": now_ns / NS, "elapsed": mission.elapsed_ns / NS})


def touched_by(happened: Iterable[Event]) -> set[int] | None:
    """Return the nodes of events; None if that may be all of them."""
    touched: set[int] = set()
    for event in happened:
        match event:
            case NodeChanged(node=node) | NodeProgressed(node=node):
                touched.add(node)
            case NodesReset(nodes=nodes):
                touched.update(nodes)
            case RunStarted():
                return None
            case StateChanged(status=status) if status in ENDED:
                return None  # they are shown as they ended
    return touched


def thinned(values: Series) -> Series:
    """Every second value as often as is needed for no more than :data:`SERIES_VALUES`."""
    while len(values) > SERIES_VALUES:
        values = values[::2]
    return values
