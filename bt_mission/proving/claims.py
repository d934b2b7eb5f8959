"""The properties to prove of a mission, each with a name."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from py_trees.common import Status

from bt_mission.executive.status import MissionStatus
from bt_mission.proving.environment import INTERRUPT, Environment
from bt_mission.proving.explorer import Explored

PROPERTIES = {
    "ends": "every run ends once its servers answer as usual",
    "goals_accounted": "no goal that a server works on is lost from the ledger",
    "one_goal_at_the_base": "the base never has two open goals",
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
    """

    name: str
    about: str
    node: str
    text: str
    state: int
    requirement: str = ""


@dataclass
class Claims:
    """Checks each state that is visited; the first state that breaks a property is kept."""

    broken: dict[tuple[str, str], Broken] = field(default_factory=dict)
    entered: set[int] = field(default_factory=set)
    failures: dict[str, int] = field(default_factory=dict)
    """Reasons for which a mission fails, with the first state of each."""

    def check(self, environment: Environment, state: int) -> None:
        """Look at a state."""
        self.entered |= environment.entered
        for name, about, node, text in _states_broken(environment):
            self._note(name, about, node, text, state)
        for requirement in environment.requirements.violated:
            text = f"'{requirement.name}' is violated: {requirement.text}"
            key = ("requirement", requirement.name)
            self.broken.setdefault(key, Broken(*key, "", text, state, requirement.name))
        if environment.is_done:
            self._check_end(environment, state)

    def _check_end(self, environment: Environment, state: int) -> None:
        executive = environment.executive
        for name in environment.skipped_cleanups:
            self._note("cleanup", name, name, f"the clean-up of '{name}' has not run", state)
        if executive.verdict is not MissionStatus.FAILURE:
            return
        reason = environment.reason.partition("; orphaned goals")[0]
        self.failures.setdefault(reason, state)
        is_error = executive.root.status is Status.INVALID
        if not is_error or _RAISED.search(executive.reason):
            return
        unset = _NO_VALUE.search(executive.reason)
        name = "unset_variable" if unset else "unhandled"
        about = unset[1] if unset else executive.reason
        self._note(name, about, "", f"the mission ends: {executive.reason}", state)

    def finish(self, explored: Explored) -> None:
        """Look at the whole, once every state was visited."""
        for state in sorted(explored.stuck)[:1]:
            self._note("ends", "stuck", "", "nothing more happens, and no limit is running", state)
        if not explored.is_exhaustive:
            return
        hopeless = explored.hopeless()
        if hopeless and not explored.stuck:
            text = "from here it never ends, though its servers answer as usual"
            self._note("ends", "cycle", "", text, hopeless[0])

    def never_entered(self, environment: Environment) -> list[str]:
        """Return the names of the nodes that no way has entered; below such a node none."""
        nodes, indices = environment.executive.nodes, environment.executive.indices
        dead = [node for node in nodes if indices[node] not in self.entered]
        return [node.name for node in dead if node.parent is None or node.parent not in dead]

    def _note(self, name: str, about: str, node: str, text: str, state: int) -> None:
        self.broken.setdefault((name, about), Broken(name, about, node, text, state))


def _states_broken(environment: Environment) -> Iterator[tuple[str, str, str, str]]:
    """Yield the properties that a state breaks: name, what it is about, node, text."""
    driving = environment.open_at_base
    if len(driving) > 1:
        names = " and ".join(driving)
        yield (
            "one_goal_at_the_base",
            " ".join(sorted(driving)),
            "",
            f"{names} have open goals at the base at the same time",
        )
    for goal in environment.unaccounted:
        yield "goals_accounted", goal, "", f"the goal of {goal} is not in the ledger"
    if environment.choices.faults_left >= 1:
        for leaf in environment.silent_leaves:
            text = f"'{leaf.name}' has no limit: it waits for ever where no answer comes"
            yield "ends", leaf.name, leaf.name, text


def name_of(broken: Broken, words: Iterable[str]) -> str:
    """Return the name under which a finding is reported: an interrupt on the way counts first."""
    is_of_interrupt = INTERRUPT in words and broken.name in ("ends", "goals_accounted", "cleanup")
    return "interrupt" if is_of_interrupt else broken.name
