"""A node of our own as a process, without the process."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.core.interrupts import InterruptSignals
from bt_mission.executors import process as module


def test_an_exception_stops_the_robot_before_it_ends_the_process(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As a signal does; the command fails with the cause."""
    events: list[str] = []

    def spin_once(**_: Any) -> None:
        raise ValueError("a defect")

    node: Any = SimpleNamespace(
        is_done=False,
        begin=lambda: events.append("begin"),
        end=lambda why, _: events.append(why.partition(" (")[0]),
    )
    executor = SimpleNamespace(add_node=lambda _: None, spin_once=spin_once)
    monkeypatch.setattr(module, "LiveExecutor", lambda: executor)
    with pytest.raises(ValueError, match="a defect"):
        module._serve(node, InterruptSignals(most=1))
    assert events == ["begin", "ValueError: a defect"]
