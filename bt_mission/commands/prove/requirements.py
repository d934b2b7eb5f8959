"""The requirements of a mission, as far as they follow from its nodes, goals and variables."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.actions import GOALS_AT, goals_at
from bt_mission.commands.prove.state_key import plain
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.events.events import NodeChanged
from bt_mission.executive.executive import Executive
from bt_mission.executive.goals.ledger import Ledger
from bt_mission.executive.status import MissionStatus
from bt_mission.language.expressions.values import NoValue
from bt_mission.language.mission import Requirement
from bt_mission.language.outcome import is_outcome
from bt_mission.requirements.compiler import Reader
from bt_mission.requirements.language.formula import root_of, signals_in, walk
from bt_mission.requirements.language.premises import Premise
from bt_mission.requirements.language.signals import SIGNALS
from bt_mission.requirements.language.syntax import Measure, SignalValue, Temporal
from bt_mission.requirements.monitor import Monitor
from bt_mission.requirements.operators import Aligned, Atom

STATUSES = {"running": Status.RUNNING, "succeeded": Status.SUCCESS, "failed": Status.FAILURE}
READABLE = ("$", "open_goals", *GOALS_AT, "accepted", "outcome", *STATUSES)
"""The signals that an exploration knows."""


class NodeHistory:
    """What requirements read of nodes: statuses and outcomes, those within the last tick included.

    Attributes:
        statuses: Of each node, as its last change says.
        seen: Nodes with the statuses that they have had within the tick.
        outcomes: How the newest goal of a leaf has ended.
    """

    def __init__(self) -> None:
        self.statuses: dict[Behaviour, Status] = {}
        self.seen: set[tuple[Behaviour, Status]] = set()
        self.outcomes: dict[Behaviour, str] = {}

    def take(self, node: Behaviour, status: Status) -> None:
        """Note a change."""
        self.statuses[node] = status
        self.seen.add((node, status))
        if isinstance(node, ActionLeaf) and status is not Status.RUNNING:
            ending = node.attempt.ending if node.attempt else None
            self.outcomes[node] = ending.outcome.value if ending else ""

    def forget(self) -> None:
        """Forget the tick: the outcomes of leaves that run again, too."""
        for node, status in self.seen:
            if status is Status.RUNNING and self.statuses[node] is Status.RUNNING:
                self.outcomes.pop(node, None)
        self.seen.clear()


class RequirementMonitors:
    """Evaluates the requirements behind each tick; implements ``SignalSource``.

    Attributes:
        needs_physics: By the name of a requirement that is not evaluated, why.
        is_used: Is any evaluated?
        violated: Those that are violated since the last tick.
        met: The premises that came true with the last tick, each with its requirement's name.
    """

    def __init__(
        self,
        requirements: Iterable[Requirement],
        executive: Executive,
        ledger: Ledger,
        variables: Mapping[str, Any],
    ) -> None:
        self._executive, self._ledger, self._variables = executive, ledger, variables
        self._history = NodeHistory()
        self.needs_physics: dict[str, str] = {}
        self.violated: tuple[Requirement, ...] = ()
        self.met: tuple[tuple[str, Premise], ...] = ()
        self._signals: tuple[Reader, ...] = ()
        self._monitors: list[Monitor] = []
        self._read: dict[Behaviour, None] = {}
        self._ended: dict[Behaviour, None] = {}
        for requirement in requirements:
            why = why_physics(requirement)
            if why:
                self.needs_physics[requirement.name] = why
            else:
                self._monitors.append(Monitor(requirement, self))
        self.is_used = bool(self._monitors)
        self._states = tuple((monitor, _stateful(monitor)) for monitor in self._monitors)

    # ---- the signals ------------------------------------------------------------------------

    def reader(self, signal: SignalValue, /) -> Reader:
        """Return what gives a signal's present value, which is a part of the state from now on."""
        read = self._reader(signal)
        self._signals = (*self._signals, read)
        return read

    def _reader(self, signal: SignalValue) -> Reader:
        name, arguments = signal.name, signal.arguments
        if name == "$":
            return lambda: self._variable(arguments[0])
        if name == "open_goals":
            return lambda: len(self._ledger.open_goals)
        if name in GOALS_AT:
            return partial(self._goals_at, GOALS_AT[name])
        nodes = self._named(arguments[0])
        if name == "accepted":
            return lambda: any(map(_is_accepted, nodes))
        history = self._history
        if name == "outcome":
            wanted = arguments[1]
            self._ended.update(dict.fromkeys(nodes))
            return lambda: any(is_outcome(history.outcomes.get(node, ""), wanted) for node in nodes)
        status = STATUSES[name]
        self._read.update(dict.fromkeys(nodes))
        return lambda: any(
            history.statuses.get(node) is status or (node, status) in history.seen for node in nodes
        )

    def lower_bound(self, _signal: SignalValue, /) -> None:
        """No signal has one."""

    def measured_by(self, _signal: SignalValue, /) -> str:
        """Every signal is the truth."""
        return ""

    def _variable(self, name: str) -> Any:
        value = self._variables.get(name)
        return None if isinstance(value, NoValue) else value

    def _goals_at(self, part: str) -> int:
        return goals_at(part, (goal.goal_client.name for goal in self._ledger.open_goals))

    def _named(self, name: str) -> list[Behaviour]:
        executive = self._executive
        return [node for node in executive.nodes if name in (node.name, executive.path_of(node))]

    # ---- a step -----------------------------------------------------------------------------

    def take(self, event: NodeChanged) -> None:
        """Note that a node has changed."""
        if self.is_used:
            self._history.take(self._executive.nodes[event.node], event.status)

    def step(self, now_ns: int) -> None:
        """Take the instant behind a tick, the last one of the mission included."""
        if not self.is_used:
            return
        executive, violated, met = self._executive, [], []
        is_complete = executive.verdict is not MissionStatus.INTERRUPTED
        for monitor in self._monitors:
            unmet = monitor.unmet
            if monitor.step(now_ns - executive.started_ns):
                violated.append(monitor.requirement)
            if executive.is_done and monitor.finish(is_complete=is_complete):
                violated.append(monitor.requirement)
            if monitor.unmet != unmet:
                names = [(monitor.requirement.name, premise) for premise in unmet]
                met += [pair for pair in names if pair[1] not in monitor.unmet]
        self.violated, self.met = tuple(violated), tuple(met)
        self._history.forget()

    # ---- the state --------------------------------------------------------------------------

    @property
    def key(self) -> tuple[Any, ...]:
        """The state on which later verdicts depend."""
        if self._executive.is_done:
            return tuple([requirement.name for requirement in self.violated])
        history = self._history
        return (
            tuple([_state_of(*pair) for pair in self._states]),
            tuple([history.statuses.get(node, Status.INVALID)._value_ for node in self._read]),
            tuple([history.outcomes.get(node) for node in self._ended]),
            tuple([plain(read()) for read in self._signals]),
        )

    @property
    def kept(self) -> Iterator[Any]:
        """The objects that a step may change."""
        if self.is_used:
            yield self
            yield self._history
            known: set[int] = set()
            for monitor in self._monitors:
                yield from _objects(monitor, known)


