"""The content of the panels of a viewer, in rows of spans."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from textwrap import wrap

from py_trees.common import Status
from rich.cells import cell_len, set_cell_size

from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.base.verdicts import FAILING, UNTESTED, VERDICTS
from bt_mission.executive.events.events import FINAL, OPEN, RequirementChanged
from bt_mission.executive.events.log import LogEntry
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.robot_state import RobotState
from bt_mission.views.terminal.marks import Marks, Span, clean, stopwatch
from bt_mission.views.terminal.tree_rows import STATUS_STYLES, time_in_state

Rows = list[list[Span]]

SHORT = 8
"""Characters of a number that is shown with all its digits."""

GOAL_STATUSES = {
    "succeeded": Status.SUCCESS,
    "aborted": Status.FAILURE,
    "rejected": Status.FAILURE,
    "lost": Status.FAILURE,
    "unknown": Status.FAILURE,
    "canceled": Status.INVALID,
}
"""The sign of a goal's state; the sign of other states is that of running."""

VERDICT_SIGNS: dict[str, Status] = {
    "violated": Status.FAILURE,
    "not exercised": Status.FAILURE,
    "open": Status.RUNNING,
    "holds": Status.SUCCESS,
}
"""The signs of verdicts; that of others is the one of nodes that have not run."""

LONGEST_NAME = 32
"""Characters of a requirement's name before its result."""

STATE_STATUSES = {
    "recovering": Status.RUNNING,
    "running": Status.RUNNING,
    "ending": Status.RUNNING,
    "observing": Status.RUNNING,
    "success": Status.SUCCESS,
    "failure": Status.FAILURE,
    "interrupted": Status.FAILURE,
    **dict.fromkeys((*FAILING, UNTESTED), Status.FAILURE),
}


def header(
    mission: MissionState,
    robot: RobotState,
    factor: float | None,
    marks: Marks,
    file_note: str = "",
) -> list[Span]:
    """Return name, state and reason, time, pace and battery of a mission, most important first."""
    tree, state = mission.tree, mission.state
    spans: list[Span] = []
    reason = ""
    name = tree.mission if tree else state.mission if state else ""
    spans.append((name or "no mission", "title"))
    if state is not None:
        word, reason = mission.conclusion
        status = STATE_STATUSES.get(word, Status.INVALID)
        style = "paused" if state.status == "paused" else STATUS_STYLES[status]
        sign = "" if status is Status.INVALID else f"{marks.status[status]} "
        spans += [("  ", ""), (f"{sign}{word}", style)]
    for word, count in Counter(each.verdict for each in mission.failing).items():
        sign = marks.status[Status.FAILURE]
        spans.append((f"  {sign} {count} of {len(mission.requirements)} {word}", "failure"))
    if file_note:
        spans.append((f"  {file_note}", "paused"))
    if tree is not None:
        spans.append((f"  {seconds(mission.elapsed_ns / NS)}", ""))
    if factor is not None and mission.status not in FINAL:
        spans.append((f"  {factor:.1f} x", ""))
    if (charge := robot.charge) is not None:
        spans.append((f"  battery {charge:.0f} %", "failure" if charge < 15 else ""))
    if reason:
        spans.append((f"  {reason}", "words"))
    return spans


def path(names: Sequence[str], width: int, marks: Marks) -> list[Span]:
    """Return the path from the root to the running node; a long one keeps its end."""
    spans: list[Span] = []
    shown = [clean(name, marks) for name in names]
    cut: list[str] = []
    while len(shown) > 1 and len(marks.then.join([*cut, *shown])) > width:
        shown, cut = shown[1:], [marks.cut]
    if len(marks.then.join([*cut, *shown])) <= width:
        shown = [*cut, *shown]
    for number, name in enumerate(shown):
        if number:
            spans.append((marks.then, "words"))
        spans.append((name, "running" if number == len(shown) - 1 else ""))
    return spans


def log_rows(entries: Iterable[LogEntry], start_ns: int, marks: Marks) -> Rows:
    """A row for each entry, with the time since the start."""
    return [
        [(f"{(entry.time_ns - start_ns) / 1e9:8.2f}  ", "time"), *log_words(entry, marks)]
        for entry in entries
    ]


def log_words(entry: LogEntry, marks: Marks) -> list[Span]:
    """An entry without its time."""
    style = "" if entry.status is None else STATUS_STYLES[entry.status]
    sign = " " if entry.status is None else marks.status[entry.status]
    spans: list[Span] = [(f"{sign} ", style)]
    if entry.name:
        spans.append((entry.name, style or "title"))
    if entry.text:
        spans.append((f"  {entry.text}", "words") if entry.name else (entry.text, ""))
    return spans


def goal_rows(mission: MissionState, marks: Marks) -> Rows:
    """Every goal and its state: those that are open first, the newest on top."""
    goals = list(mission.goals.values())[::-1]
    rows: Rows = []
    for goal in sorted(goals, key=lambda known: known.state not in OPEN):
        status = GOAL_STATUSES.get(goal.state, Status.RUNNING)
        end_ns = mission.now_ns if goal.state in OPEN else mission.goals_changed_ns[goal.id]
        rows.append(
            [
                (f"{marks.status[status]} {goal.state:<9} ", STATUS_STYLES[status]),
                (f"{stopwatch(max(end_ns - goal.sent_ns, 0)):>7}  ", "time"),
                (goal.action, ""),
                (f"  {goal.owner}  {goal.id[:8]}", "words"),
            ]
        )
    return rows


def goals_title(mission: MissionState) -> str:
    """Return how many were sent, and how many of them are open."""
    if mission.goals_sent is None:
        return "goals"
    are_open = sum(goal.state in OPEN for goal in mission.goals.values())
    return f"goals: {mission.goals_sent} sent, {are_open} open"


