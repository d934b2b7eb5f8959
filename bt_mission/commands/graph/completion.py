"""Names of the running graph, for the completion of shells."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_mission.commands.graph.graph_query import LiveKind


def _live(kind: LiveKind, words: list[str]) -> list[str]:
    """Return the names of a kind in the graph that a command line is about."""
    from bt_mission.base.dds.discovery import restrict_discovery
    from bt_mission.base.dds.middleware import prepare_middleware

    restrict_discovery(network="--network" in words)
    prepare_middleware()
    from bt_mission.commands.graph.graph_query import live_names

    return live_names(kind)


complete_actions = partial(_live, "actions")
complete_topics = partial(_live, "topics")
complete_services = partial(_live, "services")
complete_executives = partial(_live, "executives")
complete_namespaces = partial(_live, "namespaces")
