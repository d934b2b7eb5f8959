"""Snapshots of py_trees_ros as what an executive would tell, broken ones among them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.events import messages
from bt_mission.events.events import MissionStarted, MissionStateChanged
from bt_mission.events.mission_state import MissionState
from bt_mission.events.snapshots import MOST_NODES, SnapshotReader

RUNNING, SUCCESS = 2, 3


def uid(name: str) -> SimpleNamespace:
    """An id of a name; that of no name is zeros."""
    return SimpleNamespace(uuid=list(name.encode().ljust(16, b"\0")))


def node(name: str, parent: str = "", *below: str, status: int = RUNNING, message: str = "") -> Any:
    """A ``Behaviour``."""
    return SimpleNamespace(
        name=name,
        class_name=f"py_trees.some.{name.capitalize()}",
        own_id=uid(name),
        parent_id=uid(parent),
        child_ids=[uid(one) for one in below],
        status=status,
        message=message,
    )


def snapshot(*behaviours: Any, at_s: int = 100, **variables: str) -> Any:
    """A ``BehaviourTree``."""
    return SimpleNamespace(
        behaviours=[*behaviours],
        blackboard_on_visited_path=[
            SimpleNamespace(key=key, value=value) for key, value in variables.items()
        ],
        statistics=SimpleNamespace(count=7, stamp=SimpleNamespace(sec=at_s, nanosec=0)),
    )


def seen(*snapshots: Any) -> MissionState:
    """What a watcher knows after these."""
    reader, mission = SnapshotReader(), MissionState()
    for one in snapshots:
        for message in reader.take(one):
            mission.take(message)
    return mission


def paths(mission: MissionState) -> dict[str, str]:
    """The path of each node by its name, in the order of the tree."""
    assert mission.tree is not None
    return {one.name: one.path for one in mission.tree.nodes}


def test_children_come_in_the_order_that_their_parent_names():
    """However the message lists them: py_trees lists children before their parents."""
    mission = seen(
        snapshot(
            node("deep", "left", status=SUCCESS),
            node("left", "root", "deep"),
            node("right", "root", status=1),
            node("root", "", "left", "right"),
        )
    )
    assert paths(mission) == {"root": "0", "left": "0.0", "deep": "0.0.0", "right": "0.1"}
    assert mission.statuses == [
        Status.RUNNING,
        Status.RUNNING,
        Status.SUCCESS,
        Status.INVALID,
    ]
    assert (mission.status, mission.ticks, mission.goals_sent) == ("running", 7, None)
    assert not mission.needs_statuses


def test_words_of_a_running_node_are_no_change_of_its_status():
    """They come as progress, and the time for which it has run goes on."""
    mission = seen(
        snapshot(node("root", message="3 m left")),
        snapshot(node("root", message="2 m left"), at_s=104),
    )
    assert (mission.messages, mission.since_ns) == (["2 m left"], [100_000_000_000])
    assert [entry.text for entry in mission.log] == ["begins", ""]
    assert mission.now_ns == 104_000_000_000


def test_a_status_that_changes_has_its_time():
    """And the root's is that of the mission."""
    mission = seen(
        snapshot(node("root"), n="1"),
        snapshot(node("root", status=SUCCESS, message="there"), at_s=103, n="2"),
    )
    assert (mission.statuses, mission.messages) == ([Status.SUCCESS], ["there"])
    assert mission.ran_ns == [3_000_000_000]
    assert (mission.status, mission.variables) == ("success", {"n": "2"})


def test_a_tree_that_is_changed_is_another_run():
    """With all of its statuses."""
    mission = seen(
        snapshot(node("root", "", "a"), node("a", "root")),
        snapshot(node("root", "", "b"), node("b", "root", status=SUCCESS)),
    )
    assert paths(mission) == {"root": "0", "b": "0.0"}
    assert mission.statuses == [Status.RUNNING, Status.SUCCESS]
    assert mission.state is not None
    assert mission.tree is not None
    assert mission.state.run == mission.tree.run


@pytest.mark.parametrize(
    ("behaviours", "shown", "why"),
    [
        pytest.param((), None, "its snapshot has no root: it is empty", id="empty"),
        pytest.param(
            (node("a", "b", "b"), node("b", "a", "a")),
            None,
            "its snapshot has no root: every node has a parent",
            id="circle",
        ),
        pytest.param(
            (node("root", "", "root", "a"), node("a", "root", "root", "a")),
            ["root", "a"],
            "",
            id="children that are their own parents",
        ),
        pytest.param(
            (node("root", "", "a", "gone", "a"), node("a", "root")),
            ["root", "a"],
            "",
            id="a child that is not there, and one twice",
        ),
        pytest.param(
            (node("root"), node("a", "gone"), node("b", "a")),
            ["root"],
            "2 of its 3 nodes are not connected to the root",
            id="a parent that is not there",
        ),
        pytest.param((node("a", "gone", "b"), node("b", "a")), ["a", "b"], "", id="a cut-off tree"),
        pytest.param(
            (node("root", "", "a"), node("a", "root"), node("a", "root")),
            ["root", "a"],
            "1 of its 3 nodes are not connected to the root",
            id="one id twice",
        ),
        pytest.param(
            (node("one"), node("two")),
            ["two"],
            "1 of its 2 nodes are not connected to the root",
            id="two roots",
        ),
        pytest.param((node("root", status=99),), ["root"], "", id="an unknown status"),
    ],
)
def test_of_a_broken_tree_is_shown_what_can_be(behaviours: Any, shown: Any, why: str):
    """And said what is wrong with it."""
    mission = seen(snapshot(*behaviours))
    assert (mission.tree and [one.name for one in mission.tree.nodes]) == shown
    assert mission.state is not None
    assert mission.state.reason == why
    assert (mission.status == "unreadable") is (shown is None)


def test_a_tree_without_an_end_is_cut():
    """Each node has its path: a chain of very many would take all memory."""
    count = MOST_NODES + 10
    chain = [node(f"n{at}", f"n{at - 1}" if at else "", f"n{at + 1}") for at in range(count)]
    mission = seen(snapshot(*chain))
    assert mission.tree is not None
    assert len(mission.tree.nodes) == MOST_NODES
    assert mission.state is not None
    assert mission.state.reason == "only the first 5,000 of its 5,010 nodes are shown"


def test_after_a_broken_snapshot_the_next_one_counts():
    """As a run of its own."""
    good = snapshot(node("root"))
    reader = SnapshotReader()
    first, _, again = reader.take(good), reader.take(snapshot()), reader.take(good)
    runs = [one.run for one in (*first, *again) if isinstance(one, MissionStarted)]
    assert len(set(runs)) == 2
    assert isinstance(again[-1], MissionStateChanged)


def test_statuses_are_told_again_on_request():
    """None where there is no tree."""
    reader = SnapshotReader()
    assert reader.statuses() == []
    reader.take(snapshot(node("root", message="here")))
    (answer,) = reader.statuses()
    assert isinstance(answer, messages.Statuses)
    assert answer.statuses == (messages.NodeStatus(0, Status.RUNNING, "here"),)


def test_a_refusal_is_told_once():
    """Until there is something else to tell."""
    reader = SnapshotReader()
    assert len(reader.refused("why")) == 1
    assert reader.refused("why") == []
