"""The properties to prove of a mission, each with a name."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

from py_trees.common import Status

from bt_mission.base.actions import PARTS
from bt_mission.commands.prove.environment import INTERRUPT, Environment
from bt_mission.commands.prove.explorer import Explored
from bt_mission.commands.prove.state_key import ORPHANED, is_whole_end
from bt_mission.executive.goals.goal import Phase
from bt_mission.executive.status import MissionStatus
from bt_mission.requirements.language.premises import Premise

ONE_GOAL: dict[str, str] = {part: f"one_goal_at_the_{part}" for part in ("base", *PARTS)}
"""The properties of the parts that one goal at a time moves."""
PROPERTIES = {
    "ends": "every run ends once its servers answer as usual",
    "goals_accounted": "no goal that a server works on is lost from the ledger",
    **{name: f"the {part} never has two open goals" for part, name in ONE_GOAL.items()},
    "cleanup": "every clean-up of `finally` runs",
    "unset_variable": "no variable is read before it has a value",
    "unhandled": "no leaf stops the mission with its own error",
    "dead_node": "every node is entered in some run",
    "interrupt": "after Ctrl-C in any state the mission ends",
    "requirement": "no run violates a requirement",
}
"""In the order in which they are shown."""
OF_SOME_RUN = frozenset(("ends", "dead_node", "interrupt"))
"""Properties that hold because some run does something: a run that may not exist proves none."""

LOSES, WHOLE_END = "loses", "whole end"
"""Names of what a step shows of goals that are lost: that it loses one for ever, and that the
mission ends with nothing else wrong."""
_NO_VALUE = re.compile(r"'\$?([^' ]+)' has no value")
_RAISED = re.compile(r"raised by \S+")


@dataclass(frozen=True)
class Broken:
    """A property that does not hold.

    Attributes:
        about: What it is about, such as two actions: one finding for each.
        node: The name of a node; "" where none is to blame.
        text: In a sentence.
        requirement: The name of a requirement; "" where none is violated.
        state: Where it shows.
        nodes: The names of the nodes that it is about; none for those that run where it shows.
    """

    name: str
    about: str
    node: str
    text: str
    state: int = -1
    requirement: str = ""
    nodes: tuple[str, ...] = ()
    needs_fault: bool = False
    """Does it show only where a fault may still happen?"""
    faults_left: float = 0
    """The most faults that a way to it leaves."""
    is_open: bool = False
    """Does it show only if a run stays for ever in states that show it?"""


@dataclass
class Claims:
    """Checks each state that is visited; the first state that breaks a property is kept."""

    broken: dict[tuple[str, str], Broken] = field(default_factory=dict)
    entered: set[int] = field(default_factory=set)
    failures: dict[str, None] = field(default_factory=dict)
    """Reasons for which a mission fails."""
    given_up: dict[tuple[str, str], None] = field(default_factory=dict)
    """Actions and leaves of goals that the ledger has given up on some way."""
    met: set[tuple[str, Premise]] = field(default_factory=set)
    """Premises that came true on some way, each with its requirement's name."""
    unproved: set[str] = field(default_factory=set)
    """Properties that a run may break which an abstraction adds."""
    _losses: dict[int, float] = field(default_factory=dict)
    """The states behind a step that loses a goal, with the most faults that remain there."""
    _whole_ends: set[int] = field(default_factory=set)
    _open: dict[Broken, set[int]] = field(default_factory=dict)
    """The states in which a run may stay for ever, by the property that this would break."""

    def look(self, environment: Environment) -> tuple[Broken, ...]:
        """Return what the state behind a step shows."""
        self.entered |= environment.entered
        self.met.update(environment.requirements.met)
        for goal in environment.ledger.open_goals:
            if goal.phase is Phase.LOST:
                self.given_up.setdefault((goal.goal_client.name, goal.owner))
        shown = list(_states_broken(environment))
        for requirement in environment.requirements.violated:
            text = f"'{requirement.name}' is violated: {requirement.text}"
            shown.append(
                Broken("requirement", requirement.name, "", text, requirement=requirement.name)
            )
        if environment.has_lost:
            shown.append(Broken(LOSES, "", "", ""))
        if environment.is_done:
            shown += self._look_at_end(environment)
        return tuple(shown)

    def take(self, shown: tuple[Broken, ...], state: int, faults_left: float) -> None:
        """Note what a state shows."""
        for broken in shown:
            if broken.name == LOSES:
                self._losses[state] = max(faults_left, self._losses.get(state, 0))
            elif broken.name == WHOLE_END:
                self._whole_ends.add(state)
            elif broken.is_open and faults_left >= 1:
                self._open.setdefault(broken, set()).add(state)
            elif not broken.is_open and (faults_left >= 1 or not broken.needs_fault):
                key = broken.name, broken.about
                known = self.broken.get(key)
                if known is None or faults_left > known.faults_left:
                    self.broken[key] = replace(broken, state=state, faults_left=faults_left)

    def _look_at_end(self, environment: Environment) -> Iterator[Broken]:
        executive = environment.executive
        for name in environment.skipped_cleanups:
            yield Broken("cleanup", name, name, f"the clean-up of '{name}' has not run")
        if is_whole_end(executive):
            yield Broken(WHOLE_END, "", "", "")
        if executive.verdict is not MissionStatus.FAILURE:
            return
        self.failures.setdefault(environment.reason)
        is_error = executive.root.status is Status.INVALID
        if not is_error or _RAISED.search(executive.reason):
            return
        unset = _NO_VALUE.search(executive.reason)
        name = "unset_variable" if unset else "unhandled"
        about = unset[1] if unset else executive.reason
        named = (node.name for node in executive.nodes)
        nodes = tuple(node for node in named if f"'{node}'" in executive.reason)
        yield Broken(name, about, "", f"the mission ends: {executive.reason}", nodes=nodes)

    def finish(
        self, explored: Explored, *, are_samples: bool = False, is_abstract: bool = False
    ) -> None:
        """Look at the whole, once every state was visited.

        Args:
            are_samples: Were not all values tried? Another one may lead out of a loop.
            is_abstract: Is a loop or a deadline abstract? Then it may last for ever only here.
        """
        self._find_cycles(explored, are_samples=are_samples)
        if any(name == "ends" for name, _ in self.broken):
            return
        for broken, states in self._open.items():
            if endless := explored.endless(states):
                self.unproved.add("ends")
                if not is_abstract:
                    self.take((replace(broken, is_open=False),), endless[0], 1)

    def _find_orphans(self, explored: Explored) -> None:
        """Note whether a mission that has lost a goal can end with nothing else wrong.

        Goals that are lost for ever tell no states apart: they only change the reason at the end.
        """
        fewest = explored.faults_to(self._whole_ends) if self._losses else {}
        if any(fewest.get(state, math.inf) <= left for state, left in self._losses.items()):
            self.failures.setdefault(ORPHANED)

    def _find_cycles(self, explored: Explored, *, are_samples: bool) -> None:
        self._find_orphans(explored)
        if ORPHANED in self.failures:
            del self.failures[ORPHANED]
            for action, owner in self.given_up:
                self.failures.setdefault(f"{ORPHANED}: {action} goal of '{owner}'")
        for state in sorted(explored.stuck)[:1]:
            text = "nothing more happens, and no limit is running"
            self.take((Broken("ends", "stuck", "", text),), state, 0)
        if not explored.is_exhaustive or are_samples:
            return
        hopeless = explored.hopeless()
        if hopeless and not explored.stuck:
            text = "from here it never ends, though its servers answer as usual"
            self.take((Broken("ends", "cycle", "", text),), hopeless[0], 0)

    def never_entered(self, environment: Environment) -> list[str]:
        """Return the names of the nodes that no way has entered; below such a node none."""
        nodes, indices = environment.executive.nodes, environment.executive.indices
        dead = [node for node in nodes if indices[node] not in self.entered]
        return [node.name for node in dead if node.parent is None or node.parent not in dead]


