"""The signals of a recorded mission at an instant: a fold over its state."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

from py_trees.common import Status

from bt_mission.base.actions import GOALS_AT, goals_at
from bt_mission.base.diagnostics import quoted
from bt_mission.executive.behaviours.action_leaf import HALTED, ActionLeaf
from bt_mission.executive.events.events import (
    FINAL,
    Event,
    GoalChanged,
    NodeChanged,
    NodeInfo,
    PoseSampled,
    RunStarted,
    StateChanged,
    TreeRevised,
    VariableChanged,
)
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.language.expressions.values import Plain
from bt_mission.language.outcome import Outcome
from bt_mission.recording.recorded_messages import (
    TRACE,
    ExecutiveMessage,
    GoalMessage,
    MissionMessage,
    RecordedMessage,
    TraceLine,
)
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.signals import STATUSES, NodeOutcomes, field_of

FEEDBACK = "feedback"


class RecordedMission:
    """The state of a mission at each instant, from the messages of its executive.

    Args:
        node: Full name of the executive's node.
        tree: The tree of the mission; None without one in the recording.
        topics: All topics in the recording.
        nodes: The nodes of all versions of the mission.
    """

    def __init__(
        self,
        node: str,
        tree: RunStarted | None,
        topics: Mapping[str, str],
        nodes: Iterable[NodeInfo],
    ) -> None:
        self._state = MissionState()
        if tree is not None:
            self._state.apply(tree)
        self._values: dict[str, tuple[str, Plain | None]] = {}
        """The values of variables, with their JSON."""
        self._node = node
        self._of_all_versions = tuple(nodes)
        self._indices: dict[str, int] = {}
        self._has_trace = f"{node}/{TRACE}" in topics and bool(self._nodes)
        self._topics = topics
        self._numbers: dict[str, list[int]] = {}
        """The indices of the nodes with a name or path."""
        self._seen: defaultdict[int, set[Status]] = defaultdict(set)
        """Statuses that nodes have had since the last instant."""
        self._collisions: int | None = None
        self._sent: dict[str, str] = {}
        """Goals that no leaf has yet, by the names of their leaves."""
        self._goals: dict[int, str] = {}
        """The present goals of leaves."""
        self._outcomes = NodeOutcomes()
        self._ended_accepted: set[str] = set()
        """Goals that have ended with a result, so that they had been accepted."""
        self._feedback: dict[str, Any] = {}
        self._wants_feedback = self._wants_poses = False
        self._number_nodes()

    @property
    def ending(self) -> str:
        """The final status of the mission, of :data:`FINAL`; empty before its end."""
        return self._state.status if self._state.status in FINAL else ""

    @property
    def _nodes(self) -> tuple[NodeInfo, ...]:
        return () if self._state.tree is None else self._state.tree.nodes

    def reader(self, signal: SignalValue) -> Reader | str:
        """Return what gives a signal's present value, or why it is not known here."""
        if not self._nodes:
            return "the recording contains no mission"
        name, arguments = signal.name, signal.arguments
        if name == "$":
            return lambda: self._variable(arguments[0])
        if name in STATUSES:
            return self._node_status(STATUSES[name], arguments[0])
        if not self._has_trace:
            return "the recording has no trace of the mission"
        makers: Mapping[str, Callable[..., Reader | str]] = {
            "open_goals": lambda: lambda: len(self._open_goals()),
            **{each: partial(partial, self._goals_at, part) for each, part in GOALS_AT.items()},
            "collisions": self._count_collisions,
            "outcome": self._outcome,
            "feedback": self._feedback_of,
        }
        return makers[name](*arguments)

    def _goals_at(self, part: str) -> int:
        return goals_at(part, self._open_goals())

    def _open_goals(self) -> list[str]:
        """Return the actions of the goals that have not ended."""
        return [goal.action for goal in self._state.goals.values() if not goal.is_ended]

    def _variable(self, name: str) -> Plain | None:
        text = self._state.variables.get(name)
        if text is None:
            return None
        if name not in self._values or self._values[name][0] != text:
            self._values[name] = text, _value(text)
        return self._values[name][1]

    def wants(self, happening: RecordedMessage) -> bool:
        """Return whether a message is needed."""
        if isinstance(happening, GoalMessage):
            return bool(self._nodes) and happening.part == FEEDBACK
        return isinstance(happening, MissionMessage) and happening.node == self._node

    def take(self, happening: RecordedMessage) -> None:
        """Handle a message, if it is needed.

        Statuses and the end of the mission come from its trace, whose lines are between the control
        steps in which they happened; without a trace, from its topics.
        """
        match happening:
            case GoalMessage(part="feedback") if self._wants_feedback:
                message = happening.message
                self._feedback[bytes(message.goal_id.uuid).hex()] = message.feedback
            case TraceLine(node=self._node) if self._has_trace:
                is_of_use = self._wants_poses or not happening.is_pose
                if is_of_use and (event := happening.event(self._indices)) is not None:
                    self._take(event)
            case ExecutiveMessage(node=self._node):
                for event in happening.batch.events:
                    if isinstance(event, VariableChanged) or not self._has_trace:
                        self._take(event)

    def forget(self) -> None:
        """Forget the statuses of an instant; called after each instant."""
        self._seen.clear()
        self._outcomes.forget()

    def _take(self, event: Event) -> None:
        match event:
            case PoseSampled():
                self._collisions = event.collisions
            case NodeChanged() | TreeRevised() | GoalChanged() | StateChanged() | VariableChanged():
                self._state.apply(event)  # resets are left out: a node counts as it ended
        match event:
            case NodeChanged():
                self._note(event)
            case TreeRevised():
                self._revise(event)
            case GoalChanged(id=goal, change="sent"):
                self._sent[event.owner] = goal
            case GoalChanged(id=goal, change="ended", state=state) if state != "rejected":
                self._ended_accepted.add(goal)

    def _revise(self, event: TreeRevised) -> None:
        """Continue with the tree of a revision."""
        self._outcomes.move({index: new for new, index in enumerate(event.kept) if index >= 0})
        self._goals = {
            new: self._goals[index] for new, index in enumerate(event.kept) if index in self._goals
        }
        self._seen.clear()
        self._number_nodes()

    def _number_nodes(self) -> None:
        self._indices = {node.path: index for index, node in enumerate(self._nodes)}
        for name, indices in self._numbers.items():
            indices[:] = self._numbered(name)

    def _note(self, event: NodeChanged) -> None:
        index, status = event.node, event.status
        self._outcomes.note(index, status, _outcome_in(event.message, status))
        self._seen[index].add(status)
        if status is Status.RUNNING:
            self._goals[index] = self._sent.pop(self._nodes[index].name, "")

    # ---- readers ---------------------------------------------------------------------------

    def _named(self, name: str) -> list[int]:
        """Return the nodes with a name or path; the list changes with a revision."""
        return self._numbers.setdefault(name, self._numbered(name))

    def _numbered(self, name: str) -> list[int]:
        return [at for at, node in enumerate(self._nodes) if name in (node.name, node.path)]

    def _node_status(self, status: Status, node: str) -> Reader | str:
        nodes, state, seen = self._named(node), self._state, self._seen
        if not self._known(node):
            return f"the recorded mission has no node {quoted(node)}"
        return lambda: any(
            state.statuses[index] is status or status in seen.get(index, ()) for index in nodes
        )

    def _count_collisions(self) -> Reader:
        self._wants_poses = True
        return lambda: self._collisions

    def _outcome(self, node: str, outcome: str) -> Reader | str:
        if not self._has_goal(node):
            return _no_goal(node)
        return lambda: self._outcomes.is_any(self._leaves(node), outcome)

    def _feedback_of(self, node: str, field: str) -> Reader | str:
        if not self._has_goal(node):
            return _no_goal(node)
        if not any(topic.endswith(f"/_action/{FEEDBACK}") for topic in self._topics):
            return "the recording has no feedback"
        self._wants_feedback = True
        return self._newest(node, field)

    def accepted(self, node: str, known: Callable[[], Any]) -> Reader | str:
        """Return a reader of whether the newest goal of a node was accepted.

        Args:
            known: Returns the accepted goals under way, by their UUIDs in hexadecimal.
        """
        if not self._has_goal(node):
            return _no_goal(node)
        seen: set[str] = set()

        def is_accepted() -> bool:
            seen.update(known() or ())
            goals = [self._goal_of(leaf) for leaf in self._leaves(node)]
            return any(goal in seen or goal in self._ended_accepted for goal in goals)

        return is_accepted

    def _leaves(self, node: str) -> list[int]:
        """Return the nodes with goals that have a name or path."""
        kind = ActionLeaf.__name__
        return [index for index in self._named(node) if self._nodes[index].kind == kind]

    def _known(self, node: str) -> list[NodeInfo]:
        """Return the nodes of any version with a name or path."""
        return [known for known in self._of_all_versions if node in (known.name, known.path)]

    def _has_goal(self, node: str) -> bool:
        return any(known.kind == ActionLeaf.__name__ for known in self._known(node))

    def _goal_of(self, leaf: int) -> str:
        """Return the newest goal of a leaf; empty without one."""
        name = self._nodes[leaf].name
        if self._state.statuses[leaf] is Status.RUNNING and name in self._sent:
            self._goals[leaf] = self._sent.pop(name)  # sent while it ran already
        return self._goals.get(leaf, "")

    def _newest(self, node: str, field: str) -> Callable[[], Any]:
        def value() -> Any:
            for leaf in self._leaves(node):
                if self._state.statuses[leaf] is Status.RUNNING:
                    return field_of(self._feedback.get(self._goal_of(leaf)), field)
            return None

        return value


def _no_goal(node: str) -> str:
    return f"the recorded mission has no node {quoted(node)} with a goal"


def _outcome_in(message: str, status: Status) -> str:
    """Return the outcome of a goal, from the status of its leaf; empty without one."""
    if status is Status.SUCCESS and not message:
        return str(Outcome.SUCCEEDED)
    if status is Status.INVALID and message == HALTED:
        return str(Outcome.CANCELED_BY_HALT)
    outcome = message.partition(": ")[0]
    return outcome if outcome in Outcome._value2member_map_ else ""


def _value(text: str) -> Plain | None:
    """Return a variable's value from JSON; None for a long one, which was cut."""
    try:
        value = json.loads(text)
    except ValueError:
        return None
    return value if isinstance(value, bool | int | float | str | list) else None
