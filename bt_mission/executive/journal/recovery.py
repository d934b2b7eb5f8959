"""Resumes a mission from its journal: first the goals that were in flight, then the tree."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.base.errors import BtMissionError, cause_of
from bt_mission.base.stamps import NS
from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.behaviours.decorators import Subtree
from bt_mission.executive.behaviours.runtime import Runtime
from bt_mission.executive.behaviours.snapshot import load
from bt_mission.executive.goals.goal import Goal, GoalClient, GoalStatus
from bt_mission.executive.journal.store import (
    JournalState,
    NodeState,
    Unpack,
    decode,
    unpack_generator,
)

SERVER_WAIT_NS = 10 * NS
"""The limit of the search for the servers of goals in flight, ns."""

LONGEST_STEP_NS = NS // 10
"""The time between two ticks counts up to this, ns. A clock that leaps on a machine that is too
busy to serve its graph gives servers no time to be discovered.
"""


class Recovery:
    """Ends the goals that were in flight, and restores the tree from the journal.

    The state of each goal is queried, and the goal is cancelled. If it had succeeded meanwhile, the
    leaf that had sent it succeeds. If not, or if its server does not know it, the leaf starts
    again.

    Args:
        state: The state in the journal.
        runtime: Clock, ledger, variables and clients of the resumed mission.
        unpack: Returns a message from its JSON.
    """

    def __init__(self, state: JournalState, runtime: Runtime, unpack: Unpack) -> None:
        self._state = state
        self._runtime = runtime
        self._unpack = unpack
        self._clients: dict[str, GoalClient] = {}
        self._goals: dict[str, Goal] = {}
        self._ticked_ns: int | None = None
        self._waited_ns = 0

    def is_done(self) -> bool:
        """Return whether every goal has ended. Called at each tick until it is true.

        Raises:
            BtMissionError: That cannot be determined.
        """
        now_ns = self._runtime.now_ns
        if self._ticked_ns is None:
            self._ticked_ns = now_ns
            for goal_id, sent in self._state.goals.items():
                with _restoring(f"the goal of '{sent.owner}'"):
                    self._clients[goal_id] = self._runtime.goal_client(sent.action, sent.type)
        self._waited_ns += min(now_ns - self._ticked_ns, LONGEST_STEP_NS)
        self._ticked_ns = now_ns
        for goal_id, client in self._clients.items():
            if goal_id in self._goals:
                continue
            owner = self._state.goals[goal_id].owner
            if client.is_ready():
                self._goals[goal_id] = self._runtime.ledger.recover_goal(
                    bytes.fromhex(goal_id), client, owner, now_ns
                )
            elif self._waited_ns >= SERVER_WAIT_NS:
                raise BtMissionError(
                    f"'{owner}' had a goal at {client.name} when its process died, and the "
                    f"server is not running; start it, then resume again",
                    code="BT-906",
                )
        if len(self._goals) < len(self._clients):
            return False
        if any(goal.is_live for goal in self._goals.values()):
            return False
        left = self._runtime.ledger.describe_left_behind()
        if left:
            raise BtMissionError(f"no server confirms the end of {', '.join(left)}", code="BT-906")
        return True

    def finish(self, paths: Mapping[Behaviour, str]) -> None:
        """Restore every node, every variable and every random generator.

        Raises:
            BtMissionError: The journal lacks something, or it cannot be restored.
        """
        scopes = {"": self._runtime.scope}
        scopes |= {path: node.inner for node, path in paths.items() if isinstance(node, Subtree)}
        values: dict[str, dict[str, object]] = {path: {} for path in scopes}
        for key, data in self._state.variables.items():
            path, _, name = key.rpartition("/")
            with _restoring(f"the variable '{name}'"):
                values[path][name] = decode(name, data, self._unpack)
        for path, scope in scopes.items():
            scope.replace(values[path])
        for name, generator in self._state.generators.items():
            with _restoring(f"the random generator of {name}"):
                unpack_generator(self._runtime.scope.random(name), generator)
        for node, path in paths.items():
            if path in self._state.nodes:
                with _restoring(f"'{node.name}' ({path})"):
                    self._restore(node, self._state.nodes[path])

    def _restore(self, node: Behaviour, saved: NodeState) -> None:
        memory = dict(saved.memory)
        for name, owner in (("elements", "for_each"), ("values", "finally")):
            if name in memory:
                memory[name] = decode(owner, memory[name], self._unpack)
        # Time that had passed when the process died counts; the time since then does not.
        since_ns = self._runtime.now_ns - (self._state.about.time_ns - saved.saved_ns)
        load(node, saved.status, memory, since_ns)
        if isinstance(node, ActionLeaf) and saved.status is Status.RUNNING:
            goal = self._goals.get(str(memory.get("goal")))
            if goal is not None and goal.status is GoalStatus.SUCCEEDED:
                node.adopt(goal)


@contextmanager
def _restoring(what: str) -> Iterator[None]:
    """Name what a journal has of a mission in a way that cannot be used."""
    try:
        yield
    except BtMissionError:
        raise
    except Exception as error:  # the memory of a node may be anything
        raise BtMissionError(
            f"{what} cannot be restored: {cause_of(error)}", code="BT-906"
        ) from error
