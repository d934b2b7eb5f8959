"""What drawings say of nodes."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_mission.language.mission import Mission
from bt_mission.language.nodes.base import NodeModel
from bt_mission.language.nodes.registry import KINDS
from bt_mission.language.nodes.subtree import TreeNode
from bt_mission.sessions.load import load
from bt_mission.views.drawing.nodes import drawn, heading, legend, outline
from tests.support.project import ROOT

MISSIONS = sorted([*ROOT.glob("missions/*.yaml"), *ROOT.glob("missions/sources/*.yaml")])


def test_every_kind_of_node_has_a_sign() -> None:
    """Also those that will be added."""
    assert [kind for kind, node in KINDS.items() if not node.sign.words] == []


def steps(node: NodeModel, mission: Mission) -> int:
    """Count the nodes below a node, with those of the named trees."""
    named = [each.tree for each in node.walk() if isinstance(each, TreeNode)]
    below = sum(steps(mission.trees[name].body, mission) for name in named)
    return below + sum(1 for _ in node.walk())


@pytest.mark.parametrize("path", MISSIONS, ids=lambda path: path.stem)
def test_every_shipped_mission_has_an_outline(path: Path) -> None:
    """A row for each step, in the order of the file, with the names that it has when it runs."""
    mission = load(path)
    rows = list(outline(drawn(mission)))
    assert len(rows) == steps(mission.tree, mission)
    assert rows[0].name == (mission.tree.name or mission.name)


@pytest.mark.parametrize(
    ("tree", "row"),
    [
        ("repeat: {count: 3}\n  do: {wait: 1}", "↻ m  3 times"),
        (
            "retry: {attempts: 2, pause: 1.5}\n  do: {wait: 1}\n  name: again",
            "↺ again  up to 2 times, 1.5 s apart",
        ),
        ("parallel: [{wait: 1}]\n  succeed_when: any", "⇉ m  succeeds when any does"),
        ("sequence: [{wait: 1}]\n  memory: false", "→ m  checks all children again in every tick"),
        ("wait: 2 * 3", "◷ wait  2 * 3 s"),
        ("log: at ${1 + 1}", "¶ log  at ${1 + 1}"),
        ("set: {a: 1, b: 2}", "≔ set a, b  a = 1; b = 2"),
        ("check: 1 < 2", "◇ check 1 < 2"),
        ("check: 1 < 2\n  name: sane", "◇ sane  1 < 2"),
        (
            "turn: {angle: 90}\n  cancel_when: current_angle > 5\n  on_cancel: success",
            "▶ turn  angle 90; success when current_angle > 5",
        ),
        (
            "turn: {angle: 90}\n  timeout: 9\n  outputs: {angle_turned: turned}",
            "▶ turn  angle 90; within 9 s; turned := angle_turned",
        ),
        ("service: {name: stop, type: std_srvs/srv/Trigger}\n  name: halt", "⇄ halt  /stop"),
        (
            "wait_for: {topic: bat, type: std_msgs/msg/Float32, until: data < 5}\n  timeout: 3",
            "▷ wait for bat  until data < 5; within 3 s",
        ),
    ],
)
def test_a_row_says_what_a_node_does(tree: str, row: str) -> None:
    """In the words of its author."""
    mission = load(f"mission: m\ntree:\n  {tree}\n")
    assert str(next(iter(outline(drawn(mission))))) == row


def test_trees_with_names_stand_where_they_are_used() -> None:
    """With what they are given."""
    mission = load(
        "mission: m\ntrees:\n  beat: {do: {wait: 1}}\ntree:\n  sequence:\n    - tree: beat\n"
        "    - tree: beat\n      name: again\n"
    )
    assert [str(row) for row in outline(drawn(mission))] == [
        "→ m",
        "├─ ▣ beat",
        "│  └─ ◷ wait  1 s",
        "└─ ▣ again",
        "   └─ ◷ wait  1 s",
    ]


def test_a_terminal_without_unicode_reads_it_too() -> None:
    """Each sign has a form in ASCII, and the legend says what it means."""
    mission = load("mission: m\nworld: w\ninputs: {n: 2}\ntree: {sequence: [{wait: $n}]}\n")
    root = drawn(mission)
    rows = [str(row) for row in outline(root, ascii_only=True)]
    assert rows == ["-> m", "`- t wait  $n s"]
    assert legend(root, ascii_only=True) == "-> sequence   t wait"
    assert "".join(rows).isascii()
    assert heading(mission) == "m in w (waffle); n 2"
