"""What every node of a mission offers to those who debug or test it: hooks, and none by default."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

StartHook = Callable[[Behaviour], Iterator[Behaviour]]
"""What comes out of a tick just before a node starts."""

CallHook = Callable[[str], None]
"""Told of a call of ``initialise``, ``update`` or ``terminate`` before it is made."""


class Hooked(Behaviour):
    """A node that can be stopped before it starts; the first base of each class of nodes.

    A subclass with a way of its own to be ticked overrides :meth:`walk`, not ``tick``.
    """

    start_hook: StartHook | None = None
    call_hooks: tuple[CallHook, ...] = ()
    """Of a leaf: called before its own ``initialise``, ``update`` and ``terminate``."""

    def remove_call_hook(self, hook: CallHook) -> None:
        """Call a hook no more."""
        self.call_hooks = tuple(one for one in self.call_hooks if one is not hook)

    def tell_call_hooks(self, method: str) -> None:
        """Tell the call hooks which method is called next."""
        for hook in self.call_hooks:
            hook(method)

    def tick(self) -> Iterator[Behaviour]:
        """Return the walk of one tick."""
        return self.walk() if self.start_hook is None else self._hooked_walk(self.start_hook)

    def walk(self) -> Iterator[Behaviour]:
        """Tick what is below, then this node; yield each node visited."""
        return super().tick()

    def _hooked_walk(self, hook: StartHook) -> Iterator[Behaviour]:
        if self.status is not Status.RUNNING:
            yield from hook(self)
        yield from self.walk()


class Sequence(Hooked, py_trees.composites.Sequence):
    """The sequence of py_trees."""

    walk = py_trees.composites.Sequence.tick


class Selector(Hooked, py_trees.composites.Selector):
    """The selector of py_trees."""

    walk = py_trees.composites.Selector.tick


class HookedDecorator(Hooked, Decorator):
    """A decorator that ticks as py_trees' own do, without a line for a log that nobody reads."""

    def walk(self) -> Iterator[Behaviour]:
        """Begin, if it does not run; tick the child; update; stop, if it has ended."""
        if self.status is not Status.RUNNING:
            self.initialise()
        yield from self.decorated.tick()
        status = self.update()
        if status is not Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self


class Inverter(HookedDecorator, py_trees.decorators.Inverter):
    """The inverter of py_trees."""


class FailureIsSuccess(HookedDecorator, py_trees.decorators.FailureIsSuccess):
    """The decorator of py_trees."""


class SuccessIsFailure(HookedDecorator, py_trees.decorators.SuccessIsFailure):
    """The decorator of py_trees."""
