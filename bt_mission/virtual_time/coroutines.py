"""What an executor has begun and not ended: tasks, and callbacks that await something."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any, TypeVar
from weakref import WeakSet

from rclpy.node import Node
from rclpy.task import Task

from bt_mission.virtual_time.taps import PendingCallback

T = TypeVar("T")
_Callback = tuple[Any, Any, "Node | None"]
"""A coroutine, the entity that it serves, and the node of that."""


class Tasks:
    """Coroutines that each get a turn after every round of callbacks, in the order of their start.

    A callback that awaits something holds its callback group until it ends. It gets no turn while
    its node is away, that is, was removed from the executor and not added again; a task is of no
    node.
    """

    def __init__(self) -> None:
        self.turns = 0
        """Turns that tasks have had so far."""
        self._new: list[Task] = []
        self._tasks: list[Task] = []
        self._callbacks: list[_Callback] = []
        self._away: WeakSet[Node] = WeakSet()

    @property
    def hold_groups(self) -> bool:
        """May a callback group be held by a callback that awaits something?"""
        return bool(self._callbacks)

    def add(self, task: Task) -> None:
        """Run a task, from the next turn on."""
        self._new.append(task)

    def begin(self, rest: PendingCallback, entity: Any, node: Callable[[Any], Node | None]) -> None:
        """Run a callback's coroutine as far as it goes now, and the rest of it in turns.

        Args:
            node: Tells whose the entity is.
        """
        if rest is None:
            return
        try:
            rest.send(None)
        except StopIteration:
            return
        entity.callback_group.beginning_execution(entity)
        self._callbacks.append((rest, entity, node(entity)))

    def node_leaves(self, node: Node) -> None:
        """Leave the callbacks of a node where they are."""
        self._away.add(node)

    def node_comes(self, node: Node) -> None:
        """Go on with the callbacks of a node."""
        self._away.discard(node)

    def resume(self) -> bool:
        """Give each a turn; tells whether any of them ended, or has begun another.

        What one of them raises comes out of here; the others keep their place.
        """
        tasks, self._new = self._new, []
        self._tasks += tasks
        return (
            _give_turns(self._tasks, self._run_task)
            or _give_turns(self._callbacks, self._run_callback)
            or bool(self._new)
        )

    def _run_task(self, task: Task) -> bool | None:
        self.turns += 1
        task()
        if task.done():
            task.result()  # raises what the task raised
            return True
        return None if task.cancelled() else False

    def _run_callback(self, begun: _Callback) -> bool:
        coroutine, entity, node = begun
        if node in self._away:
            return False
        try:
            coroutine.send(None)
        except BaseException as end:
            entity.callback_group.ending_execution(entity)
            if not isinstance(end, StopIteration):
                raise
            return True
        return False


def _give_turns(begun: list[T], run: Callable[[T], bool | None]) -> bool:
    """Run each a little; keep those that go on (False), also where one raises.

    Returns:
        Whether any has ended (True). One that was cancelled (None) is dropped.
    """
    if not begun:
        return False
    turns = deque(begun)
    begun.clear()
    has_ended = False
    try:
        while turns:
            one = turns.popleft()
            ended = run(one)
            if ended is False:
                begun.append(one)
            has_ended = has_ended or ended is True
    finally:
        begun.extend(turns)
    return has_ended
