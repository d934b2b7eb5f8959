"""Visits every state of a mission once, breadth first: the way to each is a shortest one.

A state is visited again only with more faults left than before. A visited state is saved as its
hash, the state before it and the script of the step between; the objects are kept only as long as
its steps are not taken.
"""

from __future__ import annotations

import gc
from array import array
from collections import Counter, deque
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush
from typing import Any, Protocol

from bt_mission.commands.prove.choices import UNBOUNDED, Script
from bt_mission.commands.prove.environment import TICK_NS, Environment
from bt_mission.commands.prove.known_steps import (
    DivergedError,
    Effect,
    KnownSteps,
    Step,
    Times,
    shape_of,
)
from bt_mission.commands.prove.memento import Memento

BYTES_A_STATE = 3_600
"""Memory of a visited state with its share of known steps and kept mementos, an upper estimate:
540 to 3,300 were measured. A state that waits takes as much as three more."""
REPORT_EVERY = 500
KEPT_EVERY = 8
"""Steps from one kept memento to the next; the mission takes those in between again."""


class StateChecks(Protocol):
    """The checks of every state."""

    def look(self, environment: Environment) -> tuple[Any, ...]:
        """Return what the state behind a step shows."""

    def take(self, shown: Any, state: int, faults_left: float) -> None:
        """Note what a state shows."""


@dataclass
class ExplorationProgress:
    """How far an exploration has come."""

    states: int = 0
    waiting: int = 0
    paths: int = 0
    depth: int = 0


@dataclass
class Explored:
    """The extent of an exploration.

    Attributes:
        is_exhaustive: Were all states visited?
        why_not: What ended it before.
        came_from: By state, the one before it; -1 for the first.
        scripts: By state, the script of the step to it.
        shapes: By state, the number of its shape.
        digests: By shape, its hash.
        edges: Pairs of states with a step without a fault between, flat.
        costly_edges: Pairs of states with a step with faults between, and their number, flat.
        ended: States in which the mission has ended.
        stuck: States in which nothing more happens.
        beside: The names of what was limited while answers came, which might have come at instants
            that were not taken.
    """

    progress: ExplorationProgress
    is_exhaustive: bool = True
    why_not: str = ""
    came_from: array[int] = field(default_factory=lambda: array("i"))
    scripts: list[Script] = field(default_factory=list)
    shapes: array[int] = field(default_factory=lambda: array("I"))
    digests: Sequence[bytes] = ()
    edges: array[int] = field(default_factory=lambda: array("I"))
    costly_edges: array[int] = field(default_factory=lambda: array("I"))
    ended: set[int] = field(default_factory=set)
    stuck: set[int] = field(default_factory=set)
    beside: dict[str, None] = field(default_factory=dict)

    def digest_of(self, state: int) -> bytes:
        """Return the hash of the shape of a state."""
        return self.digests[self.shapes[state]]

    def way_to(self, state: int) -> list[Script]:
        """Return the scripts of the steps from the beginning to a state."""
        way: list[Script] = []
        while state >= 0:
            way.append(self.scripts[state])
            state = self.came_from[state]
        return way[::-1]

    def connect(self, start: int, end: int, faults: float) -> None:
        """Note a step between two states; of an unbounded number of faults none is counted."""
        if faults > 0:
            self.costly_edges.extend((start, end, int(faults)))
        else:
            self.edges.extend((start, end))

    def endless(self, states: Collection[int]) -> list[int]:
        """Return the states among these from which a way without faults stays among them for ever.

        Args:
            states: Some of them.
        """
        before: dict[int, list[int]] = {}
        ways: Counter[int] = Counter()
        for start, end in zip(self.edges[::2], self.edges[1::2], strict=True):
            if start in states and end in states:
                before.setdefault(end, []).append(start)
                ways[start] += 1
        endless = set(states)
        waiting = [state for state in states if not ways[state]]
        while waiting:
            state = waiting.pop()
            endless.discard(state)
            for start in before.get(state, ()):
                ways[start] -= 1
                if not ways[start]:
                    waiting.append(start)
        return sorted(endless)

    def faults_to(self, ends: Collection[int]) -> dict[int, int]:
        """Return the fewest faults on a way to one of these states, by state; of those with a way.

        Args:
            ends: Some of them.
        """
        before: dict[int, list[tuple[int, int]]] = {}
        for start, end in zip(self.edges[::2], self.edges[1::2], strict=True):
            before.setdefault(end, []).append((start, 0))
        costly = self.costly_edges
        for start, end, cost in zip(costly[::3], costly[1::3], costly[2::3], strict=True):
            before.setdefault(end, []).append((start, cost))
        fewest: dict[int, int] = {}
        waiting = [(0, state) for state in sorted(ends)]
        while waiting:
            faults, state = heappop(waiting)
            if state not in fewest:
                fewest[state] = faults
                for start, cost in before.get(state, ()):
                    heappush(waiting, (faults + cost, start))
        return fewest

    def hopeless(self) -> list[int]:
        """Return the states from which no way without faults leads to an end, in their order.

        Where each way needs a fault, the servers would have answered before: this does not count.
        """
        before: dict[int, list[int]] = {}
        ways: Counter[int] = Counter(self.edges[::2])
        for start, end in zip(self.edges[::2], self.edges[1::2], strict=True):
            before.setdefault(end, []).append(start)
        known, waiting = set(self.ended), list(self.ended)
        while waiting:
            for state in before.get(waiting.pop(), ()):
                if state not in known:
                    known.add(state)
                    waiting.append(state)
        states = range(len(self.scripts))
        waiting = [state for state in states if not ways[state] and state not in self.stuck]
        while waiting:
            state = waiting.pop()
            known.add(state)
            for start in before.get(state, ()):
                ways[start] -= 1
                if not ways[start]:
                    waiting.append(start)
        return [state for state in states if state not in known]


