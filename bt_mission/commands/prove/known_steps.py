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
from hashlib import blake2b
from typing import Any, NamedTuple, TypeAlias

from bt_mission.commands.prove.choices import NEVER, Chosen, Met, Script, Turn, affordable, leaving
from bt_mission.commands.prove.environment import TICK_NS, Environment
from bt_mission.commands.prove.limits import Due

Times: TypeAlias = tuple[int, ...]
"""The time that remains for each running limit, ns."""


class DivergedError(Exception):
    """A step does not do what was learned of states of its shape."""


class Change(NamedTuple):
    """The change that a step makes, apart from the shape.

    Attributes:
        limits: Of each limit behind it the one before it, by index, and 0; or -1 for a limit that
            the step has begun, and the time that remains for it, ns.
        is_quiet: Did nothing change, so that time passes up to the next limit?
        is_done: Has the mission ended?
        is_stuck: Will nothing more happen?
        shown: What the claims have seen.
        beside: The names of the limits that still run behind an answer, which may come at another
            instant.
    """

    limits: tuple[tuple[int, int], ...]
    is_quiet: bool
    is_done: bool
    is_stuck: bool
    shown: tuple[Any, ...]
    beside: tuple[str, ...] = ()

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


Effect: TypeAlias = int
"""The effect of a step: the shape behind it and the number of its change, in one integer.

An exploration knows one for each of its steps, so they are small."""
_BITS_OF_CHANGE = 32


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


class _Options(list[Any]):
    """A place at which an option is taken: by option, the next place or the effect.

    Attributes:
        costs: The faults of each option.
    """

    __slots__ = ("costs",)

    def __init__(self, costs: tuple[int, ...]) -> None:
        super().__init__([None] * len(costs))
        self.costs = costs

    def is_of(self, turn: Turn) -> bool:
        """Does a turn have the same options?"""
        return isinstance(turn, Chosen) and turn.costs == self.costs


class _Limits(list[Any]):
    """A place at which it counts which limits are over, or over first.

    It has three entries for each case: which are over, the faults of that, and the next place or
    the effect.

    Attributes:
        limits: By index.
        is_order: Does it count which of them are over first?
    """

    __slots__ = ("is_order", "limits")

    def __init__(self, limits: tuple[int, ...], *, is_order: bool) -> None:
        super().__init__()
        self.limits, self.is_order = limits, is_order

    def is_of(self, turn: Turn) -> bool:
        """Does a turn have the same limits?"""
        if not isinstance(turn, Met):
            return False
        return turn.limits == self.limits and turn.is_order == self.is_order

    def case_of(self, times: Times) -> tuple[bool, ...]:
        """Return which limits count."""
        left = [times[index] for index in self.limits]
        until = min(left, default=0) if self.is_order else TICK_NS
        return tuple([time <= until for time in left])

    def slot_of(self, are_over: tuple[bool, ...]) -> int:
        """Return the index of what follows in a case; 0 for an unknown one."""
        for index in range(0, len(self), 3):
            if self[index] == are_over:
                return index + 2
        return 0


