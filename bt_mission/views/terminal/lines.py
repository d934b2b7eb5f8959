"""A mission as plain lines: its events, its tree once, and the results of its leaves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TextIO

from py_trees.common import Status
from rich.cells import cell_len, set_cell_size

from bt_mission.base.stamps import NS
from bt_mission.base.text import escape_control, seconds
from bt_mission.executive.events.events import NodeChanged, RequirementChanged, RunStarted
from bt_mission.executive.events.log import LOG_KIND, LogEntry, glyphs_for, mission_state, verdict
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.executive import Executive
from bt_mission.executive.leaf_statistics import LeafSummary
from bt_mission.executive.status import MissionStatus
from bt_mission.views.terminal.marks import Marks, clean, fit, text_of
from bt_mission.views.terminal.panels import log_words, requirement_rows
from bt_mission.views.terminal.tree_rows import Outline, tree_row

LONGEST_NAME = 28
OUTCOME_WORDS = {"success": "succeeded", "failure": "failed"}
"""Ends of leaves without a goal, in the words for goals."""

MOST_ROWS = 20
"""The number of leaves in the table: those that ran longest."""


class ControlLines:
    """Reports requests to a mission: breakpoints, steps, pauses."""

    def __init__(self, executive: Executive) -> None:
        self._executive = executive
        self._steps = executive.steps
        self._revisions = executive.revisions
        self._pause = ""
        self._breakpoints: tuple[str, ...] = ()

    def take(self) -> Iterator[str]:
        """Yield a line for each request since the last call."""
        executive = self._executive
        before, self._breakpoints = self._breakpoints, executive.breakpoints.names
        for name in self._breakpoints:
            if name not in before:
                yield f"breakpoint set at '{executive.breakpoints.node_name(name)}'"
        for name in before:
            if name not in self._breakpoints:
                yield f"breakpoint removed from '{executive.breakpoints.node_name(name)}'"
        if executive.revisions != self._revisions:
            self._revisions = executive.revisions
            yield f"mission revised ({self._revisions})"
        if executive.steps != self._steps:
            self._steps = executive.steps
            yield "mission stepped"
        is_paused = executive.status is MissionStatus.PAUSED
        pause = executive.mission_state.explanation if is_paused else ""
        if pause != self._pause:
            self._pause = pause
            if pause:
                yield "  ".join(filter(None, mission_state("paused", pause)))
            elif executive.status.is_active:
                yield "mission running"


def timed(time_ns: int, text: str) -> str:
    """Return a line with the time since the start before it, ns."""
    return f"{seconds(time_ns / NS):>11}  {text}".rstrip()


class PlainLines:
    """Writes a line whenever a leaf starts or ends, or a request changes the mission.

    Args:
        stream: The output.
        executive: Of the mission.
        start_ns: Returns the ROS time of the start; lines show seconds since then.
        now_ns: Returns the ROS time.
        who: The prefix of each line, after the time: the robot.
    """

    def __init__(
        self,
        stream: TextIO,
        executive: Executive,
        start_ns: Callable[[], int],
        now_ns: Callable[[], int],
        *,
        who: str = "",
    ) -> None:
        self._stream = stream
        self._who = who
        self._start_ns = start_ns
        self._now_ns = now_ns
        self._executive = executive
        self._controls = ControlLines(executive)
        self._glyphs = glyphs_for(stream.encoding)

    def refresh(self) -> None:
        """Show what others have done to the mission."""
        for line in self._controls.take():
            self.say(line)

    def on_change(self, event: NodeChanged) -> None:
        """Show a change of a leaf's status; composites follow from their leaves."""
        self.refresh()
        node, status = self._executive.node_infos[event.node], event.status
        is_leaf = self._executive.mission_state.is_leaf[event.node]
        if event.time_ns is None or not is_leaf or node.kind == LOG_KIND:
            return  # the lines of a log leaf are shown unchanged
        words = "" if status is Status.RUNNING else event.message
        self._line(event.time_ns, f"{self._glyphs[status]} {node.name}  {words}")

    def say(self, text: str) -> None:
        """Show a line of a mission."""
        self._line(self._now_ns(), f"  {text}")

    def _line(self, time_ns: int, text: str) -> None:
        line = timed(time_ns - self._start_ns(), self._who + escape_control(text))
        print(line, file=self._stream, flush=True)


