"""Commands of a person's, typed into a graph on the virtual clock."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from std_msgs.msg import String
from std_srvs.srv import SetBool

from bt_mission.cli import main
from bt_mission.ros import graph_session
from bt_mission.sessions.scripted_server import ScriptedServer
from tests.support.graph import Graph
from tests.support.hand import VirtualHand


@dataclass(frozen=True)
class Typed:
    """What came of a command."""

    code: int
    out: str
    err: str

    @property
    def lines(self) -> list[str]:
        return self.out.splitlines()


@pytest.fixture
def graph(ros: Graph) -> Graph:
    """Two actions, one below a namespace, a topic and a service."""
    ros.server("turn")
    ScriptedServer(ros.node("spinner"), "nav2_msgs/action/Spin", "robot1/spin")
    ros.client.create_publisher(String, "speech", 1)
    ros.client.create_service(SetBool, "switch", lambda _, answer: answer)
    return ros


@pytest.fixture
def hand(ros: Graph) -> VirtualHand:
    """A hand in the graph ``ros``."""
    return VirtualHand(ros)


@pytest.fixture
def type_in(
    hand: VirtualHand, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[..., Typed]:
    """Run ``bt-mission`` with this hand: ``type_in("actions", "list")``."""

    @contextmanager
    def joined(_: str = "") -> Iterator[Any]:
        yield hand

    monkeypatch.setattr(graph_session, "GraphSession", joined)

    def run(*arguments: str) -> Typed:
        code = main(arguments)
        out, err = capsys.readouterr()
        return Typed(code, out, err)

    return run
