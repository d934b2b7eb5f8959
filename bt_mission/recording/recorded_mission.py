"""The state of a recorded mission at an instant: its nodes, goals and variables."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

from py_trees.common import Status

from bt_mission.behaviours.action_leaf import HALTED, ActionLeaf
from bt_mission.core.diagnostics import quoted
from bt_mission.events import reader as messages
from bt_mission.events.events import (
    FINAL,
    NodeChanged,
    NodeInfo,
    RunStarted,
    StateChanged,
    VariableChanged,
)
from bt_mission.goals.outcome import Outcome
from bt_mission.language.expressions.values import Plain
from bt_mission.language.requirements.syntax import SignalValue
from bt_mission.recording.expected_types import TEXT, expect
from bt_mission.recording.reading import Channel
from bt_mission.requirements.compiler import Reader
from bt_mission.ros.signals import STATUSES, NodeOutcomes, field_of

FEEDBACK = "/_action/feedback"
_POSE = b'"event": "pose"'


class RecordedMission:
    """Takes in what an executive has told of its mission: by its trace, else by its topics.

    Args:
        node: Full name of the executive's node.
        tree: Of the mission; None where there is none in the recording.
        topics: All that are in it.
    """

    def __init__(self, node: str, tree: RunStarted | None, topics: Mapping[str, str]) -> None:
        self.ending = ""
        """How the mission has ended: one of :data:`FINAL`; empty while it has not."""
        self.seen: defaultdict[str, set[Status]] = defaultdict(set)
        """Statuses that nodes have had since the last instant, by their paths."""
        self.collisions: int | None = None
        self.variables: dict[str, Plain | None] = {}
        self._node = node
        self._nodes: tuple[NodeInfo, ...] = () if tree is None else tree.nodes
        self._has_trace = f"{node}/trace" in topics and bool(self._nodes)
        self._topics = topics
        self._status = {one.path: Status.INVALID for one in self._nodes}
        self._names = {one.path: one.name for one in self._nodes}
        self._open: set[str] = set()
        self._sent: dict[str, str] = {}
        """Goals that no leaf has yet, by the names of their leaves."""
        self._goals: dict[str, str] = {}
        """The present goals of leaves, by their paths."""
        self._outcomes = NodeOutcomes()
        self._ended_accepted: set[str] = set()
        """Goals that have ended with a result, so that they had been accepted."""
        self._feedback: dict[str, Any] = {}
        self._wants_feedback = self._wants_poses = False

    def reader(self, signal: SignalValue) -> Reader | str:
        """Return what gives a signal's present value, or why it is not known here."""
        if not self._nodes:
            return "the recording has no mission in it"
        name, arguments = signal.name, signal.arguments
        if name == "$":
            return lambda: self.variables.get(arguments[0])
        if name in STATUSES:
            return self._node_status(STATUSES[name], arguments[0])
        if not self._has_trace:
            return "the recording has no trace of the mission"
        makers: Mapping[str, Callable[..., Reader | str]] = {
            "open_goals": lambda: lambda: len(self._open),
            "collisions": self._count_collisions,
            "outcome": self._outcome,
            "feedback": self._feedback_of,
        }
        return makers[name](*arguments)

    def wants(self, topic: str) -> bool:
        """Are messages of a topic of use?"""
        return bool(self._nodes) and (topic.endswith(FEEDBACK) or topic.startswith(self._node))

    def take(self, channel: Channel, data: bytes) -> None:
        """Take in a message, if it is of use."""
        topic = channel.topic
        if topic.endswith(FEEDBACK):
            if self._wants_feedback:
                self._take_feedback(channel.decode(data))
        elif topic.startswith(self._node) and self._nodes:
            self._take_own(topic.removeprefix(f"{self._node}/"), channel, data)

    def forget(self) -> None:
        """Forget what nodes went through; called after each instant."""
        self.seen.clear()
        self._outcomes.forget()

    # ---- what is told ----------------------------------------------------------------------

    def _take_own(self, topic: str, channel: Channel, data: bytes) -> None:
        if topic == "trace":
            expect(channel, TEXT)
            if _POSE in data and not self._wants_poses:
                return
            self._take_event(json.loads(channel.decode(data)["data"]))
        elif topic == "details":
            for event in messages.details(channel.decode(data)).events:
                if isinstance(event, VariableChanged):
                    self.variables[event.name] = _value(event.value)
        elif topic == "changes" and not self._has_trace:
            for event in messages.changes(channel.decode(data)).events:
                if isinstance(event, NodeChanged):
                    self._note(self._nodes[event.node].path, event.status, "")
        elif topic == "state" and not self._has_trace:
            (state,) = messages.state(channel.decode(data)).events
            assert isinstance(state, StateChanged), "this is what it reads"
            self.ending = state.status if state.status in FINAL else ""

    def _take_event(self, event: Mapping[str, Any]) -> None:
        match event.get("event"):
            case "pose":
                self.collisions = event["collisions"]
            case "status":
                self._note(event["path"], Status(event["status"]), event.get("message", ""))
            case "mission":
                self.ending = str(event["status"])
            case "goal sent":
                self._open.add(event["goal"])
                self._sent[event["owner"]] = event["goal"]
            case "goal found again":
                self._open.add(event["goal"])
            case "goal ended":
                self._open.discard(event["goal"])
                if event.get("status") is not None:
                    self._ended_accepted.add(event["goal"])

    def _note(self, path: str, status: Status, message: str) -> None:
        self._status[path] = status
        self._outcomes.note(path, status, _outcome_in(message, status))
        self.seen[path].add(status)
        if status is Status.RUNNING:
            goal = self._sent.pop(self._names[path], None)
            self._goals[path] = "" if goal is None else goal

    def _take_feedback(self, message: Any) -> None:
        self._feedback[bytes(message.goal_id.uuid).hex()] = message.feedback

    # ---- readers ---------------------------------------------------------------------------

    def _paths(self, node: str) -> list[str]:
        return [one.path for one in self._nodes if node in (one.name, one.path)]

    def _node_status(self, status: Status, node: str) -> Reader | str:
        paths, known, seen = self._paths(node), self._status, self.seen
        if not paths:
            return f"the recorded mission has no node {quoted(node)}"
        return lambda: any(known[one] is status or status in seen.get(one, ()) for one in paths)

    def _count_collisions(self) -> Reader:
        self._wants_poses = True
        return lambda: self.collisions

    def _outcome(self, node: str, outcome: str) -> Reader | str:
        leaves = [path for path, _ in self._leaves(node)]
        if not leaves:
            return _no_goal(node)
        return lambda: self._outcomes.is_any(leaves, outcome)

    def _feedback_of(self, node: str, field: str) -> Reader | str:
        leaves = self._leaves(node)
        if not leaves:
            return _no_goal(node)
        if not any(topic.endswith(FEEDBACK) for topic in self._topics):
            return "the recording has no feedback"
        self._wants_feedback = True
        return self._newest(leaves, field)

    def accepted(self, node: str, known: Callable[[], Any]) -> Reader | str:
        """Return what tells whether the newest goal of a node was accepted.

        Args:
            known: Gives the goals under way that were accepted, by their UUIDs in hexadecimal.
        """
        leaves = self._leaves(node)
        if not leaves:
            return _no_goal(node)
        seen: set[str] = set()

        def is_accepted() -> bool:
            seen.update(known() or ())
            goals = [self._goal_of(path, name) for path, name in leaves]
            return any(goal in seen or goal in self._ended_accepted for goal in goals)

        return is_accepted

    def _leaves(self, node: str) -> list[tuple[str, str]]:
        """Return the paths and names of the nodes with goals that have a name or place."""
        kind = ActionLeaf.__name__
        found = [one for one in self._nodes if node in (one.name, one.path) and one.kind == kind]
        return [(one.path, one.name) for one in found]

    def _goal_of(self, path: str, name: str) -> str:
        """Return the newest goal of a leaf; empty where it has none."""
        if self._status[path] is Status.RUNNING and name in self._sent:
            self._goals[path] = self._sent.pop(name)  # sent while it ran already
        return self._goals.get(path, "")

    def _newest(self, leaves: list[tuple[str, str]], field: str) -> Callable[[], Any]:
        def value() -> Any:
            for path, name in leaves:
                if self._status[path] is Status.RUNNING:
                    return plain_field(self._feedback.get(self._goal_of(path, name)), field)
            return None

        return value


def _no_goal(node: str) -> str:
    return f"the recorded mission has no node {quoted(node)} with a goal"


def _outcome_in(message: str, status: Status) -> str:
    """Return how a goal ended, as the status of its leaf tells it; empty for none."""
    if status is Status.SUCCESS and not message:
        return str(Outcome.SUCCEEDED)
    if status is Status.INVALID and message == HALTED:
        return str(Outcome.CANCELED_BY_HALT)
    found = message.partition(": ")[0]
    return found if found in Outcome._value2member_map_ else ""


def plain_field(message: Any, path: str) -> Any:
    """Return a field of a decoded message by its dotted name; None where there is none."""
    try:
        return field_of(message, path)
    except KeyError:
        return None


def _value(text: str) -> Plain | None:
    """Return a variable's value out of JSON; None for a long one, which was cut."""
    try:
        found = json.loads(text)
    except ValueError:
        return None
    return found if isinstance(found, bool | int | float | str | list) else None