class KnownSteps:
    """The steps of a mission as far as they are known.

    Args:
        environment: The mission.
    """

    def __init__(self, environment: Environment) -> None:
        self._environment = environment
        self._shapes: dict[bytes, int] = {}
        self._is_alone = bytearray()
        self._begins: list[Any] = []
        """By shape, the first place of its steps, or the effect of the only one."""
        self._changes: dict[Change, int] = {}
        self._by_number: list[Change] = []
        self._same: dict[Any, Any] = {}
        self.digests: list[bytes] = []
        """By shape, its hash."""

    @property
    def shape(self) -> int:
        """The number of the shape of the present state."""
        environment = self._environment
        limits, shape = environment.limits, environment.shape
        number = self._shapes.get(shape)
        if number is None:
            number = self._shapes[shape] = len(self._is_alone)
            self.digests.append(shape)
            self._begins.append(None)
            self._is_alone.append(len(limits) == 1 and environment.is_alone(limits[0]))
        return number

    def key_of(self, shape: int, times: Times) -> int | bytes:
        """Return what distinguishes states. The time that remains for a lone limit does not."""
        if not times:
            return shape << 1
        if self._is_alone[shape]:
            return shape << 1 | (times[0] <= TICK_NS)
        return blake2b(marshal.dumps((shape, times), 2), digest_size=16).digest()

    def change_of(self, effect: Effect) -> Change:
        """Return the change that a step makes."""
        return self._by_number[effect & ((1 << _BITS_OF_CHANGE) - 1)]

    def find(self, shape: int, times: Times, script: Script, faults_left: float) -> Step | None:
        """Return a step from a state; None where it is not known."""
        taken: list[int] = []
        allowed: list[Sequence[int]] = []
        given, place = len(script), self._begins[shape]
        effect: Effect | None = None
        while place is not None:
            if type(place) is _Options:
                costs = place.costs
                options: Sequence[int] = ()
                if len(taken) < given:
                    index = script[len(taken)]
                else:
                    options = affordable(costs, faults_left)
                    if not options:
                        break
                    index = options[0]
                taken.append(index)
                allowed.append(options)
                faults_left -= costs[index]
                place = place[index]
            elif type(place) is _Limits:
                slot = place.slot_of(place.case_of(times))
                if not slot:
                    return None
                faults = place[slot - 1]
                if faults > faults_left or faults == NEVER:
                    break
                faults_left -= faults
                place = place[slot]
            else:
                effect = place
                break
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
        environment, effect = self._environment, None
        if is_allowed:
            indices = {(due.owner, due.at_ns): index for index, due in enumerate(before)}
            limits = [
                (indices[due.owner, due.at_ns], 0)
                if (due.owner, due.at_ns) in indices
                else (-1, due.at_ns - environment.ticked_ns)
                for due in environment.limits
            ]
            change = Change(
                tuple(limits),
                environment.is_quiet,
                environment.is_done,
                environment.is_stuck,
                shown,
                self._beside(before, limits),
            )
            number = self._changes.setdefault(change, len(self._by_number))
            if number == len(self._by_number):
                self._by_number.append(change)
            effect = self.shape << _BITS_OF_CHANGE | number
        choices = environment.choices
        return Step(choices.taken, list(choices.others()), choices.faults_left, effect)

    def _beside(self, before: tuple[Due, ...], limits: list[tuple[int, int]]) -> tuple[str, ...]:
        if not self._environment.is_timed:
            return ()
        return tuple([before[index].name for index, _ in limits if index >= 0])

    def learn(self, shape: int, effect: Effect | None) -> None:
        """Know the step that was taken from now on.

        Args:
            shape: Of the state in which it began.
            effect: Its effect.

        Raises:
            DivergedError: It has other options or limits than another step from this shape.
        """
        holder, slot = self._begins, shape
        for turn in self._environment.choices.trail:
            place = holder[slot]
            if place is None:
                place = holder[slot] = self._place(turn)
            elif type(place) is int or not place.is_of(turn):
                raise DivergedError
            holder, slot = place, self._slot(place, turn)
        if effect is not None:
            holder[slot] = effect

    def _place(self, turn: Turn) -> _Options | _Limits:
        same = self._same.setdefault
        if isinstance(turn, Chosen):
            return _Options(same(turn.costs, turn.costs))
        return _Limits(same(turn.limits, turn.limits), is_order=turn.is_order)

    def _slot(self, place: _Options | _Limits, turn: Turn) -> int:
        if isinstance(turn, Chosen):
            return turn.taken
        assert isinstance(place, _Limits)
        slot = place.slot_of(turn.are_over)
        if not slot:
            place += (self._same.setdefault(turn.are_over, turn.are_over), turn.faults, None)
            slot = len(place) - 1
        return slot


def shape_of(effect: Effect) -> int:
    """Return the shape behind a step."""
    return effect >> _BITS_OF_CHANGE
