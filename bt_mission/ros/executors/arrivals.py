"""The entities for which something has arrived, as counted by the middleware.

A wait set asks every entity at every instant, several times, and most have nothing. rcl can
register a C function that is called with a number of messages as soon as they can be taken. Here it
is ``eventfd_write`` of the C library. It adds that number to a counter of the kernel's, from any
thread, without Python's lock. epoll reports which counters are above zero.
"""

from __future__ import annotations

import ctypes
import math
import os
import resource
import select
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from operator import attrgetter
from typing import Any
from weakref import WeakKeyDictionary, finalize, ref

from rclpy.action import ActionClient, ActionServer
from rclpy.client import Client
from rclpy.event_handler import EventHandler
from rclpy.exceptions import InvalidHandle
from rclpy.service import Service
from rclpy.subscription import Subscription

_RCL, _RCL_ACTION = "librcl.so", "librcl_action.so"
TELLING: dict[type, tuple[str, tuple[str, ...]]] = {
    Subscription: (_RCL, ("rcl_subscription_set_on_new_message_callback",)),
    Service: (_RCL, ("rcl_service_set_on_new_request_callback",)),
    Client: (_RCL, ("rcl_client_set_on_new_response_callback",)),
    ActionServer: (
        _RCL_ACTION,
        tuple(
            f"rcl_action_server_set_{part}_service_callback"
            for part in ("goal", "cancel", "result")
        ),
    ),
    ActionClient: (
        _RCL_ACTION,
        tuple(
            f"rcl_action_client_set_{part}_callback"
            for part in (
                "goal_client",
                "cancel_client",
                "result_client",
                "feedback_subscription",
                "status_subscription",
            )
        ),
    ),
    EventHandler: (_RCL, ("rcl_event_set_callback",)),
}
"""Kinds of entities that the middleware reports, with the library and the functions for that."""


@dataclass(eq=False, slots=True)
class Arrived:
    """The count of arrivals for one entity.

    The server of the entity subtracts what it takes. A subscription from which nothing can be taken
    has a count of zero: its queue has dropped what was counted. Other entities may have been sent
    something for another receiver, such as the answer to another client of the service.
    """

    entity: Any
    handle: Any
    rank: int = 0
    """Lower ranks are served first."""
    file: int | None = None
    """The kernel's counter; None for an entity that the middleware does not report."""
    count: int = 0
    """Messages that arrived and were not taken; more than exist if a queue overflowed."""


RANK = attrgetter("rank")


