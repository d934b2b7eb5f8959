"""What steps do, by all that they depend on: a step that is known need not be taken again.

The shape of a state is the state without its times. A step depends on the shape, on the options
that are taken, and on which of the running limits are over with the next tick. It does not depend
on the time that remains for the others, which only becomes less, by as much for each. So the
effect of a step is learned once from the real mission. It is then known for every state of this
shape, whatever its times are.
"""

from __future__ import annotations

import marshal
from collections.abc import Sequence
from typing import Any, NamedTuple, TypeAlias

from bt_mission.proving.choices import NEVER, Chosen, Script, Turn, affordable, leaving
from bt_mission.proving.environment import TICK_NS, Environment
from bt_mission.proving.limits import Due

Times: TypeAlias = tuple[int, ...]
"""The time that remains for each running limit, ns."""


class DivergedError(Exception):
    """A step does not do what was learned of states of its shape."""


class Effect(NamedTuple):
    """The effect of a step.

    Attributes:
        shape: Of the state behind it.
        limits: Of each limit behind it the one before it, by index, and 0; or -1 for a limit that
            the step has begun, and the time that remains for it, ns.
        is_quiet: Did nothing change, so that time passes up to the next limit?
        is_done: Has the mission ended?
        is_stuck: Will nothing more happen?
        shown: What the claims have seen.
    """

    shape: int
    limits: tuple[tuple[int, int], ...]
    is_quiet: bool
    is_done: bool
    is_stuck: bool
    shown: tuple[Any, ...]

    def times(self, before: Times) -> Times:
        """Return the times behind the step.

        Args:
            before: Those of the state in which it begins.
        """
        after = [before[index] - TICK_NS if index >= 0 else left for index, left in self.limits]
        if self.is_quiet and after:
            ticks = max(0, -(-min(after) // TICK_NS) - 1)
            after = [left - ticks * TICK_NS for left in after]
        return tuple([max(0, left) for left in after])


class Step(NamedTuple):
    """A step by a script.

    Attributes:
        taken: Its options.
        others: The scripts that leave it behind the given one.
        faults_left: Behind it.
        effect: None where it takes more faults than remain.
    """

    taken: Script
    others: list[Script]
    faults_left: float
    effect: Effect | None


class _Place:
    """A place at which an option is taken, or at which it counts which limits are over.

    Attributes:
        costs: The faults of each option.
        limits: By index; None where an option is taken.
        branches: What follows, by the option or by which limits are over.
        faults: What it costs that limits are over.
    """

    __slots__ = ("branches", "costs", "faults", "limits")

    def __init__(self, turn: Turn) -> None:
        self.costs = turn.costs if isinstance(turn, Chosen) else ()
        self.limits = None if isinstance(turn, Chosen) else turn.limits
        self.branches: dict[Any, _Place | Effect] = {}
        self.faults: dict[Any, float] = {}

    def is_of(self, turn: Turn) -> bool:
        """Does a turn have the same options or limits?"""
        return turn.costs == self.costs if isinstance(turn, Chosen) else turn.limits == self.limits


class KnownSteps:
    """The steps of a mission as far as they are known.

    Args:
        environment: The mission.
    """

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._shapes: dict[bytes, int] = {}
        self._digests: list[bytes] = []
        self._is_alone: list[bool] = []
        self._begins: dict[int, _Place | Effect] = {}

    def digest_of(self, shape: int) -> bytes:
        """Return a shape by its number."""
        return self._digests[shape]

    @property
    def shape(self) -> int:
        """The number of the shape of the present state."""
        environment = self._environment
        limits, shape = environment.limits, environment.shape
        number = self._shapes.get(shape)
        if number is None:
            number = self._shapes[shape] = len(self._is_alone)
            self._digests.append(shape)
            self._is_alone.append(len(limits) == 1 and environment.is_alone(limits[0]))
        return number

    def key_of(self, shape: int, times: Times) -> bytes:
        """Return what distinguishes states. The time that remains for a lone limit does not."""
        told_apart = (times[0] <= TICK_NS,) if self._is_alone[shape] else times
        return marshal.dumps((shape, told_apart), 2)

    def find(self, shape: int, times: Times, script: Script, faults_left: float) -> Step | None:
        """Return a step from a state; None where it is not known."""
        taken: list[int] = []
        allowed: list[Sequence[int]] = []
        given, place = len(script), self._begins.get(shape)
        effect: Effect | None = None
        while place is not None:
            if isinstance(place, Effect):
                effect = place
                break
            if place.limits is None:
                options: Sequence[int] = ()
                if len(taken) < given:
                    index = script[len(taken)]
                else:
                    options = affordable(place.costs, faults_left)
                    if not options:
                        break
                    index = options[0]
                taken.append(index)
                allowed.append(options)
                faults_left -= place.costs[index]
                place = place.branches.get(index)
            else:
                are_over = tuple([times[index] <= TICK_NS for index in place.limits])
                faults = place.faults.get(are_over, 0)
                if faults > faults_left or faults == NEVER:
                    break
                faults_left -= faults
                place = place.branches.get(are_over)
        else:
            return None
        return Step(tuple(taken), list(leaving(taken, allowed, given)), faults_left, effect)

    def taken(self, before: tuple[Due, ...], shown: tuple[Any, ...], *, is_allowed: bool) -> Step:
        """Return the step that was taken.

        Args:
            before: The limits of the state in which it began.
            shown: What the claims have seen.
            is_allowed: Was it within the bound on faults?
        """
        environment = self._environment
        effect = None
        if is_allowed:
            indices = {(due.owner, due.at_ns): index for index, due in enumerate(before)}
            limits = [
                (indices[due.owner, due.at_ns], 0)
                if (due.owner, due.at_ns) in indices
                else (-1, due.at_ns - environment.ticked_ns)
                for due in environment.limits
            ]
            effect = Effect(
                self.shape,
                tuple(limits),
                environment.is_quiet,
                environment.is_done,
                environment.is_stuck,
                shown,
            )
        choices = environment.choices
        return Step(choices.taken, list(choices.others()), choices.faults_left, effect)

    def learn(self, shape: int, effect: Effect | None) -> None:
        """Know the step that was taken from now on.

        Args:
            shape: Of the state in which it began.
            effect: Its effect.

        Raises:
            DivergedError: It has other options or limits than another step from this shape.
        """
        branches: dict[Any, _Place | Effect] = self._begins
        branch: Any = shape
        for turn in self._environment.choices.trail:
            place = branches.get(branch)
            if place is None:
                place = branches[branch] = _Place(turn)
            elif not isinstance(place, _Place) or not place.is_of(turn):
                raise DivergedError
            branches = place.branches
            if isinstance(turn, Chosen):
                branch = turn.taken
            else:
                branch = turn.are_over
                place.faults[branch] = turn.faults
        if effect is not None:
            branches[branch] = effect