@dataclass(frozen=True)
class Bounds:
    """When an exploration gives up.

    Attributes:
        states: Most states.
        seconds: Most seconds of processor time.
        megabytes: Most memory for states.
    """

    states: int | None = None
    seconds: float | None = None
    megabytes: float | None = None

    def why_over(self, progress: ExplorationProgress, elapsed_s: float) -> str:
        """Return which bound is reached; "" for none."""
        if self.states is not None and progress.states >= self.states:
            return f"the budget of {self.states:,} states is used up"
        if self.seconds is not None and elapsed_s >= self.seconds:
            return f"the budget of {self.seconds:g} s is used up"
        kilobytes = (progress.states + 3 * progress.waiting) * BYTES_A_STATE / 1000
        if self.megabytes is not None and kilobytes > 1000 * self.megabytes:
            return f"the memory of {self.megabytes:g} MB is used up"
        return ""


@dataclass(slots=True)
class _Waiting:
    """A state whose steps are not taken yet; its memento only where the mission was in it.

    Attributes:
        unkept: The steps since the last state with a kept memento.
    """

    state: int
    shape: int
    times: Times
    faults_left: float
    depth: int
    unkept: int = 0
    memento: Memento | None = None


def explore(
    environment: Environment,
    claims: StateChecks,
    bounds: Bounds | None = None,
    elapsed_s: Callable[[], float] = float,
    on_progress: Callable[[ExplorationProgress], bool] = lambda _: True,
    *,
    learns: bool = True,
) -> Explored:
    """Visit every state. Python looks for no cycles meanwhile: mementos have none.

    Args:
        environment: As it is before its first step.
        claims: Checked in every state.
        bounds: None for none.
        elapsed_s: Returns the seconds that have passed.
        on_progress: Called now and then; False ends the exploration.
        learns: Take steps that are known from the table; else every step is taken.

    Raises:
        DivergedError: A step was learned that does not hold for all states of its shape.
    """
    is_collecting = gc.isenabled()
    gc.disable()
    try:
        exploration = _Exploration(environment, claims, learns=learns)
        return exploration.run(bounds or Bounds(), elapsed_s, on_progress)
    finally:
        if is_collecting:
            gc.enable()