class Arrivals:
    """Counts what arrives for entities, until it is closed or forgotten."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._by_file: dict[int, Arrived] = {}
        self._waiting: list[Arrived] = []
        self._unwatched: list[Arrived] = []
        self._links: dict[int, _Link] = {}
        self._end = finalize(self, _close, self._epoll, self._links)
        self._end.atexit = False

    def watch(self, entities: Sequence[Any]) -> list[Arrived]:
        """Count for exactly these entities. They are served in this order.

        Returns:
            The entities that the middleware does not report.
        """
        kept = {id(entity) for entity in entities}
        for key in [key for key in self._links if key not in kept]:
            link = self._links.pop(key)
            del self._by_file[link.file]
            link.cut(self._epoll)
        known, self._unwatched = {id(polled.entity): polled for polled in self._unwatched}, []
        for rank, entity in enumerate(entities):
            link_ = self._links.get(id(entity)) or self._link(entity)
            if link_ is None:
                arrived = known.get(id(entity)) or Arrived(entity, getattr(entity, "handle", None))
                self._unwatched.append(arrived)
            else:
                arrived = link_.arrived
            arrived.rank = rank
        known_ids = set(map(id, self._by_file.values()))
        self._waiting = [waiting for waiting in self._waiting if id(waiting) in known_ids]
        self._waiting.sort(key=RANK)
        return self._unwatched

    def waiting(self) -> list[Arrived]:
        """The arrivals that can be served now, in order, each until its count is zero."""
        if self._waiting:
            self._waiting = [arrived for arrived in self._waiting if arrived.count > 0]
        if changed := self._epoll.poll(0):
            for file, _ in changed:
                arrived = self._by_file[file]
                if arrived.count <= 0:
                    arrived.count = 0
                    self._waiting.append(arrived)
                arrived.count += os.eventfd_read(file)
            self._waiting.sort(key=RANK)
        return self._waiting

    def count_of(self, entity: Any) -> int:
        """Return how much has arrived for an entity and was not taken, after the last look."""
        link = self._links.get(id(entity))
        return 0 if link is None else link.arrived.count

    def leftovers(self) -> list[Any]:
        """Of what there may be more than has been taken, after the last look."""
        return [arrived.entity for arrived in self._waiting if arrived.count > 0]

    def fileno(self) -> int:
        """The file that can be read from while something is counted that was not waited for."""
        return self._epoll.fileno()

    def close(self) -> None:
        """Count no more."""
        self._end()
        self._by_file.clear()
        self._waiting.clear()
        self._unwatched.clear()

    def _link(self, entity: Any) -> _Link | None:
        for kind, (library, names) in TELLING.items():
            if isinstance(entity, kind):
                setters = [_setter(library, name) for name in names]
                break
        else:
            return None
        if None in setters:
            return None
        file = _new_counter()
        if file is None:
            return None
        link = _Link(Arrived(entity, _handle_of(entity), file=file), setters, file)
        if not link.made:
            return None
        self._epoll.register(file, select.EPOLLIN)
        self._links[id(entity)] = link
        self._by_file[file] = link.arrived
        if link.arrived.count:
            self._waiting.append(link.arrived)
        return link


class _Link:
    """A counter to which the middleware adds, for one entity.

    The middleware tells only the latest counter of an entity, and nothing twice. So a link takes
    over what its predecessor, perhaps of another executor, has counted and not taken.
    """

    def __init__(self, arrived: Arrived, setters: Sequence[Any], file: int) -> None:
        self.arrived, self.file, self._setters = arrived, file, setters
        self.made = self._set(_function(), file)
        if not self.made:
            self._set(None, 0)
            os.close(file)
            return
        former = _latest.get(arrived.entity, 0)
        if not isinstance(former, int):
            link = former()
            former = 0 if link is None else link.left()
        arrived.count = former
        _latest[arrived.entity] = ref(self)

    def _set(self, function: Any, file: int) -> bool:
        handle = self.arrived.handle
        try:
            with handle:
                pointer = handle.pointer
                # All are cut, so that no entity keeps a closed file.
                refused = [setter(pointer, function, file) for setter in self._setters]
                return not any(refused)
        except InvalidHandle:
            return False  # destroyed, and with it what calls the function

    def left(self) -> int:
        """Return what has arrived and was not taken, and forget it."""
        count, self.arrived.count = max(self.arrived.count, 0), 0
        with suppress(BlockingIOError):
            count += os.eventfd_read(self.file)
        return count

    def cut(self, epoll: select.epoll) -> None:
        """Stop the additions. Only after that the number of the file may be used again."""
        latest = _latest.get(self.arrived.entity)
        if isinstance(latest, ref) and latest() is self:
            self._set(None, 0)
            _latest[self.arrived.entity] = self.left()
        epoll.unregister(self.file)
        os.close(self.file)


_latest: WeakKeyDictionary[Any, ref[_Link] | int] = WeakKeyDictionary()
"""The latest link of each entity; once it is cut, what it had counted and not taken."""


def _new_counter() -> int | None:
    """Return a counter of the kernel's; None if files are scarce."""
    try:
        file = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
    except OSError:
        return None
    if file < _most_files():
        return file
    os.close(file)
    return None


@cache
def _most_files() -> float:
    """The highest file number that is used: three quarters of those that the process may open."""
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return math.inf if soft == resource.RLIM_INFINITY else 0.75 * soft


def _close(epoll: select.epoll, links: dict[int, _Link]) -> None:
    for link in links.values():
        link.cut(epoll)
    links.clear()
    epoll.close()


def _handle_of(entity: Any) -> Any:
    if isinstance(entity, ActionServer):
        return entity._handle
    if isinstance(entity, ActionClient):
        return entity._client_handle
    if isinstance(entity, EventHandler):
        return entity._EventHandler__event
    return entity.handle


@cache
def _function() -> Any:
    """``eventfd_write``, whose arguments are those of ``rcl_event_callback_t``."""
    return ctypes.cast(ctypes.CDLL(None).eventfd_write, ctypes.c_void_p)


@cache
def _setter(library: str, name: str) -> Any:
    """Return the function of rcl; None if this rcl or this middleware lacks it."""
    try:
        function = getattr(ctypes.CDLL(library), name)
    except (OSError, AttributeError):
        return None
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p]
    function.restype = ctypes.c_int
    return function
