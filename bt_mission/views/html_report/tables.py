"""What of a run is read rather than looked at: facts, goals, leaves, pictures, the log, files."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from bt_mission.core.text import escape_markup, seconds
from bt_mission.recording.model import RecordedGoal, RecordedLine, RecordedRun
from bt_mission.views.html_report.figures import (
    LeafFigures,
    distance_m,
    leaves,
    mission_s,
    since_start_s,
    way_to_failure,
)
from bt_mission.views.html_report.markup import element, hint, number, rows, table

MOST_LINES = 1000
MOST_GOALS = 500
MOST_PICTURES = 24
MOST_PICTURE_BYTES = 5_000_000
MOST_FIELDS = 12
PATH, TEXT = 48, 160
"""Characters of a value that are shown."""
LEVELS = {10: "debug", 20: "info", 30: "warning", 40: "error", 50: "fatal"}


def facts(run: RecordedRun) -> str:
    """What it was and came to, in a few figures."""
    summary, known = run.summary, run.facts
    distance = distance_m(run)
    left = summary.get("goals_left_behind", 0)
    pairs = [
        ("duration", seconds(mission_s(run))),
        ("distance", None if distance is None else f"{number(distance, 2)} m"),
        ("goals", f"{len(run.goals)}" + (f", {left} orphaned" if left else "")),
        ("collisions", summary.get("collisions", len(run.collisions) or None)),
        ("world", known.get("world")),
        ("robot", known.get("robot")),
        ("seed", known.get("seed")),
    ]
    return element(
        "dl",
        rows(
            element("div", element("dt", name) + element("dd", escape_markup(str(value))))
            for name, value in pairs
            if value is not None
        ),
        class_="facts",
    )


def why(run: RecordedRun) -> str:
    """What failed: the way from the root to the leaf, and what that said."""
    way = way_to_failure(run)
    if len(way) < 2:
        return ""
    steps = " \N{RIGHTWARDS ARROW} ".join(escape_markup(run.tree[node].name) for node in way)
    span = run.spans[way[-1]][-1]
    said = (
        "" if span.message in run.reason else f"<br><strong>{escape_markup(span.message)}</strong>"
    )
    return element(
        "p", f"{steps}, at {seconds(since_start_s(run, span.end_ns))}{said}", class_="why"
    )


def warnings(run: RecordedRun) -> str:
    """What the recording lacks."""
    parts = [text for text in (run.why_cut, run.missing and f"it lacks {run.missing}") if text]
    if not parts:
        return ""
    return element(
        "p", escape_markup("This recording is not whole: " + "; ".join(parts) + "."), class_="lacks"
    )


def goals(run: RecordedRun) -> str:
    """Each goal with its life."""
    if not run.goals:
        return hint("No goal was sent.")
    columns = ("#", "action", "node", "sent", "took", "outcome", "goal", "result")
    lines = [_goal(run, index, goal) for index, goal in enumerate(run.goals[:MOST_GOALS])]
    rest = len(run.goals) - MOST_GOALS
    more = f"{rest} more goals are in the recording." if rest > 0 else ""
    return table(columns, lines, "scroll goals") + hint(more)


def _goal(run: RecordedRun, index: int, goal: RecordedGoal) -> str:
    def since(time_ns: int | None, start_ns: int | None) -> str:
        known = time_ns is not None and start_ns is not None
        return seconds((time_ns - start_ns) / 1e9) if known else "?"  # type: ignore[operator]

    end = goal.status or ("orphaned" if goal.given_up_ns is not None else "no end is known")
    more = []
    if goal.cancel_ns is not None and goal.sent_ns is not None:
        more.append(f"cancel after {since(goal.cancel_ns, goal.sent_ns)}")
    if goal.feedback:
        more.append(f"{len(goal.feedback)} x feedback")
    cells = [
        ("#", str(index + 1)),
        ("action", escape_markup(goal.action)),
        ("node", escape_markup(goal.owner)),
        ("sent", since(goal.sent_ns, run.start_ns)),
        ("took", since(goal.end_ns, goal.sent_ns)),
        (
            "outcome",
            element("span", "", class_=f"dot {goal.status or 'unknown'}")
            + escape_markup(end)
            + "".join(element("small", text) for text in more),
        ),
        ("goal", _values(goal.values)),
        ("result", "" if goal.result is None else _values(goal.result)),
    ]
    return element(
        "tr",
        "".join(
            element("td", content and element("div", content), data_label=name)
            for name, content in cells
        ),
        id=f"goal-{index + 1}",
    )


def _values(values: Mapping[str, Any]) -> str:
    """Fields of a message, one a line, without those that say nothing."""
    lines = [
        f"{escape_markup(name)} <b>{escape_markup(text)}</b>"
        for name, value in _flat("", values)
        if (text := _short(value)) and not (name == "error_code" and value == 0)
    ]
    return element("code", "<br>".join(lines[:MOST_FIELDS])) if lines else ""


def _flat(prefix: str, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """All fields by their dotted names; of messages inside a message, those that are not 0."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(f"{prefix}{name}.", value)
        elif not prefix or (value if isinstance(value, str) else np.any(value)):
            yield f"{prefix}{name}", value