def why_physics(requirement: Requirement) -> str:
    """Return why a requirement is not decided by the answers of servers; empty if it is."""
    for signal in signals_in(root_of(requirement)):
        if signal.name not in READABLE:
            what = SIGNALS[signal.name].text if signal.name in SIGNALS else "not known here"
            return f"'{signal.key}': {what}"
    for part in walk(root_of(requirement)):
        if isinstance(part, Temporal) and (part.window.is_bounded or part.window.start):
            return f"'{part.word}' has a window in seconds"
        if isinstance(part, Measure) and (part.window.is_bounded or part.word in ("mean", "rate")):
            return f"'{part.word}' depends on seconds"
    return ""


def _is_accepted(node: Behaviour) -> bool:
    attempt = node.attempt if isinstance(node, ActionLeaf) else None
    return attempt is not None and attempt.goal is not None and attempt.goal.accepted


def _state_of(monitor: Monitor, parts: Iterable[Any]) -> Any:
    """Return what the verdict of a monitor still depends on, without instants and margins.

    Args:
        parts: The operators of the monitor that have a state.
    """
    root = monitor.root
    if root is None or root.decided is not None:
        return monitor.violated_ns is not None
    return tuple([_projected(value) for part in parts for value in vars(part).values()])


def _projected(value: Any) -> Any:
    kind = type(value)
    if kind in _PLAIN:
        return value
    if kind is tuple and len(value) == 4 and type(value[1]) is bool:  # a sample
        return value[1]
    if kind is tuple and len(value) == 2:  # a sample with its instant
        return _projected(value[1])
    if kind is deque:
        return tuple(map(_projected, value))
    return None


_PLAIN = frozenset((bool, int, float, str, type(None)))


def _objects(value: Any, known: set[int]) -> Iterator[Any]:
    """Yield an object with state, and those in it."""
    if isinstance(value, Sequence) and not isinstance(value, str):
        for part in value:
            yield from _objects(part, known)
    elif _is_part(value) and id(value) not in known:
        known.add(id(value))
        yield value
        for part in vars(value).values():
            yield from _objects(part, known)


def _stateful(monitor: Monitor) -> tuple[Any, ...]:
    """Return the parts of a monitor without those that remember nothing."""
    parts = _objects(monitor.root, set())
    return tuple(
        part
        for part in parts
        if not isinstance(part, Atom) and not (isinstance(part, Aligned) and not part.looks_ahead)
    )


def _is_part(value: Any) -> bool:
    """Is it a monitor or one of its operators, rather than what it reads?"""
    return type(value).__module__.startswith("bt_mission.requirements.")
