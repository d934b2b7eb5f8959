"""Publishing one message from a mission."""

from __future__ import annotations

from typing import Any

LAMP = "  publish: {topic: lamp, type: std_msgs/msg/Bool, message: {data: legs > 2}}"
HEAD = "mission: t\ninputs: {legs: 3}"


def test_it_publishes_once_somebody_listens(play: Any) -> None:
    """With the values of that moment, and only once."""
    story = play(LAMP, HEAD)
    lamp = story.speeches["lamp"]
    lamp.readers = 0
    assert story.tick() == "R"
    assert story.root.feedback_message == "nobody listens to lamp"
    assert lamp.published == []
    lamp.readers = 1
    assert story.tick() == "S"
    (message,) = lamp.published
    assert message["data"].as_value() is True
    assert story.root.feedback_message == "published to 1"


def test_it_fails_when_nobody_comes(play: Any) -> None:
    """After the server_timeout, exactly."""
    story = play(f"{LAMP}\n  readers: 2\n  server_timeout: 1", HEAD)
    assert story.tick(20) == "R"
    assert story.tick() == "F"
    assert story.executive.reason == "'publish lamp' 1 of 2 listen to lamp after 1 s"
    assert story.speeches["lamp"].published == []


def test_without_readers_it_does_not_wait(play: Any) -> None:
    """``readers: 0``."""
    story = play(f"{LAMP}\n  readers: 0", HEAD)
    story.speeches["lamp"].readers = 0
    assert story.tick() == "S"
    assert len(story.speeches["lamp"].published) == 1
    assert story.root.feedback_message == "published to nobody"
