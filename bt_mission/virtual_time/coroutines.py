"""What an executor has begun and not ended: tasks, and callbacks that await something."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any
from weakref import WeakSet

from rclpy.node import Node
from rclpy.task import Task

from bt_mission.virtual_time.taps import PendingCallback


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
        self._waiting: list[Task] = []
        self._callbacks: list[tuple[Any, Any, Node | None]] = []
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
        return self._resume_tasks() or self._resume_callbacks() or bool(self._new)

    def _resume_tasks(self) -> bool:
        if not (self._waiting or self._new):
            return False
        turns = deque(self._waiting + self._new)
        self._waiting, self._new = [], []
        ended = False
        try:
            while turns:
                task = turns.popleft()
                self.turns += 1
                task()
                if task.done():
                    ended = True
                    task.result()  # raises what the task raised
                elif not task.cancelled():
                    self._waiting.append(task)
        finally:
            self._waiting.extend(turns)
        return ended

    def _resume_callbacks(self) -> bool:
        if not self._callbacks:
            return False
        turns = deque(self._callbacks)
        self._callbacks = []
        ended = False
        try:
            while turns:
                coroutine, entity, node = turns.popleft()
                if node in self._away:
                    self._callbacks.append((coroutine, entity, node))
                    continue
                try:
                    coroutine.send(None)
                except BaseException as end:
                    entity.callback_group.ending_execution(entity)
                    if not isinstance(end, StopIteration):
                        raise
                    ended = True
                else:
                    self._callbacks.append((coroutine, entity, node))
        finally:
            self._callbacks.extend(turns)
        return ended
