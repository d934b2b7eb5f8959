"""Signals of a mission that runs, by what its topics tell."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status

from bt_mission.behaviours.action_leaf import ActionLeaf
from bt_mission.events.events import EventStream, NodeChanged
from bt_mission.language.requirements.syntax import SignalValue
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
