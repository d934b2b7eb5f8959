"""What every executor of ours does: it has nodes, and serves what is ready for them in order."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Coroutine, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.task import Task

from bt_mission.executors.arrivals import Arrivals, Arrived
from bt_mission.executors.callbacks import SERVERS
from bt_mission.executors.coroutines import Tasks
from bt_mission.executors.entities import Entities, exists, is_reported_once
from bt_mission.executors.taps import Passing, Side, Taps


class ServingExecutor(Executor):
    """Serves nodes, and the entities of a node, in the order of their creation.

    It runs on the caller's thread and starts none. Coroutine callbacks and tasks are resumed before
    every round of callbacks, as under rclpy's own executors.

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

    @property
    @abstractmethod
    def now_ns(self) -> int:
        """The present instant, ns, by whatever clock this executor goes."""

    @property
    def callbacks_served(self) -> int:
        """Callbacks, and turns of tasks, since the start."""
        return self._served + self._begun.turns

    # ---- nodes ---------------------------------------------------------------------------

    def add_node(self, node: Node) -> bool:
        """Serve ``node`` after all nodes added before it."""
        if node in self._ordered_nodes:
            return False
        self._ordered_nodes.append(node)
        self._begun.node_comes(node)
        node.executor = self
        self.wake()
        return True

    def remove_node(self, node: Node) -> None:
        """Stop serving ``node``; callbacks of it that await something stay where they are."""
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
        """Serve nobody any more; it never has to wait."""
        self._ordered_nodes.clear()
        self._owed.clear()
        self._entities = Entities([], self._context, self.arrivals)
        self._structure_changed = True
        return super().shutdown(timeout_sec)

    def create_task(
        self, callback: Callable[..., Any] | Coroutine[Any, Any, Any], *args: Any, **kwargs: Any
    ) -> Task:
        """Run a function or coroutine with the next round; gives its future."""
        task = Task(callback, args, kwargs, executor=self)
        self._begun.add(task)
        return task

    # ---- for the callbacks that are served -----------------------------------------------

    def passing(self, entity: Any, name: str, side: Side, message: Any) -> Passing:
        """Something that an entity was sent and has taken, for its taps."""
        return Passing(name, side, message, self._entities.owner_of(entity), self.now_ns)

    def actions_of(self, end: Any) -> tuple[str, ...]:
        """The full names of the actions that one end of an action can be of."""
        return self._entities.actions_of(end)

    def offers(self, action: str) -> bool:
        """Is the action of this full name surely served by one of the nodes?

        Where it is not known at the moment, as after a change, the answer is no. To ask the graph
        takes the longer the more there is in it.
        """
        return not self._structure_changed and self._entities.offers(action)

    # ---- inside --------------------------------------------------------------------------

    @abstractmethod
    def _read(self, nodes: Sequence[Node]) -> Entities:
        """Take a snapshot of the entities of these nodes, some of which are new."""

    def _refresh(self) -> None:
        """Read the entities again if any was made or destroyed."""
        while self._structure_changed:
            self._structure_changed = False
            self._is_over = self._is_shutdown or not self._context.ok()
            # rclpy leaves destroyed nodes in their executor.
            self._ordered_nodes = [node for node in self._ordered_nodes if exists(node)]
            try:
                self._entities = self._read([] if self._is_over else self._ordered_nodes)
            except BaseException:
                self._structure_changed = True  # so that the next step sees it, too
                raise

    def _serve_ready(self) -> Sequence[Arrived]:
        """Serve each entity that is ready once; gives those."""
        if self._structure_changed:
            self._refresh()
        if self._is_over:
            return ()
        holding = self._begun.holding
        ready = self._entities.ready(self._owed, any_held=bool(holding))
        # What tells only once that it is ready is owed a call until it is served, or gone.
        asked = self._entities.asked
        self._owed = (
            [arrived for arrived in ready if is_reported_once(arrived.entity)] if asked else []
        )
        if holding:
            ready = [arrived for arrived in ready if self._can_be_served(arrived.entity)]
        for arrived in ready:
            entity = arrived.entity
            if holding and not self._can_be_served(entity):
                continue  # since it was found ready, a callback of its group has begun to await
            if arrived in self._owed:
                self._owed.remove(arrived)
            self._served += 1
            arrived.count -= 1
            rest = SERVERS[type(entity)](arrived, self)
            if rest is not None:
                self._begin(entity, rest)
            if self._structure_changed:
                break  # what is ready may be gone; the next round looks again
        return ready

    def _can_be_served(self, entity: Any) -> bool:
        """Is no callback of its group in the middle of something?"""
        return not self._begun.holding or bool(entity.callback_group.can_execute(entity))

    def _begin(self, entity: Any, rest: Coroutine[Any, Any, None]) -> None:
        self._begun.begin(rest, entity, self._entities.node_of)
