"""Visits every state of a mission once, breadth first: the way to each is a shortest one.

A state is visited again only with more faults left than before. A visited state is saved as its
hash, the state before it and the script of the step between; the objects are kept only as long as
its steps are not taken.
"""

from __future__ import annotations

import gc
from array import array
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from bt_mission.proving.choices import Script
from bt_mission.proving.environment import Environment
from bt_mission.proving.memento import Memento

BYTES_A_STATE = 400
"""Memory of a visited state, an estimate; a state that waits takes ten times as much."""
REPORT_EVERY = 500


class Claim(Protocol):
    """The checks of every state."""

    def check(self, environment: Environment, state: int) -> None:
        """Look at a state behind a step."""


@dataclass
class Progress:
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
        edges: Pairs of states with a step without a fault between, flat.
        ended: States in which the mission has ended.
        stuck: States in which nothing more happens.
    """

    progress: Progress
    is_exhaustive: bool = True
    why_not: str = ""
    came_from: array[int] = field(default_factory=lambda: array("q"))
    scripts: list[Script] = field(default_factory=list)
    edges: array[int] = field(default_factory=lambda: array("q"))
    ended: set[int] = field(default_factory=set)
    stuck: set[int] = field(default_factory=set)

    def way_to(self, state: int) -> list[Script]:
        """Return the scripts of the steps from the beginning to a state."""
        way: list[Script] = []
        while state >= 0:
            way.append(self.scripts[state])
            state = self.came_from[state]
        return way[::-1]

    def hopeless(self) -> list[int]:
        """Return the states from which no way without faults leads to an end, in their order."""
        before: dict[int, list[int]] = {}
        for start, end in zip(self.edges[::2], self.edges[1::2], strict=True):
            before.setdefault(end, []).append(start)
        hopeful, waiting = set(self.ended), list(self.ended)
        while waiting:
            for state in before.get(waiting.pop(), ()):
                if state not in hopeful:
                    hopeful.add(state)
                    waiting.append(state)
        return [state for state in range(len(self.scripts)) if state not in hopeful]


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

    def why_over(self, progress: Progress, elapsed_s: float) -> str:
        """Return which bound is reached; "" for none."""
        if self.states is not None and progress.states >= self.states:
            return f"the budget of {self.states:,} states is used up"
        if self.seconds is not None and elapsed_s >= self.seconds:
            return f"the budget of {self.seconds:g} s is used up"
        kilobytes = (progress.states + 10 * progress.waiting) * BYTES_A_STATE / 1000
        if self.megabytes is not None and kilobytes > 1000 * self.megabytes:
            return f"the memory of {self.megabytes:g} MB is used up"
        return ""


@dataclass
class _Waiting:
    state: int
    memento: Memento
    faults_left: float
    depth: int


def explore(
    environment: Environment,
    claims: list[Claim],
    bounds: Bounds | None = None,
    elapsed_s: Callable[[], float] = float,
    on_progress: Callable[[Progress], bool] = lambda _: True,
) -> Explored:
    """Visit every state. Python looks for no cycles meanwhile: mementos have none.

    Args:
        environment: As it is before its first step.
        claims: Checked in every state.
        bounds: None for none.
        elapsed_s: Returns the seconds that have passed.
        on_progress: Called now and then; False ends the exploration.
    """
    is_collecting = gc.isenabled()
    gc.disable()
    try:
        return _explored(environment, claims, bounds or Bounds(), elapsed_s, on_progress)
    finally:
        if is_collecting:
            gc.enable()


def _explored(
    environment: Environment,
    claims: list[Claim],
    bounds: Bounds,
    elapsed_s: Callable[[], float],
    on_progress: Callable[[Progress], bool],
) -> Explored:
    progress = Progress()
    explored = Explored(progress)
    numbers: dict[bytes, int] = {}
    most_left: list[float] = []
    origin = environment.save()
    queue = deque([_Waiting(-1, origin, environment.choices.faults_left, 0)])

    steps = 0
    while queue:
        waiting = queue.popleft()
        progress.depth = waiting.depth
        scripts: list[Script] = [()]
        while scripts:
            script = scripts.pop()
            environment.restore(waiting.memento, waiting.faults_left)
            is_allowed = environment.step(script)
            scripts += list(environment.choices.others())[::-1]
            steps += 1
            if steps % REPORT_EVERY == 0 or bounds.states is not None:
                progress.waiting = len(queue)
                explored.why_not = "" if on_progress(progress) else "interrupted"
                explored.why_not = explored.why_not or bounds.why_over(progress, elapsed_s())
                if explored.why_not:
                    explored.is_exhaustive = False
                    return explored
            if is_allowed:
                _take(environment, waiting, explored, numbers, most_left, queue, claims)
    on_progress(progress)
    return explored


def _take(
    environment: Environment,
    waiting: _Waiting,
    explored: Explored,
    numbers: dict[bytes, int],
    most_left: list[float],
    queue: deque[_Waiting],
    claims: list[Claim],
) -> None:
    """Note the state behind a step; have its own steps taken later, unless that was done."""
    key, left = environment.key(), environment.choices.faults_left
    state = numbers.get(key)
    is_new = state is None
    if state is None:
        state = numbers[key] = len(explored.scripts)
        explored.came_from.append(waiting.state)
        explored.scripts.append(environment.choices.taken)
        most_left.append(left)
        explored.progress.states += 1
    if waiting.state >= 0 and left == waiting.faults_left:
        explored.edges.extend((waiting.state, state))
    for claim in claims:
        claim.check(environment, state)
    if environment.is_done:
        explored.progress.paths += is_new
        explored.ended.add(state)
    elif environment.is_stuck:
        explored.stuck.add(state)
    elif is_new or left > most_left[state]:
        # What follows may need the faults that only this way has left.
        explored.came_from[state], explored.scripts[state] = (
            waiting.state,
            environment.choices.taken,
        )
        most_left[state] = left
        queue.append(_Waiting(state, environment.save(waiting.memento), left, waiting.depth + 1))


def replay(environment: Environment, way: list[Script]) -> list[Any]:
    """Take the steps of a way from the beginning; return the events of each, as text."""
    words = []
    for script in way:
        environment.step(script)
        words.append(tuple(environment.choices.words))
    return words
