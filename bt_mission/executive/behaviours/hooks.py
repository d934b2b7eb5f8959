"""The bases of all behaviours: hooks for debuggers and tests, and the way decorators tick."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from bt_mission.executive.behaviours.evaluator import Evaluator

StartHook = Callable[[Behaviour], Iterator[Behaviour]]
"""Yields marks in a tick just before a node starts."""

ENDED = (Status.SUCCESS, Status.FAILURE)

CallHook = Callable[[str], Status | None]
"""Called before ``initialise``, ``update`` or ``terminate``, with the method's name.

A status that it returns for ``update`` replaces the call."""


class Hooked(Behaviour):
    """A node that can be stopped before it starts; the first base of each class of nodes.

    A subclass that is ticked in another way overrides :meth:`walk`, not ``tick``.
    """

    start_hook: StartHook | None = None
    call_hooks: tuple[CallHook, ...] = ()
    """Hooks of a leaf: called before its ``initialise``, ``update`` and ``terminate``."""
    resets: list[Behaviour] | None = None
    """Takes this node whenever it had ended and is reset."""

    _values: Evaluator

    @property
    def _node(self) -> Any:
        """The node in its current version: it may be revised while the mission runs."""
        return self._values.node

    def take_values(self, values: Evaluator) -> None:
        """Read the values of a revised mission from now on."""
        self._values = values

    def remove_call_hook(self, hook: CallHook) -> None:
        """Call a hook no more."""
        self.call_hooks = tuple(kept for kept in self.call_hooks if kept is not hook)

    def run_call_hooks(self, method: str) -> Status | None:
        """Call the call hooks with the name of the next method; return the last status of them."""
        status = None
        for hook in self.call_hooks:
            status = hook(method) or status
        return status

    def tick(self) -> Iterator[Behaviour]:
        """Return the walk of one tick."""
        return self.walk() if self.start_hook is None else self._hooked_walk(self.start_hook)

    def walk(self) -> Iterator[Behaviour]:
        """Tick the nodes below, then this node; yield each node visited."""
        return super().tick()

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status, or be halted or reset (INVALID)."""
        self.note_reset(new_status)
        super().stop(new_status)

    def note_reset(self, new_status: Status) -> None:
        """Note that this node had ended and is reset; a ``stop`` of a subclass calls it first."""
        is_reset = new_status is Status.INVALID and self.status in ENDED
        if is_reset and self.resets is not None:
            self.resets.append(self)

    def _hooked_walk(self, hook: StartHook) -> Iterator[Behaviour]:
        if self.status is not Status.RUNNING:
            yield from hook(self)
        yield from self.walk()


class HookedDecorator(Hooked, Decorator):
    """A decorator that ticks as py_trees' own do, without a line for a log that nobody reads."""

    def __init__(self, node: Any, values: Evaluator, **more: Any) -> None:
        super().__init__(node.label, values.children[0], **more)
        self._values = values

    def enter(self) -> Status | None:
        """Decide before the child is ticked. Return a status to take instead, or None."""
        if self.status is not Status.RUNNING:
            self.initialise()
        return None

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """End with this status; halt a child that runs, and reset it if this node is reset."""
        self.note_reset(new_status)
        self.terminate(new_status)
        if new_status is Status.INVALID or self.decorated.status is Status.RUNNING:
            self.decorated.stop(Status.INVALID)
        self.status = new_status

    def walk(self) -> Iterator[Behaviour]:
        """Tick the child and update, unless the node decides otherwise; stop if it has ended."""
        status = self.enter()
        if status is None:
            yield from self.decorated.tick()
            status = self.update()
        if status is not Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self
