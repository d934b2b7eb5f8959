"""Control flow beyond py_trees' own: parallels that say what becomes of the rest, and choices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Composite

from bt_mission.behaviours.hooks import Hooked, HookedDecorator
from bt_mission.behaviours.runtime import Runtime
from bt_mission.core.stamps import NS


@dataclass(frozen=True)
class ConditionResult:
    """What a condition said: whether it holds, and in words, with the values it read."""

    holds: bool
    text: str


Question = Callable[[], ConditionResult]


@dataclass(frozen=True)
class Rounds:
    """What ends a loop.

    Args:
        count: Gives the number of rounds; with a condition, the most of them.
        before: Is asked before each round; it goes on while that holds.
        after: Is asked after each round; it ends once that holds.
    """

    count: Callable[[], int] | None
    before: Question | None = None
    after: Question | None = None

    @property
    def has_condition(self) -> bool:
        """Whether more than a count ends it."""
        return self.before is not None or self.after is not None


class Parallel(Hooked, py_trees.composites.Parallel):
    """Ticks all children at once; those that have ended are not ticked again.

    Args:
        needed: The children whose success is success; None means that any one is enough.
        fail_fast: Fail when any child has; else only once success is out of reach.
        finish: Let the others run to their own end once it is decided, instead of halting them.
    """

    def __init__(
        self,
        name: str,
        children: list[Behaviour],
        needed: Sequence[int] | None,
        *,
        fail_fast: bool = True,
        finish: bool = False,
    ) -> None:
        super().__init__(name, ParallelPolicy.SuccessOnAll(synchronise=True), children)
        self._needed = None if needed is None else [children[index] for index in needed]
        self._fail_fast = fail_fast
        self._finish = finish
        self._decided = Status.RUNNING

    @property
    def policy_name(self) -> str:
        """Whose success is needed, in py_trees' words: OnAll, OnOne, or OnSelected with indices."""
        if self._needed is None:
            return "OnOne"
        needed = [str(index) for index, child in enumerate(self.children) if child in self._needed]
        return "OnAll" if len(needed) == len(self.children) else f"OnSelected({', '.join(needed)})"

    def walk(self) -> Iterator[Behaviour]:
        """Tick what has not ended; decide; end when the rest may be left."""
        running, invalid = Status.RUNNING, Status.INVALID
        if self.status is not running:
            self._begin()
        still = []
        for child in self.children:
            if child.status is running or child.status is invalid:
                yield from child.tick()
                if child.status is running:
                    still.append(child)
        if self._decided is running:
            self.current_child = self.children[-1]
            if len(still) < len(self.children):
                self._decided, self.current_child = self._decide()
        self.feedback_message = ""
        if self._decided is not running and not (self._finish and still):
            self.stop(self._decided)
        else:
            self.status = running
            if self._decided is not running:
                names = ", ".join(f"'{child.name}'" for child in still)
                self.feedback_message = f"{self._decided.value.lower()}, once {names} has finished"
        yield self

    def _begin(self) -> None:
        self._decided = Status.RUNNING
        for child in self.children:
            if child.status is not Status.INVALID:
                child.stop(Status.INVALID)
        self.initialise()

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """Whether it is decided already, and the rest only finishes."""
        return {"decided": self._decided.value}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Go on with those that have not ended."""
        self._decided = Status(state["decided"])

    def _decide(self) -> tuple[Status, Behaviour]:
        done = [child for child in self.children if child.status is Status.SUCCESS]
        failed = [child for child in self.children if child.status is Status.FAILURE]
        if failed and self._fail_fast:
            return Status.FAILURE, failed[0]
        if self._needed is None:
            if done:
                return Status.SUCCESS, done[0]
            if len(failed) == len(self.children):
                return Status.FAILURE, failed[-1]
        elif all(child.status is Status.SUCCESS for child in self._needed):
            return Status.SUCCESS, self._needed[-1]
        elif lost := [child for child in self._needed if child.status is Status.FAILURE]:
            return Status.FAILURE, lost[0]
        return Status.RUNNING, self.children[-1]


class Pick(Hooked, Composite):
    """Runs the one child that is picked at entry; succeeds where none is.

    Args:
        pick: Gives the index of a child and a text that says why; an index beyond the last child
            means none.
    """

    def __init__(
        self, name: str, children: list[Behaviour], pick: Callable[[], tuple[int, str]]
    ) -> None:
        super().__init__(name, children)
        self._pick = pick

    def walk(self) -> Iterator[Behaviour]:
        """Pick at entry, then tick that child."""
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
            index, self.feedback_message = self._pick()
            self.current_child = self.children[index] if index < len(self.children) else None
        status = Status.SUCCESS
        if self.current_child is not None:
            yield from self.current_child.tick()
            status = self.current_child.status
        if status is Status.RUNNING:
            self.status = status
        else:
            self.stop(status)
        yield self


class Guard(HookedDecorator):
    """Ticks its child as long as a condition holds; then halts it and fails."""

    def __init__(self, name: str, child: Behaviour, question: Question) -> None:
        super().__init__(name, child)
        self._question = question

    def walk(self) -> Iterator[Behaviour]:
        """Ask, and tick the child only if the answer is yes."""
        verdict = self._question()
        self.feedback_message = verdict.text
        if verdict.holds:
            yield from super().walk()
            return
        self.stop(Status.FAILURE)
        yield self

    def why_over(self) -> str:
        """Return why the child may run no more, as of now; empty where it may."""
        verdict = self._question()
        return "" if verdict.holds else f"'{self.name}': {verdict.text}"

    def update(self) -> Status:
        """End as the child does."""
        return self.decorated.status


class Timeout(HookedDecorator):
    """Halts its child, and fails, when it still runs after some seconds of ROS time.

    A child that ends on the very tick of its deadline has ended.
    """

    def __init__(self, name: str, child: Behaviour, seconds: Callable[[], float]) -> None:
        super().__init__(name, child)
        self._seconds = seconds
        self._limit_s = 0.0
        self._until_ns = 0
        self._runtime: Runtime

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]

    def initialise(self) -> None:
        """Fix the deadline."""
        self._limit_s = self._seconds()
        self._until_ns = self._runtime.now_ns + round(self._limit_s * NS)

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """How much time is left, and how much there was."""
        return {"left_ns": self._until_ns - now_ns, "limit_s": self._limit_s}

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Have as much time as was left."""
        self._until_ns, self._limit_s = now_ns + state["left_ns"], state["limit_s"]

    def why_over(self) -> str:
        """Return why the child may run no more, as of now; empty where it may."""
        is_over = self._runtime.now_ns >= self._until_ns
        return f"'{self.name}': not done within {self._limit_s:g} s" if is_over else ""

    def update(self) -> Status:
        """Look at the ROS clock after the child was ticked."""
        left_s = (self._until_ns - self._runtime.now_ns) / NS
        self.feedback_message = ""
        if self.decorated.status is not Status.RUNNING:
            return self.decorated.status
        if left_s > 0:
            self.feedback_message = f"{left_s:.1f} s left"
            return Status.RUNNING
        self.feedback_message = f"not done within {self._limit_s:g} s"
        return Status.FAILURE


