"""The details of a mission beyond the statuses of its nodes: progress, goals, variables."""

from __future__ import annotations

import json
import reprlib
from collections.abc import Iterator
from itertools import islice
from typing import Any

from bt_mission_interfaces.msg import MissionDetails, Variable

from bt_mission.executive.behaviours.leaves import progress_of
from bt_mission.executive.events.events import (
    BreakpointsChanged,
    CountsChanged,
    Event,
    GoalChanged,
    NodeProgressed,
    VariableChanged,
)
from bt_mission.ros import event_messages
from bt_mission.ros.mission_runtime import MissionRuntime

MOST_RUNNING = 50
"""Running nodes in one message; with more, they take turns."""

KEPT_GOALS = 50
"""Goals that have ended and are in a complete message."""

VALUE_CHARACTERS = 200
"""Of a variable's value."""

_SHORTENED = reprlib.Repr()
_SHORTENED.maxother = _SHORTENED.maxstring = VALUE_CHARACTERS
_SHORTENED.maxlist = _SHORTENED.maxtuple = _SHORTENED.maxdict = 20


class MissionDetailsBuilder:
    """Describes one mission, for one subscriber.

    Args:
        run: The mission.
    """

    def __init__(self, run: MissionRuntime) -> None:
        self._run = run
        self._state = run.executive.mission_state
        self._goals: dict[str, GoalChanged] = {}
        self._values: dict[str, str] = {}
        self._turn = 0
        self._shown: dict[int, tuple[Any, ...]] = {}

    def describe(self, *, complete: bool) -> MissionDetails:
        """Describe it.

        Args:
            complete: With all goals and variables, not only those that have changed.
        """
        return self._described([*self._running()], complete=complete)

    def describe_changes(self) -> MissionDetails:
        """Describe what has changed since the last time, of running nodes, too."""
        return self._described(self._progressed(), complete=False)

    def changes(self) -> tuple[Event, ...]:
        """Return the same as events, but for goals, which have their own."""
        run, now_ns = self._run, self._run.now_ns
        return (
            CountsChanged(now_ns, run.executive.ticks, run.ledger.goals_sent),
            BreakpointsChanged(now_ns, run.executive.breakpoints.names),
            *self._progressed(),
            *self._variables(complete=False),
        )

    def _progressed(self) -> list[NodeProgressed]:
        """Return the progress of running nodes that has changed since the last time."""
        running = []
        for progress in self._running():
            shown = (
                progress.since_ns,
                progress.message,
                progress.label,
                progress.value,
                progress.limit,
            )
            if self._shown.get(progress.node) != shown:
                self._shown[progress.node] = shown
                running.append(progress)
        return running

    def _described(self, running: list[NodeProgressed], *, complete: bool) -> MissionDetails:
        run, state = self._run, self._state
        return MissionDetails(
            stamp=event_messages.stamp(run.now_ns),
            run=run.executive.run,
            ticks=run.executive.ticks,
            goals_sent=run.ledger.goals_sent,
            running=[event_messages.progress(progress) for progress in running],
            goals=[
                event_messages.goal(goal, state.goals_changed_ns[goal.id])
                for goal in self._some_goals(complete=complete)
            ],
            variables=[
                Variable(name=variable.name, value=variable.value)
                for variable in self._variables(complete=complete)
            ],
            breakpoints=list(run.executive.breakpoints.names),
        )

    def _some_goals(self, *, complete: bool) -> list[GoalChanged]:
        goals = self._state.goals
        ended = [goal.id for goal in goals.values() if goal.is_ended]
        old = frozenset(ended[:-KEPT_GOALS])
        known, self._goals = self._goals, {k: goal for k, goal in goals.items() if k not in old}
        return [
            goal
            for goal in self._goals.values()
            if complete or goal.id not in known or known[goal.id].state != goal.state
        ]

    def _running(self) -> Iterator[NodeProgressed]:
        nodes, count = self._state.running, len(self._state.running)
        first = 0
        if count > MOST_RUNNING:
            first, self._turn = self._turn % count, self._turn + MOST_RUNNING
        now_ns = self._run.now_ns
        for index in islice((*nodes, *nodes), first, first + min(count, MOST_RUNNING)):
            node = self._run.executive.nodes[index]
            progress = progress_of(node)
            yield NodeProgressed(
                now_ns,
                index,
                self._state.since_ns[index] or 0,
                node.feedback_message,
                "" if progress is None else progress.label,
                0.0 if progress is None else float(progress.value),
                0.0 if progress is None else float(progress.limit),
            )

    def _variables(self, *, complete: bool) -> Iterator[VariableChanged]:
        for name, value in self._run.variables().items():
            text = as_json(value)
            if complete or self._values.get(name) != text:
                self._values[name] = text
                yield VariableChanged(self._run.now_ns, name, text)


def as_json(value: Any) -> str:
    """Return a value as JSON, of at most :data:`VALUE_CHARACTERS`; what JSON lacks as text."""
    is_large = isinstance(value, str | list | tuple | dict) and len(value) > VALUE_CHARACTERS
    text = _SHORTENED.repr(value) if is_large else json.dumps(value, default=_SHORTENED.repr)
    return text if len(text) <= VALUE_CHARACTERS else text[: VALUE_CHARACTERS - 3] + "..."
