"""After a halt, the cancel leaves first; the next goal waits until the base is free."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from tests.support.play import Play

TURN = "type: bt_mission_interfaces/action/Turn"
DRIVE = f"{{action: {{name: /drive, {TURN}}}, name: drive, timeout: 99}}"
NEXT = f"{{action: {{name: /next, {TURN}}}, name: next, timeout: 99}}"
SPARE = "{check: x > 9}"

HALTS = {
    "a timeout": f"fallback: [{{timeout: 0.1, do: {DRIVE}}}, {NEXT}]",
    "a guard": f"fallback: [{{guard: x < 1, do: {DRIVE}}}, {NEXT}]",
    "a parallel": (
        f"sequence: [{{parallel: [{DRIVE}, {{repeat: {{until: x > 0}}, do: {{check: true}}}}], "
        f"succeed_when: any}}, {NEXT}]"
    ),
    "a reactive sequence": (
        f"sequence: [{{when: x < 1, do: {{check: true}}, else: {NEXT}}}, {DRIVE}]\n  memory: false"
    ),
    "a reactive fallback": (
        f"fallback: [{{sequence: [{{check: x > 0}}, {NEXT}]}}, {DRIVE}]\n  memory: false"
    ),
    "a parallel in a reactive fallback": (
        f"fallback: [{{sequence: [{{check: x > 0}}, {{parallel: [{NEXT}, {{wait: 9}}]}}]}}, "
        f"{{parallel: [{DRIVE}]}}]\n  memory: false"
    ),
    "a halt before a clean-up": (
        f"fallback: [{{sequence: [{{check: x > 0}}, {{wait: 9}}]}}, "
        f"{{finally: {{timeout: 9}}, do: {DRIVE}, then: {NEXT}}}]\n  memory: false"
    ),
}


class Robot:
    """A mission whose first goal is under way, played to its halt."""

    def __init__(self, play: Callable[..., Play], tree: str, drive: str = "accepts") -> None:
        self.played = play(f"  {tree}", "mission: test\ninputs: {x: 0}\n")
        self.order: list[str] = []
        for name in ("/drive", "/next"):
            server = self.played.goal_client(name, "")
            for method in ("send", "send_cancel"):
                self._note(server, method, f"{method} {name}")
        self.drive, self.next = (self.played.servers[name] for name in ("/drive", "/next"))
        self.played.tick()
        if drive == "accepts":
            self.drive.accept()
        self.played.tick()
        self.played.scope.values["x"] = 1

    def _note(self, server: Any, method: str, words: str) -> None:
        original = getattr(server, method)

        def noted(*arguments: Any) -> None:
            self.order.append(words)
            original(*arguments)

        setattr(server, method, noted)

    @property
    def message(self) -> str:
        """The message of the leaf that waits."""
        nodes = self.played.executive.nodes
        return next(node for node in nodes if node.name == "next").feedback_message


CANCELED = ["send /drive", "send_cancel /drive"]


@pytest.mark.parametrize("drive", ["accepts", "does not answer"])
@pytest.mark.parametrize("tree", HALTS.values(), ids=HALTS)
def test_the_next_goal_waits_for_the_end_of_a_halted_one(
    play: Callable[..., Play], tree: str, drive: str
) -> None:
    """The cancel is sent in the tick of the halt; the leaf that waits shows for what."""
    robot = Robot(play, tree, drive)
    robot.played.tick()
    assert robot.order == CANCELED
    robot.played.tick(10)
    assert robot.order == CANCELED
    assert robot.message == "waiting for /drive of 'drive' to free the base"
    if drive != "accepts":
        robot.drive.accept()
        robot.played.tick()
        assert robot.order == [*CANCELED, "send_cancel /drive"]
    robot.drive.cancel()
    robot.played.tick()
    assert robot.order[-1] == "send /next"


@pytest.mark.parametrize("tree", HALTS.values(), ids=HALTS)
def test_a_goal_that_uses_no_part_of_the_robot_does_not_wait(
    play: Callable[..., Play], tree: str
) -> None:
    """The cancel is sent in the same tick."""
    robot = Robot(play, tree.replace("name: next,", "name: next, uses: [],"))
    robot.played.tick(2)
    assert sorted(robot.order[1:]) == ["send /next", "send_cancel /drive"]


def test_parts_are_free_of_each_other(play: Callable[..., Play]) -> None:
    """A goal of the arm does not wait for the base, and one of both does."""
    for parts, waits in (("arm", False), ("[arm, base]", True), ("[gripper]", False)):
        tree = HALTS["a guard"].replace("name: next,", f"name: next, uses: {parts},")
        robot = Robot(play, tree)
        robot.played.tick(2)
        assert ("send /next" not in robot.order) is waits, parts


def test_the_wait_ends_when_the_goal_is_given_up(play: Callable[..., Play]) -> None:
    """After its `cancel_timeout`, also if the cancel was refused; not after `server_timeout`."""
    tree = HALTS["a guard"].replace("name: drive,", "name: drive, cancel_timeout: 7,")
    robot = Robot(play, tree)
    robot.played.tick()
    robot.drive.refuse_cancel()
    robot.played.tick(140)
    assert "send /next" not in robot.order
    robot.played.tick()
    assert robot.order.count("send_cancel /drive") == 7
    assert robot.order[-1] == "send /next"
    assert robot.played.executive.goals_left_behind


def test_a_goal_that_a_sibling_cancels_is_awaited(play: Callable[..., Play]) -> None:
    """In a `parallel`, goals at the base are sent side by side, unless one of them is ending."""
    tree = f"parallel: [{DRIVE}, {{sequence: [{{wait: 0.15}}, {NEXT}]}}]\n  fail_when: impossible"
    for limit_s, waits in ((0.1, True), (99, False)):
        robot = Robot(play, tree.replace("timeout: 99", f"timeout: {limit_s}", 1))
        robot.played.tick(8)
        assert ("send /next" not in robot.order) is waits
