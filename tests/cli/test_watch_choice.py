"""Which executive `watch` takes, and what it says until then."""

from __future__ import annotations

import argparse
from typing import Any

import pytest

from bt_mission.cli import watch
from bt_mission.core import wall_clock
from bt_mission.events.source import ListedExecutive


class Watched:
    """A graph in which executives come up late, on its own clock."""

    where = "a test"

    def __init__(self, come_s: float) -> None:
        self.now_s = 0.0
        self.attached = ""
        self._come_s = come_s

    def serve(self, wall_s: float) -> None:
        """Let time pass."""
        self.now_s += wall_s

    def find(self) -> tuple[ListedExecutive, ...]:
        """All at once."""
        names = ("/r1/bt_mission", "/r2/bt_mission") if self.now_s > self._come_s else ()
        return tuple(ListedExecutive(name) for name in names)

    def attach(self, name: str, **_: Any) -> str:
        """Remember who is watched."""
        self.attached = name
        return name


def looked(
    monkeypatch: pytest.MonkeyPatch, come_s: float, name: str, wait_s: float | None = None
) -> str:
    """Look for an executive; gives whom it found."""
    graph: Any = Watched(come_s)

    class Since:
        def __init__(self) -> None:
            self._start_s = graph.now_s

        @property
        def elapsed_s(self) -> float:
            return float(graph.now_s - self._start_s)

    monkeypatch.setattr(wall_clock, "Stopwatch", Since)
    watch.look_for(graph, argparse.Namespace(executive=name, wait=wait_s))
    return str(graph.attached)


def test_who_comes_up_just_then_is_not_said_to_be_absent(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The list of those that are there would name it."""
    assert looked(monkeypatch, 2.9 * watch.SETTLE_S, "/r2") == "/r2/bt_mission"
    assert capsys.readouterr().err == ""


def test_who_is_there_when_the_time_is_up_is_taken(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where nobody had come up before."""
    assert looked(monkeypatch, 0.9 * watch.SETTLE_S, "/r2", watch.SETTLE_S) == "/r2/bt_mission"
    assert looked(monkeypatch, 0.9 * watch.SETTLE_S, "/r3", watch.SETTLE_S) == ""
    assert "no executive /r3/bt_mission (a test); available:" in capsys.readouterr().err
