"""The state of the real objects of a running mission, taken and put back in place.

Objects stay the same, so that whatever refers to them remains true: closures, listeners, lists
that two objects share. A memento holds only the attributes that have ever changed, and shares
equal parts with the one before. Only the objects that a step may have changed are compared and
put back.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from operator import is_, itemgetter
from typing import Any, NamedTuple, TypeAlias

_CONTAINERS = frozenset({list, dict, set, deque})

_FIXED = frozenset(
    (
        *("children", "blackboards", "resets", "indices", "_paths", "evaluators"),
        *("tick_wrappers", "needs_physics", "_monitors", "_read", "_ended"),
    )
)
"""Attributes with containers that no step changes, or that belong to another object."""

_ABSENT: Any = object()
"""In place of the value of an attribute that an object does not have."""

_Values: TypeAlias = tuple[Any, ...]
"""The values of attributes; in place of a container, a `_Held`."""


class _Held(NamedTuple):
    """A container with what it held.

    Attributes:
        contents: Its entries; of a dict its keys and its values, nothing if it was empty.
    """

    container: Any
    contents: tuple[Any, ...]


class _Special(tuple[Any, ...]):
    """Values with a container, or with an attribute that is absent, among them."""

    __slots__ = ()


_Whole: TypeAlias = tuple[Any, dict[str, Any], tuple[_Held, ...]]


class Memento(NamedTuple):
    """The saved attributes of each object; it keeps the objects alive.

    Attributes:
        lasting: Of those that are always there, in their order.
        dynamic: Of those that come and go: the object, its attributes, and the containers among
            them, by its `id`.
    """

    lasting: list[_Values]
    dynamic: dict[int, _Whole]


class _Kept:
    """An object with the attributes that have ever changed.

    Attributes:
        entry: The object.
    """

    __slots__ = ("_count", "_first", "_fixed", "_fixed_of", "_names", "_varying_of", "entry")

    def __init__(self, entry: Any) -> None:
        self.entry = entry
        self._fixed: dict[str, Any] = entry.__dict__.copy()
        self._names: list[str] = []
        self._first: list[Any] = []
        self._learn(
            [
                name
                for name, value in self._fixed.items()
                if type(value) in _CONTAINERS and name not in _FIXED
            ]
        )

    def _learn(self, names: Iterable[str]) -> None:
        """Note attributes that may change from now on."""
        for name in names:
            self._names.append(name)
            self._first.append(self._fixed.pop(name, _ABSENT))
        self._count = len(self._fixed) + len(self._names)
        self._fixed_of = tuple(self._fixed.values()), _getter(self._fixed)
        self._varying_of = _getter(self._names)

    def look(self) -> None:
        """Note the attributes that have changed for the first time, after a step."""
        now = self.entry.__dict__
        values, getter = self._fixed_of
        try:
            self._varying_of(now)
            if len(now) == self._count and getter(now) == values:
                return
        except KeyError:
            pass  # another attribute may have come in place of one that is absent
        fixed, names = self._fixed, self._names
        self._learn(
            [
                name
                for name, value in now.items()
                if name not in names and (name not in fixed or fixed[name] is not value)
            ]
        )

    def save(self, known: _Values | None) -> _Values:
        """Return the present values; those of an earlier time if they are equal."""
        now = self.entry.__dict__
        varying: _Values
        try:
            varying = self._varying_of(now)
        except KeyError:
            varying = _Special([now.get(name, _ABSENT) for name in self._names])
        if known is not None and len(known) == len(varying) and all(map(is_, varying, known)):
            return known
        if _CONTAINERS.isdisjoint(map(type, varying)):
            return varying
        copied = _Special(self._copied(varying, known or ()))
        if known is not None and len(known) == len(copied) and all(map(is_, copied, known)):
            return known
        return copied

    def put_back(self, values: _Values) -> None:
        """Put earlier values back."""
        now = self.entry.__dict__
        if len(values) < len(self._names):
            values = _Special((*values, *self._first[len(values) :]))
        now.update(zip(self._names, values, strict=True))
        if type(values) is tuple:
            return
        for name, value in zip(self._names, values, strict=True):
            if type(value) is _Held:
                now[name] = value.container
                _fill(*value)
            elif value is _ABSENT:
                del now[name]

    def _copied(self, varying: _Values, known: _Values) -> Iterator[Any]:
        for index, value in enumerate(varying):
            if type(value) not in _CONTAINERS:
                yield value
                continue
            before = known[index] if index < len(known) else None
            if type(before) is not _Held or before.container is not value:
                yield _Held(value, _contents(value, ()))
            elif _is_held(value, before):
                yield before
            else:
                yield _Held(value, _contents(value, before.contents))


def _getter(names: Iterable[str]) -> Callable[[dict[str, Any]], tuple[Any, ...]]:
    """Return what gives the values of these attributes."""
    given = tuple(names)
    if len(given) > 1:
        return itemgetter(*given)
    return lambda now: tuple([now[name] for name in given])


class Keeper:
    """Takes and puts back the attributes of objects.

    Args:
        always: Objects that every step may change.
        others: Those that a step changes only where :meth:`touch` says so.
        dynamic: Returns the objects that come and go.
    """

    def __init__(
        self,
        always: Iterable[Any],
        others: Iterable[Any],
        dynamic: Callable[[], Iterable[Any]],
    ) -> None:
        first = {id(entry): entry for entry in always}
        every = first | {id(entry): entry for entry in others}
        self._kept = [_Kept(entry) for entry in every.values()]
        self._numbers = {key: number for number, key in enumerate(every)}
        self._always = range(len(first))
        self._dynamic = dynamic
        self._held: Memento | None = None
        """The state of all objects but those that were touched since."""
        self._touched: set[int] = set()

    def begin(self) -> None:
        """Expect a step."""
        self._touched.update(self._always)

    def touch(self, entries: Iterable[Any]) -> None:
        """Note objects that a step has changed."""
        numbers = self._numbers
        self._touched.update([numbers[id(entry)] for entry in entries])

    def touch_all(self) -> None:
        """Note that a step may have changed every object."""
        self._touched.update(range(len(self._kept)))

    def take(self) -> Memento:
        """Return the present state; it shares with the one before what has not changed."""
        held, kept = self._held, self._kept
        if held is None:
            lasting, known = [entry.save(None) for entry in kept], {}
        else:
            lasting, known = held.lasting.copy(), held.dynamic
            for number in self._touched:
                kept[number].look()
                lasting[number] = kept[number].save(lasting[number])
        dynamic: dict[int, _Whole] = {}
        for entry in self._dynamic():
            number = id(entry)
            if number not in dynamic:
                dynamic[number] = _whole(entry, known.get(number))
        self._touched.clear()
        self._held = Memento(lasting, dynamic)
        return self._held

    def put_back(self, memento: Memento) -> None:
        """Put the objects into the state that was taken."""
        held, touched, lasting = self._held, self._touched, memento.lasting
        if memento is held and not touched:
            return
        kept = self._kept
        for number in touched:
            kept[number].look()
        if held is not None and memento is not held:
            before = held.lasting
            touched.update(
                [number for number, saved in enumerate(lasting) if saved is not before[number]]
            )
        for number in touched:
            kept[number].put_back(lasting[number])
        for entry, attributes, containers in memento.dynamic.values():
            entry.__dict__ = attributes.copy()
            for container, contents in containers:
                _fill(container, contents)
        touched.clear()
        self._held = memento


def _whole(entry: Any, known: _Whole | None) -> _Whole:
    """Return all attributes of an object."""
    now = entry.__dict__
    if known is not None and known[1] == now:
        for held in known[2]:
            if not _is_held(held.container, held):
                break
        else:
            return known
    containers = [value for value in now.values() if type(value) in _CONTAINERS]
    return entry, now.copy(), tuple([_Held(value, _contents(value, ())) for value in containers])


def _contents(container: Any, known: tuple[Any, ...]) -> tuple[Any, ...]:
    """Return what a container holds; of a dict the known keys, if they are equal."""
    if type(container) is not dict:
        return tuple(container)
    if not container:
        return ()
    keys = tuple(container)
    return (known[0] if known and known[0] == keys else keys), tuple(container.values())


def _fill(container: Any, contents: tuple[Any, ...]) -> None:
    """Have a container hold what it held."""
    container.clear()
    if not contents:
        return
    if type(container) is dict:
        container.update(zip(*contents, strict=True))
    elif type(container) is set:
        container.update(contents)
    else:
        container.extend(contents)


def _is_held(container: Any, held: _Held) -> bool:
    """Is it this container, with what it held? In a dict 0 and False are not the same."""
    before, contents = held
    if container is not before:
        return False
    if not container:
        return not contents
    if type(container) is set:
        return bool(container == set(contents))
    if type(container) is not dict:
        return tuple(container) == contents
    if not contents or len(container) != len(contents[0]):
        return False
    keys, values = contents
    return all(map(is_, container.values(), values)) and tuple(container) == keys