class ForEach(HookedDecorator):
    """Runs its child once for each element of a list, in order; fails as soon as the child fails.

    Args:
        elements: Gives the list at entry.
        take: Called with each element before the child runs for it.
        leave: Called when it has ended or was halted.
    """

    def __init__(
        self,
        name: str,
        child: Behaviour,
        elements: Callable[[], Sequence[Any]],
        take: Callable[[Any], None],
        leave: Callable[[], None],
    ) -> None:
        super().__init__(name, child)
        self._read = elements
        self._take = take
        self._leave = leave
        self._elements: Sequence[Any] = ()
        self._index = 0

    def walk(self) -> Iterator[Behaviour]:
        """Read the list at entry; an empty one succeeds at once."""
        if self.status != Status.RUNNING:
            self._elements, self._index = self._read(), 0
            if not self._elements:
                self.decorated.stop(Status.INVALID)
                self.feedback_message = "0 of 0"
                self.stop(Status.SUCCESS)
                yield self
                return
        self._take(self._elements[self._index])
        yield from super().walk()

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """The list, and how far it has come."""
        return {"elements": list(self._elements), "index": self._index}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Go on with the same element."""
        self._elements, self._index = state["elements"], state["index"]

    def update(self) -> Status:
        """Go on to the next element when the child has succeeded."""
        count = len(self._elements)
        self.feedback_message = f"{self._index + 1} of {count}"
        if self.decorated.status is not Status.SUCCESS:
            return self.decorated.status
        self._index += 1
        return Status.SUCCESS if self._index == count else Status.RUNNING

    def terminate(self, _new_status: Status) -> None:
        """Take the variable away."""
        self._leave()
