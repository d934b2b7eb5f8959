"""What a node has discovered of its graph, against what this machine runs."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.ros.executors import participants
from bt_mission.ros.executors.participants import Discovery, living_participants, participants_of

TABLE = """\
  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode
  61: 00000000:{meta:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 1 2 0 0
  62: 00000000:{user:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 2 2 0 0
  63: 0100007F:{second:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 3 2 0 0
  64: 00000000:{multicast:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 4 2 0 0
  65: 00000000:{other:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 5 2 0 0
"""


def test_participants_of_a_domain_are_counted_by_their_first_port(tmp_path: Path) -> None:
    """Neither those of other domains, nor the other ports of each; a missing table has none."""
    first = 7400 + 250 * 31
    ports = {"meta": 10, "user": 11, "second": 12, "multicast": 0, "other": 260}
    table = tmp_path / "udp"
    table.write_text(TABLE.format_map({name: first + port for name, port in ports.items()}))
    assert living_participants(31, (table, tmp_path / "udp6")) == 2
    assert living_participants(32, (table,)) == 1
    assert living_participants(33, (table,)) == 0


class Graph:
    """A graph, its time, and what is discovered of it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s = 0.0
        self.living = 2
        self.known = [b"a"]
        self.names = [("me", "/")]
        graph = self

        class Since:
            def __init__(self) -> None:
                self._start_s = graph.now_s

            @property
            def elapsed_s(self) -> float:
                return graph.now_s - self._start_s

        monkeypatch.setattr(participants, "Stopwatch", Since)
        monkeypatch.setattr(participants, "living_participants", lambda _domain: self.living)
        self.context = SimpleNamespace(get_domain_id=lambda: 31)
        self.discovery = Discovery(self)

    def get_publishers_info_by_topic(self, _name: str, no_mangle: bool) -> list[Any]:  # noqa: FBT001
        assert no_mangle
        return [SimpleNamespace(endpoint_gid=it.ljust(12) + b"\x00\x01\x03") for it in self.known]

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return self.names

    def over_at(self) -> float:
        """Return when the discovery is over."""
        while not self.discovery.is_over():
            self.now_s += 0.125
        return self.now_s


def test_a_graph_is_discovered_when_nothing_has_changed_for_a_while(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """And all participants of this machine are known."""
    graph = Graph(monkeypatch)
    assert participants_of(graph) == {b"a".ljust(12)}
    graph.living = 1
    assert graph.over_at() == 0.625

    graph = Graph(monkeypatch)
    for _ in range(16):
        assert not graph.discovery.is_over()
        graph.now_s += 0.125
    graph.known.append(b"b")
    assert not graph.discovery.is_over()
    graph.now_s = 2.5
    graph.names = [("me", "/"), ("second", "/")]
    assert graph.over_at() == 3.125


def test_a_process_that_does_not_answer_ends_a_discovery(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that is stopped, for instance, keeps its port."""
    assert Graph(monkeypatch).over_at() == 6.125