def variable_rows(mission: MissionState, marks: Marks) -> Rows:
    """Return name and value of each variable."""
    width = min(max((len(name) for name in mission.variables), default=0), 24)
    return [
        [(f"{clean(name, marks):<{width}} ", "title"), (_short(value), "")]
        for name, value in mission.variables.items()
    ]


def _short(value: str) -> str:
    """Return a variable's value; of a number's digits the first six."""
    try:
        return value if len(value) <= SHORT else f"{float(value):.6g}"
    except ValueError:
        return value


def requirement_rows(mission: MissionState, marks: Marks) -> Rows:
    """Return verdict, name and margin of each requirement: the violated ones first, then in order.

    The margin is the smallest so far.
    """
    order: tuple[str, ...] = VERDICTS
    known = sorted(
        mission.requirements,
        key=lambda requirement: (
            order.index(requirement.verdict) if requirement.verdict in order else len(order)
        ),
    )
    wide = max([8, *(len(requirement.verdict) for requirement in known)])
    width = min(
        max((cell_len(clean(requirement.name, marks)) for requirement in known), default=0),
        LONGEST_NAME,
    )
    margins = [_margin(requirement) for requirement in known]
    room = max(map(len, margins), default=0)
    rows: Rows = []
    for requirement, margin in zip(known, margins, strict=True):
        status = VERDICT_SIGNS.get(requirement.verdict, Status.INVALID)
        name = clean(requirement.name, marks)
        if cell_len(name) > width:
            name = set_cell_size(name, width - 1) + marks.cut
        reasons = filter(None, (requirement.why, *requirement.sources))
        rows.append(
            [
                (
                    f"{marks.status[status]} {requirement.verdict:<{wide}} ",
                    STATUS_STYLES[status],
                ),
                (set_cell_size(name, width), "title"),
                (
                    f" {margin:>{room}}",
                    STATUS_STYLES[status] if requirement.verdict != "open" else "",
                ),
                ("" if requirement.at is None else f"  at {seconds(requirement.at)}", "time"),
                (f"  {'; '.join(reasons)}".rstrip(), "words"),
                (f"  {requirement.requirement}", "words"),
            ]
        )
    return rows


def _margin(requirement: RequirementChanged) -> str:
    return (
        ""
        if requirement.margin is None
        else f"{requirement.margin:+.4g} {requirement.unit}".rstrip()
    )


def requirements_title(mission: MissionState) -> str:
    """Return how many there are of each verdict."""
    counts = Counter(requirement.verdict for requirement in mission.requirements)
    parts = [f"{counts[verdict]} {verdict}" for verdict in VERDICTS if counts[verdict]]
    return f"requirements: {', '.join(parts)}" if parts else "requirements"


def node_rows(mission: MissionState, index: int, width: int, marks: Marks) -> Rows:
    """Return all facts of one node, as whole texts."""
    if mission.tree is None:
        return []
    node, shown = mission.tree.nodes[index], mission.current(index)
    status = shown.status
    word = "not run" if status is Status.INVALID else status.value.lower()
    row: list[Span] = [(f"{marks.status[status]} {word}", STATUS_STYLES[status])]
    if time := time_in_state(mission, index):
        row.append((f" for {time}" if status is Status.RUNNING else f", ran {time}", "time"))
    if shown.time_ns is not None:
        row.append((f", since {seconds((shown.time_ns - mission.tree.time_ns) / NS)}", "time"))
    kind = [(f"{node.kind}, path {node.path}", "words")]
    rows: Rows = [[(node.name, "title")], row, kind]
    rows += _wrapped(clean(shown.message, marks), width, "")
    rows += _wrapped(clean(", ".join(mission.details(index)), marks), width, "words")
    return rows + _goal_of(mission, node.name, marks) + _ends(mission, index, marks)


def _wrapped(words: str, width: int, style: str) -> Rows:
    return [[(line, style)] for line in wrap(words, max(width, 10))]


def _goal_of(mission: MissionState, owner: str, marks: Marks) -> Rows:
    """The newest goal of a node."""
    for goal in reversed(mission.goals.values()):
        if goal.owner == owner:
            status = GOAL_STATUSES.get(goal.state, Status.RUNNING)
            words = f"  goal {goal.id[:8]} at {goal.action}"
            return [
                [(f"{marks.status[status]} {goal.state}", STATUS_STYLES[status]), (words, "words")]
            ]
    return []


def _ends(mission: MissionState, index: int, marks: Marks) -> Rows:
    """Return the earlier ends of a node, the newest first."""
    assert mission.tree is not None
    stands = mission.current(index).status in (Status.SUCCESS, Status.FAILURE)
    rows: Rows = []
    for end in reversed(mission.ends[index][:-1] if stands else mission.ends[index]):
        word = "halted" if end.status is Status.INVALID else end.status.value.lower()
        row: list[Span] = [("before: ", "words")]
        row.append((f"{marks.status[end.status]} {word}", STATUS_STYLES[end.status]))
        if end.time_ns is not None:
            row.append((f" at {seconds((end.time_ns - mission.tree.time_ns) / NS)}", "time"))
        if end.ran_ns is not None:
            row.append((f", ran {stopwatch(end.ran_ns)}", "time"))
        rows.append([*row, (f"  {end.message}", "words")] if end.message else row)
    return rows


def map_title(robot: RobotState) -> str:
    """Return the pose of the robot."""
    pose = robot.pose
    if pose is None:
        return "map"
    frame = f" in {robot.frame}" if robot.frame not in ("", "map") else ""
    return f"map: x {pose.x:.2f}  y {pose.y:.2f} m{frame}"
