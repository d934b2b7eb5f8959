"""Who is watched."""

from __future__ import annotations

import pytest

from bt_mission.base.errors import BtMissionError
from bt_mission.executive.events.source import (
    Attachment,
    AttachmentChange,
    ListedExecutive,
    choose,
    nobody,
    wanted_name,
)
from tests.support.watched import ScriptedExecutive, ScriptedGraph

ONE, TWO = ListedExecutive("/robot1/bt_mission"), ListedExecutive("/robot2/bt_mission")


def test_the_only_one_is_taken_when_it_comes():
    """And kept when another one comes."""
    first, second = (ScriptedExecutive(name=f"/robot{n}/bt_mission") for n in (1, 2))
    first.is_there = second.is_there = False
    attachment = Attachment(ScriptedGraph(first, second), None)
    assert attachment.look() == AttachmentChange(nobody(None, (), "a test"), is_nobody=True)
    first.is_there = True
    assert attachment.look() == AttachmentChange(is_new=True)
    second.is_there = True
    assert attachment.look() == AttachmentChange()
    assert attachment.source is first


def test_of_several_the_user_chooses():
    """A name decides without a question."""
    first, second = (ScriptedExecutive(name=f"/robot{n}/bt_mission") for n in (1, 2))
    attachment = Attachment(ScriptedGraph(first, second), None)
    assert attachment.look() == AttachmentChange(is_choice=True)
    attachment.attach(second.name)
    assert attachment.source is second
    named = Attachment(ScriptedGraph(first, second), first.name)
    assert named.look().is_new
    assert named.source is first


def test_another_version_is_left_and_waited_for():
    """Until the one that is installed here is back, also if two share its name."""
    executive = ScriptedExecutive()
    graph = ScriptedGraph(executive)
    attachment = Attachment(graph, None)
    attachment.look()
    graph.faults[executive.name] = ListedExecutive(
        executive.name, "of another version", is_foreign=True
    )
    attachment.look()
    assert (executive.closed, attachment.source) == (True, None)
    assert attachment.look() == AttachmentChange("/bt_mission: of another version")
    shared = "2 executives share this name"  # nothing better can be done from here
    graph.faults[executive.name] = ListedExecutive(executive.name, shared)
    assert attachment.look() == AttachmentChange(shared, is_new=True)
    graph.faults.clear()
    assert attachment.look() == AttachmentChange()


@pytest.mark.parametrize(
    ("text", "name"),
    [
        *((text, "/robot1/bt_mission") for text in ("robot1", "/robot1", "/robot1/")),
        ("/robot1/bt_mission", "/robot1/bt_mission"),
        *((text, "/bt_mission") for text in ("bt_mission", "/bt_mission", "/")),
        (None, None),
    ],
)
def test_a_namespace_or_a_name_will_do(text: str | None, name: str | None):
    """People type what they have at hand; `bt_mission` and `/` mean the same."""
    assert wanted_name(text) == name


def test_the_only_one_is_chosen():
    """Also by name among several."""
    assert choose([ONE], None) is ONE
    assert choose([ONE, TWO], "/robot2/bt_mission") is TWO
    assert choose([], None) is None
    assert choose([ONE], "/robot2/bt_mission") is None


def test_of_several_one_has_to_be_named():
    """The message lists them."""
    with pytest.raises(BtMissionError) as caught:
        choose([ONE, TWO], None)
    assert str(caught.value) == (
        "2 executives: choose one of /robot1/bt_mission, /robot2/bt_mission"
    )


def test_another_version_is_refused():
    """Its messages would be read as what they are not."""
    with pytest.raises(BtMissionError, match="/a/bt_mission: its Tree messages are of another"):
        choose(
            [ListedExecutive("/a/bt_mission", "its Tree messages are of another", is_foreign=True)],
            None,
        )


def test_nobody_there_is_told_with_what_was_looked_for():
    """And what can be watched; with the names of others that are there."""
    assert "an executive was not found (ROS domain 7)" in nobody(None, [], "ROS domain 7")
    assert "--visible" in nobody(None, [], "")
    assert nobody("/b/bt_mission", [ONE], "x") == (
        "no executive /b/bt_mission (x); available: /robot1/bt_mission"
    )