def _states_broken(environment: Environment) -> Iterator[Broken]:
    """Yield the properties that a state breaks."""
    for part, goals in environment.open_at_parts.items():
        if len(goals) < 2:
            continue
        actions = [action for action, _ in goals]
        yield Broken(
            ONE_GOAL[part],
            " ".join(sorted(actions)),
            "",
            f"{' and '.join(actions)} have open goals at the {part} at the same time",
            nodes=tuple(owner for _, owner in goals),
        )
    for action, owner in environment.unaccounted:
        goal = f"{owner} at {action}"
        text = f"the goal of {goal} is not in the ledger"
        yield Broken("goals_accounted", goal, "", text, nodes=(owner,))
    for leaf in environment.silent_leaves:
        text = f"'{leaf.name}' has no limit: it waits for ever where no answer comes"
        yield Broken("ends", leaf.name, leaf.name, text, needs_fault=True)
    for leaf in environment.endless_leaves:
        text = f"'{leaf.name}' has no limit: it runs for ever where its end does not come"
        yield Broken("ends", leaf.name, leaf.name, text, needs_fault=True, is_open=True)


def name_of(broken: Broken, words: Iterable[str]) -> str:
    """Return the name under which a finding is reported: an interrupt on the way counts first."""
    is_of_interrupt = INTERRUPT in words and broken.name in ("ends", "goals_accounted", "cleanup")
    return "interrupt" if is_of_interrupt else broken.name
