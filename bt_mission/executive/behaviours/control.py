"""Composites, choices, and the decorators that limit their child or repeat it over a list."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Composite

from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.evaluator import Evaluator
from bt_mission.executive.behaviours.hooks import Hooked, HookedDecorator
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.language.expressions.values import show
from bt_mission.language.nodes.composites import FallbackNode, ParallelNode, SequenceNode
from bt_mission.language.nodes.decorators import ForEachNode
from bt_mission.language.nodes.fields import LIMIT


class _InOrder(Hooked, Composite):
    """Ticks its children in order. It ticks and stops as in py_trees, without lines for a log."""

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status; reset the children of a node that is reset or halted."""
        self.note_reset(new_status)
        if new_status is Status.INVALID:
            self.current_child = None
            self._reset(self.children)
        self.status = new_status

    def _reset(self, children: Iterable[Behaviour]) -> None:
        invalid = Status.INVALID
        for child in children:
            if child.status is not invalid:
                child.stop(invalid)


class Sequence(_InOrder, py_trees.composites.Sequence):
    """The sequence of py_trees.

    With memory it succeeds if it runs and has no current child: a revision removed the rest.
    """

    def __init__(self, node: SequenceNode, values: Evaluator) -> None:
        super().__init__(node.label, node.memory, values.children)

    def walk(self) -> Iterator[Behaviour]:
        """Tick the children from the present one on, as long as they succeed."""
        children, success, first = self.children, Status.SUCCESS, 0
        if self.status is not Status.RUNNING:
            self._reset(children)
        elif self.memory:
            present = self.current_child
            first = len(children) if present is None else children.index(present)
        for index in range(first, len(children)):
            child = self.current_child = children[index]
            yield from child.tick()
            status = child.status
            if status is not success:
                if not self.memory:
                    self._reset(children[index + 1 :])
                if status is Status.RUNNING:
                    self.status = status
                else:
                    self.stop(status)
                yield self
                return
        self.stop(success)
        yield self


class Selector(_InOrder, py_trees.composites.Selector):
    """The selector of py_trees.

    With memory it fails if it runs and has no current child: a revision removed the rest.
    """

    def __init__(self, node: FallbackNode, values: Evaluator) -> None:
        super().__init__(node.label, node.memory, values.children)

    def walk(self) -> Iterator[Behaviour]:
        """Tick the children from the present one on, until one does not fail."""
        children, failure, first = self.children, Status.FAILURE, 0
        if self.status is not Status.RUNNING:
            self.current_child = children[0] if children else None
        before = self.current_child
        if self.memory and before is not None:
            first = children.index(before)
            self._reset(children[:first])
        elif self.memory:
            children = []
        for index in range(first, len(children)):
            child = children[index]
            yield from child.tick()
            status = child.status
            if status is not failure:
                self.current_child = child
                if child is not before:
                    self._reset(children[index + 1 :])
                if status is Status.RUNNING:
                    self.status = status
                else:
                    self.stop(status)
                yield self
                return
        self.stop(failure)
        self.current_child = children[-1] if children else None
        yield self


class Parallel(Hooked, py_trees.composites.Parallel):
    """Ticks all children at once; those that have ended are not ticked again."""

    def __init__(self, node: ParallelNode, values: Evaluator) -> None:
        children, needed = values.children, node.needed
        super().__init__(node.label, ParallelPolicy.SuccessOnAll(synchronise=True), children)
        self._needed = None if needed is None else [children[index] for index in needed]
        self._fails_fast = node.fail_when == "any"
        self._finishes = node.rest == "finish"
        self._decided = Status.RUNNING

    def walk(self) -> Iterator[Behaviour]:
        """Tick the children that have not ended; decide; end when the others may be halted."""
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
        if self._decided is not running and not (self._finishes and still):
            self.stop(self._decided)
        else:
            self.status = running
            if self._decided is not running:
                names = ", ".join(f"'{child.name}'" for child in still)
                self.feedback_message = f"{self._decided.value.lower()}, once {names} has finished"
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status; halt the children that run, and reset all if it is reset."""
        self.note_reset(new_status)
        running, invalid = Status.RUNNING, Status.INVALID
        for child in self.children:
            if child.status is running or (new_status is invalid and child.status is not invalid):
                child.stop(invalid)
        if new_status is invalid:
            self.current_child = None
        self.status = new_status

    def _begin(self) -> None:
        self._decided = Status.RUNNING
        for child in self.children:
            if child.status is not Status.INVALID:
                child.stop(Status.INVALID)
        self.initialise()

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """Return whether the result is decided, and the other children only finish."""
        return {"decided": self._decided.value}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Continue with the children that have not ended."""
        self._decided = Status(state["decided"])

    def _decide(self) -> tuple[Status, Behaviour]:
        done = [child for child in self.children if child.status is Status.SUCCESS]
        failed = [child for child in self.children if child.status is Status.FAILURE]
        if failed and self._fails_fast:
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
    """Runs the child that is picked at entry; succeeds if there is no such child."""

    def __init__(self, node: Any, values: Evaluator) -> None:
        super().__init__(node.label, values.children)
        self._values = values

    def pick(self) -> tuple[int, str]:
        """Return the index of a child, and the reason.

        An index beyond the last child picks none.
        """
        raise NotImplementedError

    def walk(self) -> Iterator[Behaviour]:
        """Pick at entry, then tick that child."""
        if self.status != Status.RUNNING:
            for child in self.children:
                if child.status != Status.INVALID:
                    child.stop(Status.INVALID)
            index, self.feedback_message = self.pick()
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


