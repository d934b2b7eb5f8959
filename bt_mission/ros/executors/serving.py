"""The common part of the executors: the nodes, and serving what is ready in order."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Coroutine, Sequence
from typing import Any, Protocol

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Task

from bt_mission.ros.executors.arrivals import Arrivals, Arrived
from bt_mission.ros.executors.callbacks import SERVERS
from bt_mission.ros.executors.coroutines import Tasks
from bt_mission.ros.executors.entities import Entities, exists, is_reported_once
from bt_mission.ros.executors.taps import Passing, PendingCallback, Side, Taps


class CallHost(Protocol):
    """What runs callbacks that may block (:mod:`bt_mission.programs`)."""

    goals: Any
    """The goals of action servers, as far as they got."""

    def admits(self, entity: Any, node: Node | None) -> bool:
        """Return whether an entity of a node can be served now."""

    def has_begun_task(self) -> bool:
        """Return once whether such code has made a task: it comes before other messages."""

    def owns(self, waitable: Any) -> bool:
        """Return whether a waitable is of code that may block."""

    def call(
        self, entity: Any, node: Node | None, function: Callable[..., Any], *args: Any
    ) -> PendingCallback:
        """Call a function that serves an entity. Return the rest of it as a coroutine."""

    def took(self, waitable: Any, parts: Any) -> None:
        """Note what was taken for a waitable."""

    def task_of_call(
        self, callback: Any, args: Sequence[Any], kwargs: dict[str, Any]
    ) -> Task | None:
        """Make a task of the code that blocks, if it asks for one; else return None."""

    def compare_qos(self, nodes: Sequence[Node]) -> None:
        """Say which publishers and subscriptions of such code do not match."""

    def take_advanced(self) -> bool:
        """Return once whether such code has run."""

    def check(self) -> None:
        """Look for code that can never continue, once nothing is ready."""

    def refuse_standstill(self) -> None:
        """Name the code that waits while nothing will ever be due."""


class ServingExecutor(Executor):
    """Serves nodes, and the entities of a node, in the order of their creation.

    It runs on the caller's thread and starts none. Coroutine callbacks and tasks are resumed before
    every round of callbacks, as by rclpy's executors.

    Args:
        context: The rclpy context of the nodes.
    """

    def __init__(self, *, context: Context | None = None) -> None:
        self._structure_changed = True
        super().__init__(context=context)
        self.taps = Taps()
        self.arrivals = Arrivals()
        self._served = 0
        self._is_over = False
        self._ordered_nodes: list[Node] = []
        self._entities = Entities([], self._context, self.arrivals)
        self._begun = Tasks()
        self._owed: list[Arrived] = []
        self.host: CallHost | None = None
        """Runs code that may block, if there is such code."""

    @property
    @abstractmethod
    def now_ns(self) -> int:
        """The present instant by the executor's clock, ns."""

    @property
    def callbacks_served(self) -> int:
        """Callbacks, and turns of tasks, since the start."""
        return self._served + self._begun.turns

    # ---- nodes ---------------------------------------------------------------------------

    def add_node(self, node: Node) -> bool:
        """Serve ``node`` after all nodes added before it."""
        if not self._take_node(node):
            return False
        node.executor = self
        return True

    def remove_node(self, node: Node) -> None:
        """Stop serving ``node``. Its suspended callbacks stay suspended."""
        if node in self._ordered_nodes:
            self._ordered_nodes.remove(node)
            self._begun.node_leaves(node)
            self.wake()

    def get_nodes(self) -> list[Node]:
        """The nodes served, in order."""
        return list(self._ordered_nodes)

    def wake(self) -> None:
        """Note that an entity was made or destroyed (rclpy calls this)."""
        self._structure_changed = True

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """Stop serving. It never waits."""
        self._ordered_nodes.clear()
        self._owed.clear()
        self._entities = Entities([], self._context, self.arrivals)
        self._structure_changed = True
        return super().shutdown(timeout_sec)

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Run a function or coroutine in the next round. Return its future."""
        task = Task(callback, args, kwargs, executor=self)
        self._begun.add(task)
        return task

    # ---- for the callbacks that are served -----------------------------------------------

    def passing(self, entity: Any, name: str, side: Side, message: Any) -> Passing:
        """Something that an entity was sent and has taken, for its taps."""
        return Passing(name, side, message, self._entities.owner_of(entity), self.now_ns)

    def actions_of(self, end: Any) -> tuple[str, ...]:
        """Return the full names of the actions to which an end of an action may belong."""
        return self._entities.actions_of(end)

    def offers(self, action: str) -> bool:
        """Return whether a node certainly serves the action of this full name.

        While that is not known, as after a change, the result is False. A look at the graph takes
        longer, the larger the graph is.
        """
        return not self._structure_changed and self._entities.offers(action)

    # ---- inside --------------------------------------------------------------------------

    def _take_node(self, node: Node) -> bool:
        """Serve a node, whose executor may be another one. Return whether it is new."""
        if node in self._ordered_nodes:
            return False
        self.wake()
        self._ordered_nodes.append(node)
        self._begun.node_comes(node)
        return True

    @abstractmethod
    def _read(self, nodes: Sequence[Node]) -> Entities:
        """Take a snapshot of the entities of these nodes, some of which are new."""

    def _refresh(self) -> None:
        """Read the entities again if any was created or destroyed."""
        while self._structure_changed:
            self._structure_changed = False
            self._is_over = self._is_shutdown or not self._context.ok()
            # rclpy leaves destroyed nodes in their executor.
            self._ordered_nodes = [node for node in self._ordered_nodes if exists(node)]
            try:
                self._entities = self._read([] if self._is_over else self._ordered_nodes)
            except BaseException:
                self._structure_changed = True  # so that the next step finds it ready, too
                raise

    def _serve_ready(self) -> Sequence[Arrived]:
        """Serve each ready entity once. Return those entities."""
        if self._structure_changed:
            self._refresh()
        if self._is_over:
            return ()
        holding, host = self._begun.holding, self.host
        entities = self._entities
        ready = (
            entities.ready(self._owed, any_held=host is not None or holding != [])
            if entities.asked
            else entities.arrivals.waiting()
        )
        # An entity that reports only once that it is ready is owed a call until it is served, or
        # gone.
        asked = entities.asked
        self._owed = (
            [arrived for arrived in ready if is_reported_once(arrived.entity)] if asked else []
        )
        if holding or host:
            ready = [arrived for arrived in ready if self._can_be_served(arrived.entity)]
        for arrived in ready:
            entity = arrived.entity
            if (holding or host) and not self._can_be_served(entity):
                continue  # since it was ready, a callback of its group has been suspended
            if arrived in self._owed:
                self._owed.remove(arrived)
            self._served += 1
            arrived.count -= 1
            serve = SERVERS[type(entity)]
            if host is None:
                rest = serve(arrived, self)
            else:
                rest = host.call(entity, self._entities.node_of(entity), serve, arrived, self)
            if rest is not None:
                self._begin(entity, rest)
            if self._structure_changed or (host is not None and host.has_begun_task()):
                break  # the entity may be gone; the next round looks again
        return ready

    def _can_be_served(self, entity: Any) -> bool:
        """Return whether no callback of the entity's group is suspended."""
        return not self._begun.holding or bool(entity.callback_group.can_execute(entity))

    def _begin(self, entity: Any, rest: Coroutine[Any, Any, None]) -> None:
        self._begun.begin(rest, entity, self._entities.node_of)
