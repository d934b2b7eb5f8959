"""What a mission is doing beyond the statuses of its nodes: progress, goals, variables."""

from __future__ import annotations

import json
import reprlib
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from bt_mission_interfaces.msg import GoalRecord, MissionDetails, NodeProgress, Variable
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, PoseStamped
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.decorators import Subtree
from bt_mission.behaviours.leaves import LeafProgress, progress_of
from bt_mission.behaviours.runtime import Scope
from bt_mission.core.stamps import set_ns
from bt_mission.executive.executive import Executive
from bt_mission.executive.status import Change
from bt_mission.goals.goal import Goal, GoalStatus, Phase
from bt_mission.goals.ledger import Ledger
from bt_mission.language.mission import Mission
from bt_mission.ros.requirement_watch import RequirementWatch

MOST_RUNNING = 50
"""Running nodes in one message; where more run, they take turns."""

KEPT_GOALS = 50
"""Goals that have ended and are still told of."""

VALUE_CHARACTERS = 200
"""Of a variable's value."""

_ENDS = {
    GoalStatus.SUCCEEDED: "succeeded",
    GoalStatus.CANCELED: "canceled",
    GoalStatus.ABORTED: "aborted",
    GoalStatus.UNKNOWN: "unknown",
}
_SHORTENED = reprlib.Repr()
_SHORTENED.maxother = _SHORTENED.maxstring = VALUE_CHARACTERS
_SHORTENED.maxlist = _SHORTENED.maxtuple = _SHORTENED.maxdict = 20


@dataclass(frozen=True)
class MissionRun:
    """A mission that runs, for those who describe it.

    Attributes:
        log_listeners: Called with each line of the log and its ROS time, ns.
        clock_ns: Returns the mission's time, ns.
        mission: What is carried out.
        requirements: What its requirements have come to.
    """

    executive: Executive
    ledger: Ledger
    scope: Scope
    log_listeners: list[Callable[[int, str], None]]
    clock_ns: Callable[[], int]
    mission: Mission
    requirements: RequirementWatch

    @property
    def now_ns(self) -> int:
        """The mission's time, ns."""
        return self.clock_ns()


