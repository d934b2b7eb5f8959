"""When each node ran, out of the changes of its status."""

from __future__ import annotations

from collections.abc import Iterable

from bt_mission.recording.model import RUNNING, RecordedChange, Span


def spans_of(
    nodes: int, changes: Iterable[RecordedChange], end_ns: int
) -> tuple[tuple[Span, ...], ...]:
    """The spans of each node, in order.

    :param nodes: how many there are.
    :param end_ns: what still runs at the end ran until then.
    """
    spans: list[list[Span]] = [[] for _ in range(nodes)]
    open_since: dict[int, RecordedChange] = {}
    for change in changes:
        begun = open_since.pop(change.node, None)
        if change.status == RUNNING:
            open_since[change.node] = begun or change
        else:
            start_ns = begun.time_ns if begun else change.time_ns
            spans[change.node].append(Span(start_ns, change.time_ns, change.status, change.message))
    for node, begun in open_since.items():
        spans[node].append(Span(begun.time_ns, max(end_ns, begun.time_ns), RUNNING, begun.message))
    return tuple(map(tuple, spans))
