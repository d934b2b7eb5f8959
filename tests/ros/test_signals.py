"""Signals of a mission that runs, by what its topics tell."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.executive.behaviours.action_leaf import ActionLeaf
from bt_mission.executive.events.events import EventStream, NodeChanged
from bt_mission.requirements.language.syntax import SignalValue
from bt_mission.ros.signals import LiveSignals


class Run:
    """A mission's runner whose topics a test plays; they are all there from the start."""

    def __init__(self) -> None:
        self.listeners: list[Callable[[Any], None]] = []
        self.now_ns = 0
        self.executive = SimpleNamespace(nodes=(), events=EventStream(), started_ns=0)
        self.node = SimpleNamespace(
            resolve_topic_name=lambda name: f"/{name}",
            get_publishers_info_by_topic=lambda _: [SimpleNamespace(topic_type="a/msg/B")],
        )

    def subscriber(self, _topic: str, _type_name: str, _kind: Any) -> Any:
        """Return the only topic."""
        return SimpleNamespace(listen=self.listeners.append)

    def odometry(self, x: float, y: float) -> None:
        """Publish a place."""
        position = SimpleNamespace(x=x, y=y)
        for listener in self.listeners:
            listener(SimpleNamespace(pose=SimpleNamespace(pose=SimpleNamespace(position=position))))


def signal(text: str) -> SignalValue:
    """Return a signal without arguments."""
    return SignalValue(0, text)


def test_the_length_of_a_path_counts_messages_that_nobody_reads() -> None:
    """There and back is not nowhere, however rarely it is asked for."""
    run = Run()
    signals = LiveSignals(run)  # type: ignore[arg-type]
    read = signals.reader(signal("distance"))
    assert callable(read)
    signals.listen()
    assert read() is None
    for x, y in ((0, 0), (3, 0), (3, 4), (0, 0)):
        run.odometry(x, y)
    assert read() == pytest.approx(3 + 4 + 5)
    assert read() == pytest.approx(3 + 4 + 5)


def test_all_who_ask_for_a_signal_get_the_same_reader() -> None:
    """By which requirements of one signal are found to be such."""
    signals = LiveSignals(Run())  # type: ignore[arg-type]
    assert signals.reader(signal("distance")) is signals.reader(signal("distance"))
    assert signals.reader(signal("time")) is not signals.reader(signal("distance"))


def test_the_outcome_of_a_leaf_is_that_of_its_newest_goal() -> None:
    """By the name of the leaf; a leaf that runs again has none."""
    run = Run()
    leaf = object.__new__(ActionLeaf)
    leaf.name, leaf.status = "turn", Status.INVALID
    ending = SimpleNamespace(outcome="aborted")
    leaf.attempt = SimpleNamespace(ending=ending)  # type: ignore[assignment]
    run.executive.nodes, run.executive.path_of = (leaf,), lambda _: "0"
    signals = LiveSignals(run)  # type: ignore[arg-type]
    aborted = signals.reader(SignalValue(0, "outcome", ("turn", "aborted")))
    rejected = signals.reader(SignalValue(0, "outcome", ("turn", "rejected")))
    assert callable(aborted)
    assert callable(rejected)
    assert not aborted()
    run.executive.events.emit(NodeChanged(0, 0, Status.FAILURE, ""))
    assert (aborted(), rejected()) == (True, False)
    run.executive.events.emit(NodeChanged(1, 0, Status.RUNNING, ""))
    signals.forget()
    assert not aborted()


ROUND = """\
  sequence:
    - repeat: {count: 2}
      do: {turn: {angle: 90}, name: first, timeout: 9}
    - {turn: {angle: 45}, name: second, timeout: 9}
"""


def test_what_has_ended_stays_known_after_a_revision(play: Callable[..., Any]) -> None:
    """Outcomes and statuses are those of the same nodes, wherever they stand in the new tree."""
    played = play(ROUND)
    signals = LiveSignals(SimpleNamespace(executive=played.executive))  # type: ignore[arg-type]

    def seen() -> dict[str, object]:
        kinds = [("outcome", name, word) for name in ("first", "second") for word in OUTCOMES_SEEN]
        asked = [*kinds, ("succeeded", "first"), ("running", "second"), ("succeeded", "second")]
        readers = {words: signals.reader(SignalValue(0, words[0], words[1:])) for words in asked}
        return {" ".join(words): read() for words, read in readers.items() if read()}  # type: ignore[operator]

    for _ in range(2):
        played.tick()
        played.turn.accept()
        played.tick()
        played.turn.succeed()
        played.tick()
    signals.forget()
    known = {"outcome first succeeded": True, "succeeded first": True, "running second": True}
    assert seen() == known
    played.revise(
        "mission: test\ntree:\n" + ROUND.replace("sequence:", "sequence:\n    - log: new")
    )
    assert [node.name for node in played.executive.nodes][1] == "log"
    signals.forget()
    assert seen() == known
    played.turn.accept()
    played.turn.abort()
    played.tick()
    assert seen()["outcome second aborted"]


OUTCOMES_SEEN = ("succeeded", "aborted", "canceled")


def test_a_late_success_is_no_success(play: Callable[..., Any]) -> None:
    """`outcome("first") == "succeeded"` does not hold; "canceled" stands for several outcomes."""
    played = play(ROUND.replace("timeout: 9", "timeout: 1"))
    signals = LiveSignals(SimpleNamespace(executive=played.executive))  # type: ignore[arg-type]
    words = (*OUTCOMES_SEEN, "succeeded late", "canceled by timeout")
    readers = [signals.reader(SignalValue(0, "outcome", ("first", word))) for word in words]
    played.tick()
    played.turn.accept()
    played.tick(22)
    played.turn.succeed()
    played.tick()
    assert [read() for read in readers] == [False, False, False, True, False]  # type: ignore[operator]