class MissionDetailsBuilder:
    """Describes one mission, for one who listens, from now on until it is closed.

    Args:
        run: Names the run.
        indices: The nodes of the tree, each with its number.
    """

    def __init__(self, run: str, mission: MissionRun, indices: dict[Behaviour, int]) -> None:
        self._run, self._mission, self._indices = run, mission, indices
        self._subtrees = [node for node in indices if isinstance(node, Subtree)]
        self._since_ns = {node: mission.now_ns for node in indices if node.status is Status.RUNNING}
        self._goals: OrderedDict[bytes, GoalRecord] = OrderedDict()
        self._open: dict[bytes, Goal] = {}
        self._changed: dict[bytes, None] = {}
        self._values: dict[str, str] = {}
        self._turn = 0
        self._shown: dict[Behaviour, tuple[str, LeafProgress | None]] = {}
        mission.executive.listeners.append(self._on_change)
        mission.executive.goal_listeners.append(self._on_goal)

    def close(self) -> None:
        """Follow the mission no longer."""
        self._mission.executive.listeners.remove(self._on_change)
        self._mission.executive.goal_listeners.remove(self._on_goal)

    def describe(self, *, complete: bool) -> MissionDetails:
        """Say what the mission is doing.

        Args:
            complete: With all goals and variables, not only those that have changed.
        """
        running = [self._progress(node, progress_of(node)) for node in self._some_running()]
        return self._described(running, complete=complete)

    def describe_news(self) -> MissionDetails:
        """Say what has changed since the last time, of running nodes, too."""
        running = []
        for node in self._some_running():
            shown = (node.feedback_message, progress_of(node))
            if self._shown.get(node) != shown:
                self._shown[node] = shown
                running.append(self._progress(node, shown[1]))
        return self._described(running, complete=False)

    def _described(self, running: list[NodeProgress], *, complete: bool) -> MissionDetails:
        mission = self._mission
        for goal in self._open.values():
            self._look_at(goal)
        told = list(self._goals) if complete else list(self._changed)
        self._changed.clear()
        return MissionDetails(
            stamp=set_ns(Time(), mission.now_ns),
            run=self._run,
            ticks=mission.executive.ticks,
            goals_sent=mission.ledger.goals_sent,
            running=running,
            goals=[self._goals[key] for key in told],
            variables=[*self._variables(mission, complete=complete)],
            breakpoints=list(mission.executive.breakpoints.names),
        )

    def _on_change(self, change: Change) -> None:
        if change.status is Status.RUNNING:
            self._since_ns[change.node] = change.time_ns
        else:
            self._since_ns.pop(change.node, None)
            self._shown.pop(change.node, None)

    def _on_goal(self, _what: str, goal: Goal) -> None:
        if goal.id not in self._goals:
            stamp = set_ns(Time(), self._mission.now_ns)
            self._goals[goal.id] = GoalRecord(
                goal_id=goal.id.hex(),
                action=goal.goal_client.name,
                owner=goal.owner,
                sent=stamp,
                changed=stamp,
                state=_state(goal),
                targets=list(_targets(goal.request)),
            )
            self._changed[goal.id] = None
        self._look_at(goal)
        if goal.phase is Phase.ENDED:
            self._open.pop(goal.id, None)
            self._forget_old_goals()
        else:
            self._open[goal.id] = goal

    def _forget_old_goals(self) -> None:
        ended = [key for key in self._goals if key not in self._open]
        for key in ended[:-KEPT_GOALS]:
            del self._goals[key]
            self._changed.pop(key, None)

    def _look_at(self, goal: Goal) -> None:
        """Note the state of a goal, which the ledger does not tell of when a server accepts it."""
        record, state = self._goals[goal.id], _state(goal)
        if record.state != state:
            record.state, record.changed = state, set_ns(Time(), self._mission.now_ns)
            self._changed[goal.id] = None

    def _some_running(self) -> list[Behaviour]:
        nodes = list(self._since_ns)
        if len(nodes) <= MOST_RUNNING:
            return nodes
        first, self._turn = self._turn % len(nodes), self._turn + MOST_RUNNING
        return (nodes + nodes)[first : first + MOST_RUNNING]

    def _progress(self, node: Behaviour, progress: LeafProgress | None) -> NodeProgress:
        message = NodeProgress(
            node=self._indices[node],
            since=set_ns(Time(), self._since_ns[node]),
            message=node.feedback_message,
        )
        if progress is not None:
            message.label, message.value, message.limit = (
                progress.label,
                float(progress.value),
                float(progress.limit),
            )
        return message

    def _variables(self, mission: MissionRun, *, complete: bool) -> Iterator[Variable]:
        for name, value in variables_of(mission, self._subtrees).items():
            text = as_json(value)
            if complete or self._values.get(name) != text:
                self._values[name] = text
                yield Variable(name=name, value=text)


def variables_of(mission: MissionRun, subtrees: Iterable[Subtree]) -> dict[str, Any]:
    """Return the variables of a mission, and those of its subtrees with their names before them."""
    values = dict(mission.scope.values)
    for subtree in subtrees:
        values |= {f"{subtree.name}.{name}": one for name, one in subtree.inner.values.items()}
    return values


def as_json(value: Any) -> str:
    """A value as JSON, of at most :data:`VALUE_CHARACTERS`; what JSON has no word for as text."""
    is_large = isinstance(value, str | list | tuple | dict) and len(value) > VALUE_CHARACTERS
    text = _SHORTENED.repr(value) if is_large else json.dumps(value, default=_SHORTENED.repr)
    return text if len(text) <= VALUE_CHARACTERS else text[: VALUE_CHARACTERS - 3] + "..."


def _state(goal: Goal) -> str:
    if goal.phase is not Phase.ENDED:
        return str(goal.phase)
    if not goal.accepted:
        return "rejected"
    return _ENDS[GoalStatus.UNKNOWN if goal.status is None else goal.status]


def _targets(request: Any) -> Iterator[Point]:
    """The positions of all poses right in a goal's request."""
    for name in request.get_fields_and_field_types() if request is not None else ():
        value = getattr(request, name)
        for pose in value if isinstance(value, list) else (value,):
            if isinstance(pose, PoseStamped):
                yield pose.pose.position
