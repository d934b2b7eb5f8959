"""What servers do on a way through a mission, with its times: the servers of a scenario."""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from bt_mission.commands.prove.choices import Script
from bt_mission.commands.prove.environment import INTERRUPT, START_NS, TICK_NS, Environment
from bt_mission.commands.prove.goal_servers import GoalServer
from bt_mission.commands.prove.timelines import (
    BEAT_S,
    Effect,
    EffectTimeline,
    Timelines,
    seconds_of,
)
from bt_mission.executive.goals.goal import Goal, GoalStatus, GoalTrigger, Phase

ENDS = {
    GoalStatus.SUCCEEDED: "succeed",
    GoalStatus.ABORTED: "abort",
    GoalStatus.CANCELED: "cancel",
}
_TIME = "time passes: "
_DRAWS = " draws "
_BY_ITSELF = ("is over", "is not done in time", "has done its rounds")
"""How the words of limits and loops end, which a run meets without a server."""


def played(environment: Callable[[], Environment], way: Sequence[Script]) -> Played:
    """Take a way; once more, and slower, where a message is not as old as it has to be.

    Args:
        environment: Returns the mission before its first step.
        way: The scripts of the steps.
    """
    first = Played(environment(), way, {})
    return Played(environment(), way, first.pauses) if first.pauses.total() else first


@dataclass
class PlayedGoal:
    """One goal on the way, and the answers to it."""

    action: str
    goal: Goal
    written: dict[str, Any] = field(default_factory=dict)
    """Its answers as a scenario has them."""
    is_asked: bool = False
    """Did it wait for its answer at the end of a step?"""
    was_canceling: bool = False
    """Did it wait for the answer to a cancel at the end of a step?"""
    is_silent: bool = False
    """Does it get no more feedback?"""
    beat_ns: int = 0
    """When it got the last feedback of a tick, ns."""

    @property
    def is_open(self) -> bool:
        """Has the way left its end open?"""
        return not {"end", "after", "answer"} & self.written.keys() and (
            self.written.get("cancel", "refuse") in ("refuse", "ignore")
        )