def _short(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case float():
            return number(value)
        case str():
            return _short_text(value)
        case list() | np.ndarray():
            parts = [_short(part) for part in value[:3]]
            text = ", ".join(parts)
            is_short = len(value) <= 3 and len(text) <= PATH
            return text if is_short else f"{len(value)} of them"
        case Mapping():
            return ", ".join(f"{name} {_short(part)}" for name, part in _flat("", value))
        case np.floating():
            return number(float(value))
    return str(value)


def _short_text(value: str) -> str:
    """The end of a path, which tells more, and the beginning of other texts."""
    if value.startswith("/"):
        return value if len(value) <= PATH else f"…{value[1 - PATH :]}"
    return value if len(value) <= TEXT else f"{value[: TEXT - 1]}…"


def leaf_table(run: RecordedRun) -> str:
    """What came of each leaf."""
    return table(
        ("node", "runs", "ended", "in all"),
        (
            element("tr", "".join(element("td", cell) for cell in _leaf(run, leaf)))
            for leaf in leaves(run)[:MOST_LINES]
        ),
    )


def _leaf(run: RecordedRun, leaf: LeafFigures) -> tuple[str, ...]:
    ends = [
        element("span", "", class_=f"dot {status}") + escape_markup(f"{count} {status}")
        for status, count in leaf.ends.items()
    ]
    name, runs = escape_markup(run.tree[leaf.node].name), str(sum(leaf.ends.values()))
    return name, runs, ", ".join(ends), seconds(leaf.seconds)


def pictures(run: RecordedRun) -> str:
    """The run's pictures, spread over it when there are many."""
    if not run.pictures:
        return ""
    step = max(1, -(-len(run.pictures) // MOST_PICTURES))
    chosen, room = [], MOST_PICTURE_BYTES
    for picture in run.pictures[::step]:
        room -= len(picture.data)
        if room < 0:
            break
        chosen.append(picture)
    figures = []
    for picture in chosen:
        at = seconds(since_start_s(run, picture.time_ns))
        data = base64.b64encode(picture.data).decode()
        image = (
            f'<img src="data:{escape_markup(picture.media_type)};base64,{data}" '
            f'alt="{escape_markup(picture.name)}">'
        )
        caption = element("figcaption", f"{escape_markup(picture.name.rpartition('/')[2])}, {at}")
        figures.append(element("figure", image + caption))
    rest = len(run.pictures) - len(chosen)
    more = f"{rest} more are in the recording." if rest else ""
    return element("div", rows(figures), class_="pictures") + hint(more)


def log(run: RecordedRun) -> str:
    """What was said."""
    if not run.log:
        return hint("Nothing was said.")
    lines = _chosen(run.log)
    body = rows(
        element(
            "li",
            element("time", f"{since_start_s(run, line.time_ns):.2f}")
            + element("b", LEVELS.get(line.level, str(line.level)))
            + element("span", escape_markup(line.text)),
            class_=LEVELS.get(line.level, "info"),
        )
        for line in lines
    )
    rest = len(run.log) - len(lines)
    more = f"{rest} more lines are in the recording." if rest else ""
    return element("ol", body, class_="log") + hint(more)


def _chosen(lines: Iterable[RecordedLine]) -> list[RecordedLine]:
    """Lines that matter most, when there are too many."""
    lines = list(lines)
    for least in (0, 20, 30, 40):
        chosen = [line for line in lines if line.level >= least]
        if len(chosen) <= MOST_LINES:
            return chosen or lines[-MOST_LINES:]
    return chosen[-MOST_LINES:]


def files(run: RecordedRun) -> str:
    """The mission's file and those that it includes."""
    return rows(
        element("h3", escape_markup(name)) + element("pre", escape_markup(text))
        for name, text in run.files.items()
    )


def versions(run: RecordedRun) -> str:
    """What the run was made with."""
    inputs = run.inputs
    parts = [f"{name} {value}" for name, value in run.versions.items()]
    lines = [element("p", escape_markup(", ".join(parts)))]
    if inputs:
        given = ", ".join(f"{name} = {value}" for name, value in inputs.items())
        lines.append(element("p", escape_markup(f"Inputs: {given}")))
    wall = run.summary.get("wall_s")
    if wall is not None:
        lines.append(element("p", f"{seconds(mission_s(run))} in {seconds(wall)} of wall time."))
    trace = run.summary.get("trace_sha256")
    if trace:
        lines.append(element("p", f"Trace: <code>{escape_markup(str(trace))}</code>"))
    return rows(lines)