class Choose(Pick):
    """Picks a child at random, by the weights of the node."""

    def pick(self) -> tuple[int, str]:
        """Draw."""
        values, count = self._values, len(self.children)
        random = values.scope.random(values.path)
        (index,) = random.choices(range(count), weights=self._node.weights or None)
        return index, f"drew {index + 1} of {count}"


class When(Pick):
    """Picks the first child where a condition holds, else the second."""

    def pick(self) -> tuple[int, str]:
        """Return 0 or 1 by the condition, and the reason."""
        result = self._values.ask(self._node.condition)
        return 0 if result.holds else 1, result.text


class Guard(HookedDecorator):
    """Ticks its child while a condition is true; then halts it and fails."""

    def enter(self) -> Status | None:
        """Evaluate the condition, and tick the child only if it is true."""
        result = self._values.ask(self._node.condition)
        self.feedback_message = result.text
        return super().enter() if result.holds else Status.FAILURE

    def why_over(self) -> str:
        """Return why the child must end now; empty if it may run."""
        result = self._values.ask(self._node.condition)
        return "" if result.holds else f"'{self.name}': {result.text}"

    def update(self) -> Status:
        """End as the child does."""
        return self.decorated.status


class Timeout(HookedDecorator):
    """Halts its child, and fails, when it still runs after some seconds of ROS time.

    A child that ends on the very tick of its deadline has ended.
    """

    _limit_s = 0.0
    due_ns = 0
    """The instant at which its child is halted."""
    _runtime: Runtime

    def setup(self, **kwargs: Any) -> None:
        """Take the runtime."""
        self._runtime = kwargs["runtime"]

    def initialise(self) -> None:
        """Fix the deadline."""
        self._limit_s = self._values.number(self._node.seconds, LIMIT)
        self.due_ns = self._runtime.now_ns + round(self._limit_s * NS)

    def save_state(self, now_ns: int) -> dict[str, Any]:
        """Return the remaining time and the whole time."""
        return {"left_ns": self.due_ns - now_ns, "limit_s": self._limit_s}

    def restore_state(self, state: dict[str, Any], now_ns: int) -> None:
        """Restore the remaining time."""
        self.due_ns, self._limit_s = now_ns + state["left_ns"], state["limit_s"]

    def why_over(self) -> str:
        """Return why the child must end now; empty if it may run."""
        is_over = self._runtime.now_ns >= self.due_ns
        return f"'{self.name}': not done within {self._limit_s:g} s" if is_over else ""

    def read_again(self) -> None:
        """Take the limit of a new version of the node; the time so far counts."""
        started_ns = self.due_ns - round(self._limit_s * NS)
        self._limit_s = self._values.number(self._node.seconds, LIMIT)
        self.due_ns = started_ns + round(self._limit_s * NS)

    def update(self) -> Status:
        """Look at the ROS clock after the child was ticked."""
        left_s = (self.due_ns - self._runtime.now_ns) / NS
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

    Its variable has no value once the node has ended or was halted.
    """

    def __init__(self, node: ForEachNode, values: Evaluator) -> None:
        super().__init__(node, values)
        self._variable = node.variable
        self._elements: list[Any] = []
        self._index = 0

    def enter(self) -> Status | None:
        """Read the list at entry; an empty one succeeds at once."""
        if self.status is not Status.RUNNING:
            elements, self._index = self._values.resolve(self._node.elements), 0
            if not isinstance(elements, list):
                raise self._values.failure(f"expected a list, got {show(elements)}")
            self._elements = elements
            if not self._elements:
                self.decorated.stop(Status.INVALID)
                self.feedback_message = "0 of 0"
                return Status.SUCCESS
        self._values.scope.values[self._variable] = self._elements[self._index]
        return super().enter()

    def save_state(self, _now_ns: int) -> dict[str, Any]:
        """Return the list and the index of the current element."""
        return {"elements": list(self._elements), "index": self._index}

    def restore_state(self, state: dict[str, Any], _now_ns: int) -> None:
        """Continue with the same element."""
        self._elements, self._index = state["elements"], state["index"]

    def update(self) -> Status:
        """Continue with the next element when the child has succeeded."""
        count = len(self._elements)
        self.feedback_message = f"{self._index + 1} of {count}"
        if self.decorated.status is not Status.SUCCESS:
            return self.decorated.status
        self._index += 1
        return Status.SUCCESS if self._index == count else Status.RUNNING

    def terminate(self, _new_status: Status) -> None:
        """Remove the variable's value."""
        self._values.scope.values.pop(self._variable, None)