class _Exploration:
    def __init__(self, environment: Environment, claims: StateChecks, *, learns: bool) -> None:
        self._environment, self._claims = environment, claims
        self._learns = learns
        self._known = KnownSteps(environment)
        self._explored = Explored(ExplorationProgress(), digests=self._known.digests)
        self._numbers: dict[int | bytes, int] = {}
        """The states by their keys."""
        self._same: dict[Script, Script] = {}
        self._most_left = array("d")
        """By state, the most faults left so far."""
        origin = environment.save()
        self._kept: dict[int, Memento] = {-1: origin}
        """Of one state of a shape, some steps apart."""
        self._has_kept: set[int] = set()
        left = environment.choices.faults_left
        first = _Waiting(-1, self._known.shape, (), left, 0, memento=origin)
        self._queue = deque([first])

    def run(
        self,
        bounds: Bounds,
        elapsed_s: Callable[[], float],
        on_progress: Callable[[ExplorationProgress], bool],
    ) -> Explored:
        """Take every step of every state."""
        explored, queue = self._explored, self._queue
        progress, steps = explored.progress, 0
        while queue:
            waiting = queue.popleft()
            progress.depth = waiting.depth
            scripts: list[Script] = [()]
            while scripts:
                self._take(waiting, scripts)
                steps += 1
                if steps % REPORT_EVERY == 0 or bounds.states is not None:
                    progress.waiting = len(queue)
                    explored.why_not = "" if on_progress(progress) else "interrupted"
                    explored.why_not = explored.why_not or bounds.why_over(progress, elapsed_s())
                    if explored.why_not:
                        explored.is_exhaustive = False
                        return explored
        on_progress(progress)
        return explored

    def _take(self, waiting: _Waiting, scripts: list[Script]) -> None:
        """Take the step of the last script; add those that leave it on the way."""
        script = scripts.pop()
        step = None
        if self._learns:
            step = self._known.find(waiting.shape, waiting.times, script, waiting.faults_left)
        is_known = step is not None
        if step is None:
            step = self._really_take(waiting, script)
        scripts += step.others[::-1]
        if step.effect is not None:
            self._note(waiting, step, step.effect, is_known=is_known)

    def _really_take(self, waiting: _Waiting, script: Script) -> Step:
        environment = self._environment
        if waiting.memento is None:
            waiting.memento = self._reached(waiting)
        environment.restore(waiting.memento, waiting.faults_left)
        before = environment.limits
        is_allowed = environment.step(script)
        shown = self._claims.look(environment) if is_allowed else ()
        step = self._known.taken(before, shown, is_allowed=is_allowed)
        if self._learns:
            self._known.learn(waiting.shape, step.effect)
        return step

    def _reached(self, waiting: _Waiting) -> Memento:
        """Return the memento of a state: the mission takes the steps to it from a kept one."""
        explored, environment = self._explored, self._environment
        state, way = waiting.state, []
        while state not in self._kept:
            way.append(explored.scripts[state])
            state = explored.came_from[state]
        environment.restore(self._kept[state], UNBOUNDED)
        for script in reversed(way):
            environment.step(script)
        if self._known.shape != waiting.shape:
            raise DivergedError
        return environment.save()

    def _note(self, waiting: _Waiting, step: Step, effect: Effect, *, is_known: bool) -> None:
        """Note the state behind a step; have its own steps taken later, unless that was done."""
        explored, shape, change = self._explored, shape_of(effect), self._known.change_of(effect)
        times, left = change.times(waiting.times), step.faults_left
        taken = self._same.setdefault(step.taken, step.taken)
        key = self._known.key_of(shape, times)
        state = self._numbers.get(key)
        is_new = state is None
        if state is None:
            state = self._numbers[key] = len(explored.scripts)
            explored.came_from.append(waiting.state)
            explored.scripts.append(taken)
            explored.shapes.append(shape)
            self._most_left.append(left)
            explored.progress.states += 1
        if waiting.state >= 0:
            explored.connect(waiting.state, state, waiting.faults_left - left)
        if change.beside and min(waiting.times, default=0) > 2 * TICK_NS:
            explored.beside |= dict.fromkeys(change.beside)
        if change.shown:
            self._claims.take(change.shown, state, left)
        if change.is_done:
            explored.progress.paths += is_new
            explored.ended.add(state)
        elif change.is_stuck:
            explored.stuck.add(state)
        elif is_new or left > self._most_left[state]:
            # What follows may need the faults that only this way has left.
            explored.came_from[state], explored.scripts[state] = waiting.state, taken
            self._most_left[state] = left
            memento, unkept = None, waiting.unkept + 1
            if not is_known:
                memento = self._environment.save()
                if unkept >= KEPT_EVERY and shape not in self._has_kept:
                    self._has_kept.add(shape)
                    self._kept[state], unkept = memento, 0
            depth = waiting.depth + 1
            self._queue.append(_Waiting(state, shape, times, left, depth, unkept, memento))


def replay(environment: Environment, way: list[Script]) -> list[Any]:
    """Take the steps of a way from the beginning; return the events of each, as text."""
    words = []
    for script in way:
        environment.step(script)
        words.append(tuple(environment.choices.words))
    return words
