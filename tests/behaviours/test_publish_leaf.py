"""Publishing one message from a mission."""

from __future__ import annotations

from typing import Any

LAMP = "  publish: {topic: lamp, type: std_msgs/msg/Bool, message: {data: legs > 2}}"
HEAD = "mission: t\ninputs: {legs: 3}"


def test_it_publishes_once_somebody_listens(play: Any) -> None:
    """With the values of that moment, and only once."""
    run = play(LAMP, HEAD)
    lamp = run.speeches["lamp"]
    lamp.readers = 0
    assert run.tick() == "R"
    assert run.root.feedback_message == "nobody listens to lamp"
    assert lamp.published == []
    lamp.readers = 1
    assert run.tick() == "S"
    (message,) = lamp.published
    assert message["data"].as_value() is True
    assert run.root.feedback_message == "published to 1"


def test_it_fails_when_nobody_comes(play: Any) -> None:
    """After the server_timeout, exactly."""
    run = play(f"{LAMP}\n  readers: 2\n  server_timeout: 1", HEAD)
    assert run.tick(20) == "R"
    assert run.tick() == "F"
    assert run.executive.reason == "'publish lamp' 1 of 2 listen to lamp after 1 s"
    assert run.speeches["lamp"].published == []


def test_without_readers_it_does_not_wait(play: Any) -> None:
    """``readers: 0``."""
    run = play(f"{LAMP}\n  readers: 0", HEAD)
    run.speeches["lamp"].readers = 0
    assert run.tick() == "S"
    assert len(run.speeches["lamp"].published) == 1
    assert run.root.feedback_message == "published to nobody"
