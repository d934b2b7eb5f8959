"""Goes on with a mission from its journal: first the goals that were in flight, then the tree."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.behaviours.decorators import Subtree
from bt_mission.behaviours.runtime import Runtime
from bt_mission.behaviours.snapshot import load
from bt_mission.core.errors import BtMissionError
from bt_mission.core.stamps import NS
from bt_mission.executive.journal.state import JournalState
from bt_mission.executive.journal.values import Unpack, decode, unpack_generator
from bt_mission.goals.goal import Goal, GoalClient, GoalStatus

SERVER_WAIT_NS = 10 * NS
"""How long the servers of goals in flight may take to be found."""

MOST_OF_A_LOOK_NS = NS // 10
"""What passes between two looks counts up to this: a clock that leaps, on a machine that is too
busy to serve its graph, is no wait in which servers could have been found."""


class Recovery:
    """Sees to the goals that were in flight, and puts the tree where the journal left it.

    Each goal is asked after and cancelled. One that had succeeded meanwhile counts for the leaf
    that had sent it; where it was cut short, or its server knows it no more, the leaf starts anew.

    Args:
        story: Of the journal.
        runtime: Clock, ledger, variables and clients of the mission that goes on.
        unpack: A message from its JSON.
    """

    def __init__(self, story: JournalState, runtime: Runtime, unpack: Unpack) -> None:
        self._story = story
        self._runtime = runtime
        self._unpack = unpack
        self._couriers: dict[str, GoalClient] = {}
        self._goals: dict[str, Goal] = {}
        self._looked_ns: int | None = None
        self._waited_ns = 0

    def is_done(self) -> bool:
        """Is it known what became of every goal? Called at each tick until it is.

        Raises:
            BtMissionError: When that cannot be found out.
        """
        now_ns = self._runtime.now_ns
        if self._looked_ns is None:
            self._looked_ns = now_ns
            for goal_id, sent in self._story.goals.items():
                self._couriers[goal_id] = self._runtime.goal_client(sent["action"], sent["type"])
        self._waited_ns += min(now_ns - self._looked_ns, MOST_OF_A_LOOK_NS)
        self._looked_ns = now_ns
        for goal_id, courier in self._couriers.items():
            if goal_id in self._goals:
                continue
            owner = self._story.goals[goal_id]["owner"]
            if courier.is_ready():
                self._goals[goal_id] = self._runtime.ledger.recover_goal(
                    bytes.fromhex(goal_id), courier, owner, now_ns
                )
            elif self._waited_ns >= SERVER_WAIT_NS:
                raise BtMissionError(
                    f"'{owner}' had a goal at {courier.name} when its process died, and no server "
                    "is there now; start it, then resume again"
                )
        if len(self._goals) < len(self._couriers):
            return False
        if any(goal.is_live for goal in self._goals.values()):
            return False
        left = self._runtime.ledger.describe_left_behind()
        if left:
            raise BtMissionError(f"nobody confirms the end of {', '.join(left)}")
        return True

    def finish(self, paths: Mapping[Behaviour, str]) -> None:
        """Put every node, every variable and every random generator where it stood.

        Raises:
            BtMissionError: For a variable that the journal could not keep.
        """
        story = self._story
        scopes = {"": self._runtime.scope}
        scopes |= {path: node.inner for node, path in paths.items() if isinstance(node, Subtree)}
        for path, scope in scopes.items():
            kept = story.values.get(path, {})
            scope.replace({name: decode(name, data, self._unpack) for name, data in kept.items()})
        for name, data in story.generators.items():
            unpack_generator(self._runtime.scope.random(name), data)
        for node, path in paths.items():
            if path in story.nodes:
                self._put(node, *story.nodes[path])

    def _put(self, node: Behaviour, status: str, state: dict[str, Any], saved_ns: int) -> None:
        for name, whose in (("elements", "for_each"), ("values", "finally")):
            if name in state:
                state = {**state, name: decode(whose, state[name], self._unpack)}
        # What had passed of a time when the process died has passed; the pause since then has not.
        since_ns = self._runtime.now_ns - (self._story.time_ns - saved_ns)
        load(node, Status(status), state, since_ns)
        if isinstance(node, ActionLeaf) and status == Status.RUNNING.value:
            goal = self._goals.get(str(state.get("goal")))
            if goal is not None and goal.status is GoalStatus.SUCCEEDED:
                node.adopt(goal)