# ---- a watched mission ------------------------------------------------------------------------


def title(mission: MissionState, marks: Marks) -> str:
    """Return mission, state and time in one line."""
    tree, state = mission.tree, mission.state
    name = tree.mission if tree else state.mission if state else ""
    parts = [name or "no mission yet"]
    if tree is not None:
        parts.append(seconds(mission.elapsed_ns / NS))
    if state is not None:
        parts.append(verdict(*mission.conclusion))
    return clean("   ".join(parts), marks)


def whole_tree(mission: MissionState, marks: Marks, width: int | None) -> Iterator[str]:
    """Return every node in a separate line.

    Args:
        width: The width at which lines are cut; None does not cut.
    """
    yield title(mission, marks)
    if mission.tree is None:
        return
    outline = Outline(mission.tree.nodes)
    for index in outline.rows:
        row = tree_row(mission, outline, index, width or 10_000, marks)
        yield text_of(fit(row, width, marks)).rstrip()
    if mission.requirements:
        yield "requirements"
    for row in requirement_rows(mission, marks):
        yield "  " + text_of(fit(row, None if width is None else width - 2, marks)).rstrip()


class RequirementLines:
    """Reports new verdicts of requirements.

    Args:
        known: Verdicts that were reported already.
    """

    def __init__(self, known: Iterable[RequirementChanged] = ()) -> None:
        self._verdicts = {change.name: change.verdict for change in known}

    def take(self, change: RequirementChanged, tree: RunStarted | None) -> Iterator[str]:
        """Yield a line for a new verdict; the mission itself logs a violation."""
        before = self._verdicts.get(change.name, "open")
        is_known = change.name in self._verdicts and change.verdict == "violated"
        self._verdicts[change.name] = change.verdict
        if tree is not None and change.verdict != before and not is_known:
            text = escape_control(f"  requirement {change.name}: {change.outcome}")
            yield timed(change.time_ns - tree.time_ns, text)


def log_line(entry: LogEntry, start_ns: int, marks: Marks) -> str:
    """A line of the log, with the time since the start."""
    return timed(entry.time_ns - start_ns, text_of(fit(log_words(entry, marks), None, marks)))


# ---- leaves ----------------------------------------------------------------------------------


def leaf_table(leaves: Sequence[LeafSummary], width: int, marks: Marks) -> list[str]:
    """Return a line for each leaf that took time or did not succeed; no lines without one."""
    unusual = [leaf for leaf in leaves if leaf.running_s > 0 or set(leaf.outcomes) != {"success"}]
    longest = sorted(unusual, key=lambda leaf: -leaf.running_s)[:MOST_ROWS]
    shown = [leaf for leaf in unusual if leaf in longest]
    if not shown:
        return []
    has_distance = any(leaf.distance_m is not None for leaf in shown)
    rows = [["leaf", "runs", "time", *(["driven"] if has_distance else []), "outcomes"]]
    rows += [_row(leaf, marks, has_distance=has_distance) for leaf in shown]
    widths = [max(cell_len(row[at]) for row in rows) for at in range(len(rows[0]) - 1)]
    lines = []
    for name, *figures, outcomes in rows:
        line = f"  {name}{' ' * (widths[0] - cell_len(name))}"
        for figure, room in zip(figures, widths[1:], strict=True):
            line += f"  {figure:>{room}}"
        lines.append(text_of(fit([(f"{line}  {outcomes}", "")], width, marks)).rstrip())
    if len(unusual) > len(shown):
        lines.append(f"  and {len(unusual) - len(shown)} leaves that ran for less time")
    return lines


def _row(leaf: LeafSummary, marks: Marks, *, has_distance: bool) -> list[str]:
    name = clean(leaf.name, marks)
    if cell_len(name) > LONGEST_NAME:
        name = set_cell_size(name, LONGEST_NAME - 1) + marks.cut
    row = [name, str(leaf.runs), seconds(leaf.running_s)]
    if has_distance:
        row.append("" if leaf.distance_m is None else f"{leaf.distance_m:.2f} m")
    outcomes = Counter[str]()
    for what, count in leaf.outcomes.items():
        outcomes[OUTCOME_WORDS.get(what, what)] += count
    only = len(outcomes) == 1
    counts = outcomes.most_common()
    return [*row, ", ".join(what if only else f"{count} {what}" for what, count in counts)]
