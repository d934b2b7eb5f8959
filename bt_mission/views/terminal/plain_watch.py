"""A watched mission as plain lines: the tree once, and what happens."""

from __future__ import annotations

from collections.abc import Iterator

from bt_mission.events.log import LogEntry
from bt_mission.events.mission_state import WatchedMission
from bt_mission.views.terminal.marks import Marks, clean
from bt_mission.views.terminal.outline import Outline
from bt_mission.views.terminal.tree_rows import tree_row
from bt_mission.views.terminal.words import fit, seconds, text_of


def title(mission: WatchedMission, marks: Marks) -> str:
    """Mission, state and time in one line."""
    tree, state = mission.tree, mission.state
    name = clean(tree.mission if tree else state.mission if state else "", marks)
    parts = [name or "no mission yet"]
    if tree is not None:
        parts.append(seconds(mission.elapsed_ns))
    if state is not None:
        parts.append(state.status + (f": {clean(state.reason, marks)}" if state.reason else ""))
    return "   ".join(parts)


def whole_tree(mission: WatchedMission, marks: Marks, width: int | None) -> Iterator[str]:
    """Every node in a line of its own.

    :param width: where lines are cut; None leaves them whole.
    """
    yield title(mission, marks)
    if mission.tree is None:
        return
    outline = Outline(mission.tree.nodes)
    for index in outline.rows:
        row = tree_row(mission, outline, index, width or 10_000, marks)
        yield text_of(fit(row, width, marks) if width else row).rstrip()


def log_line(entry: LogEntry, start_ns: int, marks: Marks) -> str:
    """A line of the log, with the time since the start."""
    time_s = (entry.time_ns - start_ns) / 1e9
    sign = " " if entry.status is None else marks.status[entry.status]
    words = "  ".join(clean(text, marks) for text in (entry.name, entry.text) if text)
    return f"{time_s:9.2f} s  {sign} {words}".rstrip()
