"""Who is watched."""

from __future__ import annotations

from bt_mission.events.attachment import Attachment, AttachmentNews
from bt_mission.events.source import FoundExecutive
from tests.support.watched import ScriptedExecutive, ScriptedGraph


def test_the_only_one_is_taken_when_it_comes():
    """And kept when another one comes."""
    one, two = (ScriptedExecutive(name=f"/robot{n}/bt_mission") for n in (1, 2))
    one.is_there = two.is_there = False
    attachment = Attachment(ScriptedGraph(one, two), None)
    assert attachment.look() == AttachmentNews("no sign of an executive (a test)")
    one.is_there = True
    assert attachment.look() == AttachmentNews(is_new=True)
    two.is_there = True
    assert attachment.look() == AttachmentNews()
    assert attachment.source is one


def test_of_several_the_user_chooses():
    """A name decides without a question."""
    one, two = (ScriptedExecutive(name=f"/robot{n}/bt_mission") for n in (1, 2))
    attachment = Attachment(ScriptedGraph(one, two), None)
    assert attachment.look() == AttachmentNews(is_choice=True)
    attachment.attach(two.name)
    assert attachment.source is two
    named = Attachment(ScriptedGraph(one, two), one.name)
    assert named.look().is_new
    assert named.source is one


def test_another_version_is_left_and_waited_for():
    """Until the one that is installed here is back."""
    one = ScriptedExecutive()
    graph = ScriptedGraph(one)
    attachment = Attachment(graph, None)
    attachment.look()
    graph.faults[one.name] = FoundExecutive(one.name, "of another version", is_foreign=True)
    attachment.look()
    assert (one.closed, attachment.source) == (True, None)
    assert attachment.look() == AttachmentNews("/bt_mission: of another version")
    graph.faults.clear()
    assert attachment.look() == AttachmentNews(is_new=True)


def test_two_of_one_name_are_taken_with_a_word():
    """Nothing better can be done from here."""
    one = ScriptedExecutive()
    graph = ScriptedGraph(one)
    graph.faults[one.name] = FoundExecutive(one.name, "2 executives share this name")
    assert Attachment(graph, None).look() == AttachmentNews(
        "2 executives share this name", is_new=True
    )
