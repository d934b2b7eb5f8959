"""The formulas of a run, of which only those are evaluated that an instant can change.

Most formulas compare one signal with a number, and change only where it is worse, or better, than
it ever was. Those of one signal are a group: the signal is read once, and as long as its value is
one with which each of them has seen that nothing changes, none of them is evaluated. A formula that
nothing can change any more is dropped.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from typing_extensions import override

from bt_mission.requirements.looking_back import Monotone
from bt_mission.requirements.roots import NEVER, Root
from bt_mission.requirements.sparing_roots import Steady

LEAST_CHANGE = 1e-9
"""By so much at least values differ that wait one after another: then all margins by them, which
are rounded, differ, too, where neither values nor limits are beyond `MOST_WAITING`."""

MOST_WAITING = 1e6


class _Watched:
    """A formula that may still change, and its number."""

    def __init__(self, number: int, root: Root) -> None:
        self.root = root
        self._number = number
        self._is_told = False

    def step(self, now_ns: int, violated: list[int]) -> None:
        """Evaluate it; add its number where this is the instant at which it is violated."""
        self.root.step(now_ns)
        self._tell(violated)

    def _tell(self, violated: list[int]) -> None:
        if self.root.decided is False and not self._is_told:
            self._is_told = True
            violated.append(self._number)


class _Guarded(_Watched):
    """A formula that one signal can spare, and the values of the signal with which it does.

    Margins never fall where the value goes to the better side, in floating-point numbers, too; and
    what a formula has come to only leaves it less to be spared from. So a value that has spared
    it once does so for good, with all that lie on the better side of it.
    """

    def __init__(self, number: int, root: Root, *, keeps_high: bool) -> None:
        super().__init__(number, root)
        self.keeps_high = keeps_high
        self.low, self.high = math.inf, -math.inf

    @property
    def may_wait(self) -> tuple[float, float]:
        """Between which values of the signal it need not be evaluated at once."""
        return self.low, self.high

    def look(self, value: Any, now_ns: int, violated: list[int]) -> None:
        """Evaluate it, and spare this value from now on, if it changes nothing another time.

        Args:
            value: Of the signal; None where it has none.
        """
        self.step(now_ns, violated)
        if value is not None and self.root.is_spared_now():
            self._spare(value)

    def catch_up(self, value: float, then_ns: int) -> None:
        """Take the most extreme value, and its instant, of those that it was let wait with."""

    def _spare(self, value: Any) -> None:
        if self.keeps_high:
            self.low, self.high = min(self.low, value), math.inf
        else:
            self.low, self.high = -math.inf, max(self.high, value)


class _Compared(_Guarded):
    """A comparison with a number at every instant, or at some: its margin follows from the value.

    So the signal is not read again for it, and while no value decides anything, the most extreme
    one, with its instant, is all that it needs.
    """

    def __init__(self, number: int, root: Steady, of: Monotone, *, keeps_high: bool) -> None:
        super().__init__(number, root, keeps_high=keeps_high)
        self._take, self._rises, self.limit = root.take, of.rises, of.limit or 0.0

    @property
    @override
    def may_wait(self) -> tuple[float, float]:
        if self.low > self.high or abs(self.limit) > MOST_WAITING:  # not evaluated yet, or too far
            return self.low, self.high
        if self.root.decided is not None:
            return -math.inf, math.inf
        if self.keeps_high:
            return min(self.low, math.nextafter(self.limit, math.inf)), math.inf
        return -math.inf, max(self.high, math.nextafter(self.limit, -math.inf))

    @override
    def look(self, value: Any, now_ns: int, violated: list[int]) -> None:
        if value is None or now_ns >= self.root.due_ns:
            super().look(value, now_ns, violated)
            return
        self.catch_up(value, now_ns)
        self._tell(violated)

    @override
    def catch_up(self, value: float, then_ns: int) -> None:
        if not self.low <= value <= self.high:
            self._take(value - self.limit if self._rises else self.limit - value, then_ns)
            self._spare(value)


class _SignalGroup:
    """The formulas that one signal can spare.

    Most values of the signal decide nothing: of those, only the lowest and the highest are kept,
    with the first instants at which the signal had them.

    Attributes:
        low: From here to `high` are the values of the signal with which no member is evaluated.
        lowest: From here to `highest` are those of which nothing need be kept.
        due_ns: From this instant on, the members are asked whatever the value.
    """

    def __init__(self, read: Callable[[], Any]) -> None:
        self.read = read
        self.members: list[_Guarded] = []
        self.low, self.high = math.inf, -math.inf
        self.lowest, self.highest = -math.inf, math.inf
        self._lowest_ns = self._highest_ns = -1
        self.due_ns = 0

    def keep(self, value: float, now_ns: int, violated: list[int]) -> None:
        """Keep a value beyond those that were kept; evaluate where it is too near to them."""
        if value < self.lowest - LEAST_CHANGE:
            self.lowest, self._lowest_ns = value, now_ns
        elif value > self.highest + LEAST_CHANGE:
            self.highest, self._highest_ns = value, now_ns
        else:
            self.step(value, now_ns, violated)

    def catch_up(self) -> None:
        """Have the members take what was kept for them."""
        for value, then_ns, keeps_high in (
            (self.lowest, self._lowest_ns, True),
            (self.highest, self._highest_ns, False),
        ):
            if then_ns >= 0:
                for one in self.members:
                    if one.keeps_high is keeps_high:
                        one.catch_up(value, then_ns)
        self._lowest_ns = self._highest_ns = -1

    def step(self, value: Any, now_ns: int, violated: list[int]) -> None:
        """Evaluate those members that the value may change, None for a signal without a value."""
        self.catch_up()
        for one in tuple(self.members):
            root = one.root
            if value is None or not one.low <= value <= one.high or now_ns >= root.due_ns:
                one.look(value, now_ns, violated)
                if root.is_settled:
                    self.members.remove(one)
        self._narrow()

    def _narrow(self) -> None:
        """Learn from the members with which values they need not be asked."""
        self.low, self.high = -MOST_WAITING, MOST_WAITING
        self.lowest, self.highest, self.due_ns = -math.inf, math.inf, NEVER
        for one in self.members:
            low, high = one.may_wait
            self.low, self.high = max(self.low, low), min(self.high, high)
            self.lowest, self.highest = max(self.lowest, one.low), min(self.highest, one.high)
            self.due_ns = min(self.due_ns, one.root.due_ns)


class WatchedRoots:
    """Formulas by their numbers, evaluated together."""

    def __init__(self, roots: Mapping[int, Root]) -> None:
        self._groups: list[_SignalGroup] = []
        self._others: list[_Watched] = []
        groups: dict[Callable[[], Any], _SignalGroup] = {}
        for number, root in roots.items():
            guard = root.guard
            if guard is None or guard.of is None:
                self._others.append(_Watched(number, root))
                continue
            group = groups.setdefault(guard.of.read, _SignalGroup(guard.of.read))
            keeps_high = guard.of.rises is root.is_spared_above
            if guard.of.limit is not None and isinstance(root, Steady) and root.is_from_start:
                one: _Guarded = _Compared(number, root, guard.of, keeps_high=keeps_high)
            else:
                one = _Guarded(number, root, keeps_high=keeps_high)
            group.members.append(one)
        self._groups = list(groups.values())

    def step(self, now_ns: int) -> list[int]:
        """Take the next instant; return the numbers of those that are violated since this one."""
        violated: list[int] = []
        is_settled = False
        for one in self._others:
            one.step(now_ns, violated)
            is_settled = is_settled or one.root.is_settled
        if is_settled:
            self._others = [one for one in self._others if not one.root.is_settled]
        for group in self._groups:
            value = group.read()
            if value is None or not group.low <= value <= group.high or now_ns >= group.due_ns:
                group.step(value, now_ns, violated)
                if not group.members:
                    is_settled = True
            elif not group.lowest <= value <= group.highest:
                group.keep(value, now_ns, violated)
        if is_settled:
            self._groups = [group for group in self._groups if group.members]
        violated.sort()
        return violated

    def catch_up(self) -> None:
        """Have all come to what they would have, evaluated at every instant."""
        for group in self._groups:
            group.catch_up()

    def clear(self) -> None:
        """Evaluate none any more."""
        self.catch_up()
        self._groups.clear()
        self._others.clear()
