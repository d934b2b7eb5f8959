"""The limits that are running in a state, and what they cost when they are over."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.commands.prove.abstraction import NEVER_NS, Loose
from bt_mission.commands.prove.answers import AnswerSet
from bt_mission.commands.prove.clients import AnyBehaviour, Service, Topic
from bt_mission.commands.prove.goal_servers import GoalServer, ServedGoal
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.cleanup import Finally
from bt_mission.executive.behaviours.client_leaves import PublishLeaf, ServiceLeaf, WaitFor
from bt_mission.executive.behaviours.control import Timeout
from bt_mission.executive.behaviours.decorators import Retry
from bt_mission.executive.behaviours.leaves import Wait
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.goal import Phase
from bt_mission.executive.goals.ledger import Ledger

LIMITS = {
    "server": "waits for its server in vain",
    "answer": "waits for an answer to its goal in vain",
    "goal": "is not done in time",
    "silence": "gets no feedback in time",
    "cancel": "waits for the cancel in vain",
}
"""By the name of a limit of a goal."""

_WAITING = (Wait, Timeout, Retry, Finally, ServiceLeaf, PublishLeaf, WaitFor)
"""The nodes with a separate limit, goals apart."""


OPEN_NS = NEVER_NS // 2
"""Where a limit is that may be over at any tick, ns."""

_BEGINS = {
    "server": "_since_ns",
    "answer": "_since_ns",
    "goal": "_accepted_ns",
    "silence": "_received_ns",
    "cancel": "_cancel_ns",
}
"""The attribute of an attempt at which each of its limits begins."""
_BEGINS_OF: dict[type, str] = {
    Wait: "due_ns",
    Timeout: "due_ns",
    Retry: "_resume_ns",
    Finally: "_until_ns",
    PublishLeaf: "_until_ns",
    ServiceLeaf: "_since_ns",
    WaitFor: "_since_ns",
}
"""The attribute of a node that moves its limit."""


class Due(NamedTuple):
    """A limit that is running.

    Attributes:
        words: What it limits, for people.
        at_ns: The instant at which it is over, ns.
        owner: Equal for two limits only if they began at the same instant.
        node: Its node; None for the limits of ledger and followed variables.
    """

    words: str
    at_ns: int
    owner: Any
    node: Behaviour | None = None

    @property
    def name(self) -> str:
        """The name of the node or thing that it limits."""
        if self.node is not None:
            return f"'{self.node.name}'"
        return "a topic" if isinstance(self.owner, _Message | _FirstMessage) else "an old goal"


class _Message(NamedTuple):
    """Owner of the limit behind which the newest message of a variable is too old."""

    variable: Any
    number: int


class _FirstMessage(NamedTuple):
    """Owner of the limit of the wait for the first message of a variable."""

    variable: Any
    topic: str


class RunningLimits:
    """Collects the limits of a mission.

    Args:
        executive: Runs the mission.
        ledger: Keeps its goals.
        servers: By the name of the action; more may be added.
        services: By their names; more may be added.
        topics: By their names; more may be added.
        answers: Which servers are ever late.
        loose: The nodes with an abstract deadline, which is no limit.
        are_all_open: May every limit be over at any tick?
    """

    def __init__(
        self,
        executive: Executive,
        ledger: Ledger,
        servers: Mapping[str, GoalServer],
        services: Mapping[str, Service],
        topics: Mapping[str, Topic],
        answers: AnswerSet,
        loose: Iterable[Loose],
        *,
        are_all_open: bool = False,
    ) -> None:
        self._executive, self._ledger = executive, ledger
        self._servers, self._services = servers, services
        self._topics, self._answers = topics, answers
        self.are_all_open = are_all_open
        nodes = executive.nodes
        self._leaves = [node for node in nodes if isinstance(node, ActionLeaf)]
        self._of_leaves = {
            leaf: {name: f"'{leaf.name}' {words}" for name, words in LIMITS.items()}
            for leaf in self._leaves
        }
        own = {node: _words_of(node) for node in nodes if isinstance(node, _WAITING)}
        self.loose = {
            node: self._of_leaves[node]["goal"] if isinstance(node, ActionLeaf) else own.pop(node)
            for node in loose
        }
        """The nodes with an abstract deadline, and the words for it."""
        self._own = [
            (node, words, node if isinstance(node, Finally) else None)
            for node, words in own.items()
        ]

    def running(self, now_ns: int) -> tuple[Due, ...]:
        """Return the limits that are running, in a fixed order."""
        running = Status.RUNNING
        collected: list[Due] = []
        inside = self._executive.cleanups.inside
        for leaf in self._leaves:
            attempt = leaf.attempt
            if attempt is not None and leaf.status is running:
                is_held = self._ledger.is_held and leaf not in inside
                for name, at_ns in attempt.limits_due.items():
                    if (name == "goal" and leaf in self.loose) or (name == "server" and is_held):
                        continue
                    words = self._of_leaves[leaf][name]
                    collected.append(Due(words, at_ns, (attempt, name), leaf))
        for node, words, final in self._own:
            if node.status is running or (final is not None and final.is_detached):
                due_ns = node.due_ns
                if due_ns is not None:
                    collected.append(Due(words, due_ns, node, node))
        collected += [
            Due("", at_ns, owner) for owner, at_ns in self._others() if now_ns < at_ns < NEVER_NS
        ]
        return tuple(collected)

    def _others(self) -> Iterator[tuple[Any, int]]:
        yield from self._ledger.limits_due
        if not self._executive.is_done:
            known: set[Any] = set()
            for variable, at_ns in self._executive.followed.limits_due:
                # Each message begins the limit again, which may end at the same instant.
                topic = self._topics[variable.topic]
                if variable.due_ns is None or variable in known:
                    yield _FirstMessage(variable, topic.name), at_ns
                elif not topic.is_age_loose:
                    yield _Message(variable, topic.count), at_ns
                known.add(variable)

    def _silence_of(self, name: str) -> float:
        """Return the faults of a topic without any message; 0 if it has sent no number."""
        if self._topics[name].count:
            return 0
        return 1 if self._answers.is_ever("quiet", name) else math.inf

    def open(self, now_ns: int) -> tuple[Due, ...]:
        """Put all limits off that are running, and return them."""
        dues = self.running(now_ns)
        for due in dues:
            self.move(due, OPEN_NS)
        return dues

    def move(self, due: Due, at_ns: int) -> None:
        """Have a limit be over at another instant, ns."""
        node, owner = due.node, due.owner
        if isinstance(node, ActionLeaf):
            attempt, name = owner
            _shift(attempt, _BEGINS[name], at_ns - attempt.limits_due[name])
            attempt.__dict__["_due_ns"] = min(attempt.__dict__["_due_ns"], at_ns)
        elif node is not None:
            name = next(name for kind, name in _BEGINS_OF.items() if isinstance(node, kind))
            _shift(node, name, at_ns - node.due_ns)  # type: ignore[attr-defined]
        elif isinstance(owner, _FirstMessage):
            followed = self._executive.followed
            _shift(followed, "_since_ns", at_ns - dict(followed.limits_due)[owner.variable])
        elif isinstance(owner, _Message):
            _shift(owner.variable, "_received_ns", at_ns - owner.variable.due_ns)
        else:
            goal = next(goal for goal in self._ledger.open_goals if goal.id == owner[1])
            goal.orphaned_ns = at_ns - goal.grace_ns

    def age(self, now_ns: int) -> None:
        """Have the newest messages of silent topics be as old as they are chosen to be."""
        for variable in self._executive.followed.variables:
            topic = self._topics[variable.topic]
            if topic.is_age_loose and topic.is_quiet and variable.due_ns is not None:
                is_old = (variable.timeout_s or 0.0) <= topic.age_s
                self.move(Due("", 0, _Message(variable, 0)), now_ns if is_old else OPEN_NS)

    def is_renewed(self, due: Due) -> bool:
        """Does each message begin a limit again, so that it is never over?"""
        owner = due.owner
        return isinstance(owner, _Message) and not self._topics[owner.variable.topic].is_quiet

    def is_moot(self, due: Due) -> bool:
        """Return whether the goal of a limit has ended since the last tick: nobody looks at it."""
        if isinstance(due.node, ActionLeaf):
            goal = due.owner[0].goal
            return goal is not None and goal.phase is Phase.ENDED
        if due.node is None and type(due.owner) is tuple:
            return all(
                goal.id != due.owner[1] or goal.phase is Phase.ENDED
                for goal in self._ledger.open_goals
            )
        return False

    def faults_of(self, due: Due) -> float:
        """Return the faults that it takes for a limit to be over.

        1 where a server has to be late; infinite where one of them never is.
        """
        node = due.node
        if isinstance(due.owner, _FirstMessage):
            return self._silence_of(due.owner.topic)
        if isinstance(node, WaitFor):
            return 1
        if self._is_owed(due):
            return math.inf
        late: list[Behaviour] = []
        if isinstance(node, ActionLeaf) and due.words is self._of_leaves[node]["goal"]:
            late = [node]
        elif isinstance(node, Timeout | Finally):
            below = node.cleanup if isinstance(node, Finally) else node
            late = list(below.iterate())
        servers = [name for entry in late if (name := self.working_for(entry))]
        if not all(map(self._answers.is_ever_late, servers)):
            return math.inf
        return int(bool(servers))

    def _is_owed(self, due: Due) -> bool:
        """Is a server to give the answer in time that this limit waits for?"""
        node = due.node
        if isinstance(node, ServiceLeaf):
            return any(
                leaf is node and not service.is_mute
                for service in self._services.values()
                for leaf, _ in service.calls[:1]
            )
        if isinstance(node, ActionLeaf):
            goal = node.attempt.goal if node.attempt else None
            words = [self._of_leaves[node][name] for name in ("answer", "cancel")]
            return due.words in words and any(entry.goal is goal for entry in self._owed)
        if node is None and type(due.owner) is tuple:
            # A cancel that was sent since the last tick has had no time to be answered.
            are_new = not self.are_all_open
            owed = [
                entry
                for entry in self._owed
                if not (are_new and entry.is_live and not entry.delays)
                and not entry.server.may_be_given_up(entry)
            ]
            return any(entry.goal.id == due.owner[1] for entry in owed)
        return False

    @property
    def _owed(self) -> Iterator[ServedGoal]:
        for server in self._servers.values():
            yield from (served for served in server.goals if served.is_owed)

    def working_for(self, node: Behaviour) -> str:
        """Return the server or class that works for a leaf, as it usually does in time; or ""."""
        if isinstance(node, ActionLeaf) and self.has_working_server(node):
            assert node.attempt is not None
            assert node.attempt.goal is not None
            return node.attempt.goal.goal_client.name
        if isinstance(node, AnyBehaviour) and node.status is Status.RUNNING:
            return node.name if node.answer == "running" else ""
        return ""

    def may_run_for_ever(self, leaf: Behaviour) -> bool:
        """May a leaf without a limit of its own wait, while the limits of others run and begin?"""
        if leaf.status is not Status.RUNNING or not isinstance(leaf, ActionLeaf):
            return leaf.status is Status.RUNNING
        attempt = leaf.attempt
        if attempt is None or attempt.cause is not None:
            return False
        return any(
            served.goal is attempt.goal and served.stage == "working" and not served.is_silent
            for server in self._servers.values()
            for served in server.goals
        )

    def has_working_server(self, leaf: ActionLeaf) -> bool:
        """Does a server work on the goal of a leaf?"""
        goal = leaf.attempt.goal if leaf.attempt else None
        return any(
            served.goal is goal and served.stage == "working"
            for server in self._servers.values()
            for served in server.goals
        )


def _shift(owner: Any, name: str, by_ns: int) -> None:
    owner.__dict__[name] += by_ns


def _words_of(node: Behaviour) -> str:
    """Return what happens when the limit of a node is over."""
    match node:
        case Wait():
            return f"'{node.name}' is over"
        case Retry():
            return f"the pause of '{node.name}' is over"
    return f"'{node.name}' is not done in time"
