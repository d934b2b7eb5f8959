"""How far a node has discovered the participants of its graph."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any, Protocol

from bt_mission.base.wall_clock import Stopwatch

SETTLE_S = 0.6
"""Wall time without a new participant or node after which a graph counts as discovered."""

DISCOVERY_S = 6.0
"""Longest wall time of a discovery, s: twice the time between two announcements of Fast DDS."""

_SOCKETS = tuple(Path("/proc/net") / name for name in ("udp", "udp6"))
_MOST = 120
"""Participants of a domain on one machine (DDSI-RTPS, 9.6.1.1)."""


class ParticipantGraph(Protocol):
    """The methods of a node that are used."""

    @property
    def context(self) -> Any:
        """The context, which has the domain."""

    def get_publishers_info_by_topic(self, topic_name: str, no_mangle: bool) -> Sequence[Any]:  # noqa: FBT001 - rclpy's
        """Return the publishers of a topic."""

    def get_node_names_and_namespaces(self) -> Sequence[tuple[str, str]]:
        """Return the nodes of the graph."""


class Discovery:
    """Whether a node has discovered its graph, by the time that passes between two looks.

    A participant on this machine holds a port as long as it lives, so those that are not discovered
    yet can be counted. Those of other machines can not: they answer at once unless a packet is
    lost.
    """

    def __init__(self, node: ParticipantGraph) -> None:
        self._node = node
        self._since = Stopwatch()
        self._since_change = self._since
        self._known: object = None

    def is_over(self) -> bool:
        """Return whether all is discovered, or the time for it has passed."""
        participants = participants_of(self._node)
        known = (participants, sorted(self._node.get_node_names_and_namespaces()))
        if known != self._known:
            self._known, self._since_change = known, Stopwatch()
        if self._since.elapsed_s > DISCOVERY_S:
            return True
        is_missing = len(participants) < living_participants(self._node.context.get_domain_id())
        return not is_missing and self._since_change.elapsed_s > SETTLE_S


def participants_of(node: ParticipantGraph) -> Collection[bytes]:
    """Return the GUIDs of the participants that a node has discovered, its own included."""
    publishers = node.get_publishers_info_by_topic("ros_discovery_info", no_mangle=True)
    return {bytes(publisher.endpoint_gid)[:12] for publisher in publishers}


def living_participants(domain_id: int, sockets: Sequence[Path] = _SOCKETS) -> int:
    """Return how many participants of a DDS domain have a port of this machine.

    Their unicast ports are those of the DDSI-RTPS specification, section 9.6.1.1:
    7400 + 250 domain + 10 + 2 participant. The system lists the ports of all processes.
    """
    first = 7400 + 250 * domain_id + 10
    ports = range(first, first + 2 * _MOST, 2)
    return len(set(ports) & {port for path in sockets for port in _ports(path)})


def _ports(path: Path) -> Sequence[int]:
    """Return the local ports of a table of sockets; none where there is no such table."""
    try:
        lines = path.read_text(encoding="ascii").splitlines()[1:]
    except OSError:
        return ()
    return [int(line.split()[1].rpartition(":")[2], 16) for line in lines]
