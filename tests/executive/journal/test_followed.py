"""Variables that follow topics, in a mission that goes on from its journal."""

from __future__ import annotations

from pathlib import Path

from bt_mission.sessions.load import load
from tests.executive.journal.test_resume import Life, World


def test_what_follows_a_topic_is_read_anew(tmp_path: Path) -> None:
    """A journal keeps no value of it, nor that it has none; the rest waits for the first one."""
    text = (
        "mission: m\nfollow:\n"
        "  - {topic: /b, type: a/msg/B, field: x, as: b}\n"
        "  - {topic: /b, type: a/msg/B, field: y, as: c, initial: 1}\n"
        "tree:\n  sequence:\n    - set: {seen: b}\n    - finally: {timeout: 9}\n"
        "      do: {wait: 0.2}\n      then: {wait: 0.2}\n    - log: $seen $b $c\n"
    )
    life = Life(text, tmp_path / "j", World("finishes"))
    life.play.topics["/b"].publish(x=1, y=2)
    life.tick()
    life.play.topics["/b"].publish(x=float("nan"), y=3)
    life.tick()
    life.die()
    again = Life(text, tmp_path / "j", life.world)
    assert set(again.journal.resume(load(text), "/").variables) == {"/seen"}
    for _ in range(30):
        again.tick()
    assert again.play.executive.ticks == 0
    again.play.topics["/b"].publish(x=5, y=6)
    for _ in range(20):
        again.tick()
    again.die()
    assert again.play.logged[1:] == ["1 5 6"]
    assert again.play.status == "success"
