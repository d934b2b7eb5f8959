"""Tasks and suspended callbacks of an executor."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Coroutine, Iterator
from dataclasses import dataclass
from types import CoroutineType, GeneratorType
from typing import Any
from weakref import WeakSet

from rclpy import task as rclpy_task
from rclpy.node import Node
from rclpy.task import Future, Task

_PENDING = getattr(getattr(rclpy_task, "FutureState", None), "PENDING", None)
"""The state of a future that is pending; None if this rclpy stores it otherwise."""


def _is_pending(future: Future) -> bool:
    """Return whether a future is pending, for an rclpy whose futures have no state."""
    return not (future.done() or future.cancelled())


@dataclass(eq=False)
class _Begun:
    """A coroutine that gets turns.

    Most coroutines await a future for many turns. That future is kept, so that no turn is spent on
    checking it.
    """

    coroutine: Any = None
    """Of a callback."""
    task: Task | None = None
    entity: Any = None
    """The entity that the callback serves."""
    node: Node | None = None
    """Whose the entity is."""
    awaited: Future | None = None
    """The future at which the last turn ended, if it is known."""

    @property
    def is_stuck(self) -> bool:
        """Whether a turn would not advance it."""
        awaited, task = self.awaited, self.task
        if awaited is None:
            return False
        if _PENDING is None:
            return _is_pending(awaited) and (task is None or _is_pending(task))
        return awaited._state is _PENDING and (task is None or task._state is _PENDING)


class Tasks:
    """Coroutines that each get a turn after every round of callbacks, in the order of their start.

    A callback that awaits something holds its callback group until it ends. It gets no turn while
    its node is removed from the executor. A task belongs to no node.
    """

    def __init__(self) -> None:
        self.turns = 0
        """Turns that tasks have had so far."""
        self._new: list[Task] = []
        self._tasks: list[_Begun] = []
        self.holding: list[_Begun] = []
        """Callbacks that await something, and hold their callback groups."""
        self._away: WeakSet[Node] = WeakSet()

    @property
    def can_go_on(self) -> bool:
        """Return whether a task can advance."""
        return bool(self._new) or any(
            task.awaited is not None and not task.is_stuck for task in self._present()
        )

    @property
    def await_the_unknown(self) -> bool:
        """Return whether a coroutine awaits something other than a future: nothing reports that."""
        return any(task.awaited is None for task in self._present())

    def _present(self) -> Iterator[_Begun]:
        for task in (*self._tasks, *self.holding):
            if task.node not in self._away:
                yield task

    def add(self, task: Task) -> None:
        """Run a task, from the next turn on."""
        self._new.append(task)

    def begin(
        self, rest: Coroutine[Any, Any, None], entity: Any, node: Callable[[Any], Node | None]
    ) -> None:
        """Run a callback's coroutine up to its first wait, and the rest of it in turns.

        Args:
            node: Returns the node of an entity.
        """
        try:
            rest.send(None)
        except StopIteration:
            return
        entity.callback_group.beginning_execution(entity)
        begun = _Begun(rest, None, entity, node(entity), awaited_by(rest))
        self.holding.append(begun)

    def node_leaves(self, node: Node) -> None:
        """Leave the callbacks of a node where they are."""
        self._away.add(node)

    def node_comes(self, node: Node) -> None:
        """Resume the callbacks of a node that was added again."""
        self._away.discard(node)

    def resume(self) -> bool:
        """Give each a turn. Return whether any of them ended, or has begun another.

        An exception of a coroutine is raised here; the others keep their place.
        """
        if self._new:
            self._tasks += [_Begun(task=task) for task in self._new]
            self._new = []
        for begun in (*self._tasks, *self.holding):
            awaited, task = begun.awaited, begun.task
            # As `is_stuck`, without a call: it runs several times at every instant.
            if awaited is None or _PENDING is None or awaited._state is not _PENDING:
                break
            if task is not None and task._state is not _PENDING:
                break
        else:
            return False
        has_ended = _give_turns(self._tasks, self._run_task)
        return has_ended or _give_turns(self.holding, self._run_callback) or bool(self._new)

    def _run_task(self, begun: _Begun) -> bool | None:
        task = begun.task
        assert task is not None, "callbacks are run by another method"
        self.turns += 1
        task()
        if task.done():
            task.result()  # raises what the task raised
            return True
        if task.cancelled():
            return None
        begun.awaited = awaited_by(task._handler)
        return False

    def _run_callback(self, begun: _Begun) -> bool:
        if begun.node in self._away:
            return False
        try:
            begun.coroutine.send(None)
        except BaseException as end:
            begun.entity.callback_group.ending_execution(begun.entity)
            if not isinstance(end, StopIteration):
                raise
            return True
        begun.awaited = awaited_by(begun.coroutine)
        return False


def awaited_by(coroutine: Any) -> Future | None:
    """Return the future that a suspended coroutine awaits; None if it awaits something else."""
    inner = coroutine
    while isinstance(inner, CoroutineType):
        inner = inner.cr_await
    if isinstance(inner, GeneratorType) and inner.gi_code is Future.__await__.__code__:
        frame: Any = inner.gi_frame
        future: Future = frame.f_locals["self"]
        return future
    return None


def _give_turns(begun: list[_Begun], run: Callable[[_Begun], bool | None]) -> bool:
    """Give each a turn; keep those that have not ended (False), also if one raises.

    Returns:
        Whether any has ended (True). A cancelled one (None) is dropped.
    """
    turns = deque(begun)
    begun.clear()
    has_ended = False
    try:
        while turns:
            task = turns.popleft()
            ended = not task.is_stuck and run(task)
            if ended is False:
                begun.append(task)
            has_ended = has_ended or ended is True
    finally:
        begun.extend(turns)
    return has_ended