class Played:
    """Takes a way, and writes down what servers answer.

    Attributes:
        environment: The mission at the end of the way.
        goals: In the order in which they were sent.
        interrupt_s: When Ctrl-C comes, s since the start; None for never.
        others: The answers that no scenario scripts, as text.
        doubts: Why a run that does not show the finding decides nothing.
        end_s: The time at the end of the way, s since the start.
        pauses: By step, the ticks that have to pass from then on, for the age of a message.
    """

    def __init__(
        self, environment: Environment, way: Sequence[Script], pauses: Mapping[int, int]
    ) -> None:
        self.goals: list[PlayedGoal] = []
        self.interrupt_s: float | None = None
        self._timelines = Timelines(environment)
        self.others, self.doubts = self._timelines.others, self._timelines.doubts
        self.environment = environment
        self._known: dict[int, PlayedGoal] = {}
        self._before_ns = START_NS
        self._away = {server.name: EffectTimeline() for server in environment.goal_servers}
        self.pauses: Counter[int] = Counter()
        began_ns: list[int] = []
        left = 0
        for index, script in enumerate(way):
            left += pauses.get(index, 0)
            left -= environment.wait(left)
            began_ns.append(environment.now_ns)
            self._step(script)
            ticks, since_ns = self._timelines.missing
            self.pauses[bisect_left(began_ns, since_ns)] += ticks
        self.end_s = seconds_of(environment.now_ns - START_NS)

    def servers(self, *, ends_open_goals: bool) -> dict[str, Any]:
        """Return the servers of a scenario.

        Args:
            ends_open_goals: Does a goal that the way leaves open succeed? Else it never ends.
        """
        servers: dict[str, list[dict[str, Any]]] = {}
        for entry in self.goals:
            written = dict(entry.written)
            if (entry.is_open and "cancel" in written) or (entry.is_open and not ends_open_goals):
                written["end"] = "never"
            elif entry.is_open and entry.goal.accepted:
                sent_ns = entry.goal.sent_ns
                written["after"] = seconds_of(self.environment.now_ns + 2 * TICK_NS - sent_ns)
            if written.get("end") == "succeed":
                del written["end"]
            servers.setdefault(entry.action.strip("/"), []).append(written)
        return servers

    @property
    def faults(self) -> list[str]:
        """Faults of a scenario: servers of actions that are away; answers of other clients."""
        away = [fault for timeline in self._away.values() for fault in timeline.faults]
        return self._timelines.faults + away

    # ---- the way ----------------------------------------------------------------------------

    def _step(self, script: Script) -> None:
        environment = self.environment
        before_ns = self._before_ns = environment.now_ns
        self._timelines.begin()
        environment.step(script)
        self._timelines.end(environment.choices.words)
        names = [server.name for server in environment.goal_servers]
        for words in environment.choices.words:
            if words == INTERRUPT:
                self.interrupt_s = seconds_of(before_ns - START_NS)
            elif not (
                words.startswith((_TIME, *(f"{name} " for name in names)))
                or words.endswith(_BY_ITSELF)
                or _DRAWS in words
                or self._timelines.knows(words)
            ):
                self.others.append(words)
        for entry in self.goals:
            if entry.is_asked and entry.goal.phase in (Phase.SENT, Phase.RECALLED):
                entry.written["answer"] = "none"
            is_canceling = entry.goal.phase is Phase.CANCELING
            if entry.was_canceling and is_canceling:
                entry.written.setdefault("cancel", "ignore")
            entry.was_canceling, entry.is_asked = is_canceling, True
        for goal in environment.ledger.open_goals:
            if id(goal) not in self._known:
                entry = self._known[id(goal)] = PlayedGoal(goal.goal_client.name, goal)
                self.goals.append(entry)
        for server in environment.goal_servers:
            server.on_answer = self._note_answer
            self._note_presence(server)
            self._note_silence(server)

    def _note_answer(
        self, goal: Goal, answer: GoalTrigger | GoalStatus | None, message: Any
    ) -> None:
        entry = self._known.get(id(goal))
        if entry is None:
            return
        if isinstance(answer, GoalTrigger):
            self._note_event(entry, answer)
        elif answer is None:
            self._note_feedback(entry, message)
        else:
            self._note_result(entry, answer, message)

    def _since(self, entry: PlayedGoal) -> float:
        """Return when an answer comes that the next tick sees, s since the goal was sent."""
        return seconds_of(self.environment.now_ns + TICK_NS - entry.goal.sent_ns)

    def _note_event(self, entry: PlayedGoal, event: GoalTrigger) -> None:
        match event:
            case GoalTrigger.REJECTED:
                if "answer" in entry.written:
                    entry.written["answer_after"] = self._since(entry)
                entry.written["answer"] = "reject"
            case GoalTrigger.CANCEL_REFUSED:
                entry.written["cancel"] = "refuse"
            case GoalTrigger.ACCEPTED if "answer" in entry.written:
                del entry.written["answer"]
                entry.written["answer_after"] = self._since(entry)

    def _note_result(self, entry: PlayedGoal, status: GoalStatus, result: Any) -> None:
        if entry.goal.phase is Phase.ENDED:
            return
        end = ENDS[status]
        is_reply = entry.goal.phase is Phase.CANCELING and "cancel" not in entry.written
        if is_reply:
            entry.written |= {"end": "never", "cancel": "confirm" if end == "cancel" else end}
            if end == "cancel":
                del entry.written["cancel"]
        else:
            entry.written |= {"end": end, "after": self._since(entry)}
        if values := _changed(result):
            entry.written["result"] = values

    def _note_feedback(self, entry: PlayedGoal, feedback: Any) -> None:
        messages = entry.written.setdefault("feedback", [])
        is_beat = self.environment.now_ns != self._before_ns
        values = {"values": changed} if (changed := _changed(feedback)) else {}
        if not is_beat:
            messages.append({"after": self._since(entry), **values})
            return
        entry.beat_ns = self.environment.now_ns
        last = {**messages[-1]} if messages else {}
        if "every" not in last or last.get("values", {}) != values.get("values", {}):
            after = seconds_of(self.environment.now_ns - entry.goal.sent_ns)
            messages.append({"after": after, "every": BEAT_S, **values})

    def _note_silence(self, server: GoalServer) -> None:
        """Note that a goal gets no more feedback behind its last beat."""
        for served in server.goals:
            entry = self._known.get(id(served.goal))
            if entry is None or not served.is_silent or entry.is_silent:
                continue
            entry.is_silent = True
            messages = entry.written.setdefault("feedback", [])
            if messages and "every" in messages[-1]:
                after = seconds_of(entry.beat_ns - entry.goal.sent_ns)
                last = {name: value for name, value in messages[-1].items() if name != "every"}
                messages.append({**last, "after": after})

    # ---- servers ----------------------------------------------------------------------------

    def _note_presence(self, server: GoalServer) -> None:
        """Note when a server goes, one tick before the tick that notices it, and comes back."""
        timeline, now_ns = self._away[server.name], self.environment.now_ns
        if server.is_away and timeline.last is None:
            killed = Effect("kill_server", {"action": server.name.strip("/")})
            timeline.change(max(START_NS, now_ns - TICK_NS), killed)
        elif timeline.last is not None and not server.is_away:
            timeline.change(now_ns, None)


def _changed(message: Any) -> dict[str, Any]:
    """Return the fields of a message that have other values than in a new one, as plain values."""
    return _difference(message, type(message)())


def _difference(message: Any, new: Any) -> dict[str, Any]:
    changed: dict[str, Any] = {}
    for name in message.get_fields_and_field_types():
        value, usual = getattr(message, name), getattr(new, name)
        if hasattr(value, "get_fields_and_field_types"):
            if inner := _difference(value, usual):
                changed[name] = inner
        elif isinstance(value, bool | int | float | str) and value != usual:
            changed[name] = value
    return changed
