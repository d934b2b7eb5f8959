"""A mission's tree on a clock that the test moves, against servers that the test plays."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.behaviour import Behaviour

from bt_mission.executive import Executive
from bt_mission.goals.goal import Goal
from bt_mission.goals.ledger import Ledger
from bt_mission.mission import load_text
from bt_mission.trace import Trace
from bt_mission.tree.build import build_tree
from bt_mission.tree.runtime import Scope

S = 1_000_000_000
TICK_NS = S // 20


def message(**fields: Any) -> Any:
    """Something that looks like a ROS message with these fields."""
    return SimpleNamespace(get_fields_and_field_types=lambda: dict.fromkeys(fields, ""), **fields)


class Play:
    """An executive without ROS."""

    def __init__(self, text: str, server_type: Callable[[str], Any]) -> None:
        mission = load_text(text)
        self.now_ns = S
        self.servers: dict[str, Any] = {}
        self.said: list[str] = []
        self._server_type = server_type
        self.scope = Scope(dict(mission.inputs), mission.seed)
        self.ledger = Ledger(mission.seed, 3 * S, self._on_goal)
        self.trace = Trace()
        self.root = build_tree(mission, self.scope)
        self.executive = Executive(self.root, self, self.trace)

    def _on_goal(self, what: str, goal: Goal) -> None:
        self.executive.record_goal(what, goal)

    def courier(self, action: str, type_name: str) -> Any:
        if action not in self.servers:
            self.servers[action] = self._server_type(action)
        return self.servers[action]

    def log(self, text: str) -> None:
        self.said.append(text)

    def tick(self, count: int = 1) -> str:
        """Tick; gives the statuses of all nodes from the root down, one letter each."""
        for _ in range(count):
            self.now_ns += TICK_NS
            self.executive.tick()
        return self.statuses

    @property
    def statuses(self) -> str:
        def walk(node: Behaviour) -> str:
            return node.status.value[0] + "".join(walk(child) for child in node.children)

        return walk(self.root)

    @property
    def status(self) -> str:
        return str(self.executive.status)

    @property
    def turn(self) -> Any:
        return self.servers["/turn"]


@pytest.fixture
def play(server: Any) -> Callable[[str], Play]:
    """Set a mission's tree up: ``play(yaml_of_the_tree)``."""

    def start(tree: str, head: str = "mission: test") -> Play:
        return Play(f"{head}\ntree:\n{tree}", type(server))

    return start
