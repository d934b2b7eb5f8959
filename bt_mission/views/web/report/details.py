"""The details of a recorded run on its page, besides its history."""

from __future__ import annotations

import base64
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from bt_mission.base.geometry import Pose2D
from bt_mission.base.text import cut, escape_lines, number, seconds
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.recording.goal_lives import RecordedGoal
from bt_mission.recording.model import RecordedRequirement, RecordedRun, Span
from bt_mission.views.web.encoding import shown
from bt_mission.views.web.report.figures import (
    charts,
    distance_m,
    leaves,
    margin_chart,
    mission_s,
    since_start_s,
    stops,
    thinned,
)
from bt_mission.views.web.report.history import POSE_NS, RobotTrack

MOST_LINES = 1000
MOST_GOALS = 500
MOST_FIELDS = 12
MOST_STOPS = 500
MOST_SPANS = 100_000
MOST_PICTURES = 24
MOST_PICTURE_BYTES = 5_000_000
FEEDBACK_POINTS = 200
PATH, TEXT = 48, 160
"""Characters of a value that are shown."""

LEVELS = {10: "debug", 20: "info", 30: "warning", 40: "error", 50: "fatal"}
SPAN_STATUS = {"halted": 0, "running": 1, "success": 2, "failure": 3}


def details(run: RecordedRun, mission: MissionState) -> dict[str, Any]:
    """Return the details of a run, ready for JSON; times are s since its start.

    Args:
        mission: Its state at the end.
    """
    nodes = mission.tree.nodes if mission.tree else ()
    return {
        **shown(
            {
                "lacks": "; ".join(filter(None, (run.why_cut, run.missing))),
                "facts": list(_facts(run)),
                "made": list(_made(run)),
                "failure": _failure(run, mission),
                "asked": [node.details for node in nodes],
                "goals": [_goal(run, goal) for goal in run.goals[:MOST_GOALS]],
                "goals_left_out": max(len(run.goals) - MOST_GOALS, 0),
                "requirements": [
                    _requirement(run, requirement) for requirement in run.requirements
                ],
                "leaves": [[index, dict(ends), spent_s] for index, ends, spent_s in leaves(run)],
                "charts": [chart.data(run.start_ns) for chart in charts(run)],
                "stops": [
                    [since_start_s(run, start_ns), length_s, x, y]
                    for start_ns, length_s, x, y in stops(run.track)[:MOST_STOPS]
                ],
                "collisions": [
                    [
                        since_start_s(run, collision.time_ns),
                        collision.x,
                        collision.y,
                        collision.obstacle,
                    ]
                    for collision in run.collisions[:MOST_STOPS]
                ],
                "log": _log(run),
                "lines_left_out": max(len(run.log) - MOST_LINES, 0),
                "pictures": _pictures(run),
                "pictures_in_all": len(run.pictures),
            }
        ),
        "spans": _spans(run),
        "truth": _truth(run),
        # Line feeds of a file are part of it.
        "files": [[shown(name), escape_lines(text)] for name, text in run.files.items()],
    }


def _facts(run: RecordedRun) -> Iterator[tuple[str, str]]:
    summary, known = run.summary, run.facts
    distance = distance_m(run)
    orphaned = summary.get("goals_left_behind", 0)
    yield "duration", seconds(mission_s(run))
    if distance is not None:
        yield "distance", f"{distance:.2f} m"
    yield "goals", f"{len(run.goals)}" + (f", {orphaned} orphaned" if orphaned else "")
    collisions = summary.get("collisions", len(run.collisions) or None)
    if collisions is not None:
        yield "collisions", str(collisions)
    for warning in summary.get("warnings", ()):
        yield "warning", warning
    for name in ("world", "robot", "seed"):
        if known.get(name) is not None:
            yield name, known[name]


def _made(run: RecordedRun) -> Iterator[tuple[str, str]]:
    """Yield what the run was made with."""
    if run.versions:
        yield "versions", ", ".join(f"{name} {value}" for name, value in run.versions.items())
    if run.inputs:
        yield "inputs", ", ".join(f"{name} = {value}" for name, value in run.inputs.items())
    if (wall_s := run.summary.get("wall_s")) is not None:
        yield "wall time", seconds(wall_s)
    if trace := run.summary.get("trace_sha256"):
        yield "trace", str(trace)


def _failure(run: RecordedRun, mission: MissionState) -> dict[str, Any] | None:
    """Return the path to the node whose failure was last, its time, and its message."""
    path = mission.failure_path()
    if not path:
        return None
    end = mission.last_end(path[-1])
    at = None if end.time_ns is None else since_start_s(run, end.time_ns)
    return {"path": path, "at": at, "message": end.message}


def _requirement(run: RecordedRun, requirement: RecordedRequirement) -> dict[str, Any]:
    result, chart = requirement.result.shown, margin_chart(run, requirement)
    return {
        "name": result.name,
        "requirement": result.requirement,
        "verdict": result.verdict,
        "margin": result.margin,
        "unit": result.unit,
        "at": result.at,
        "violated_at": result.violated_at,
        "why": result.why,
        "chart": None if chart is None else chart.data(run.start_ns),
    }


# ---- goals ---------------------------------------------------------------------------------------


def _goal(run: RecordedRun, goal: RecordedGoal) -> dict[str, Any]:
    times = {
        "sent": goal.sent_ns,
        "accepted": goal.accepted_ns,
        "handed_over": goal.released_ns,
        "cancel": goal.cancels[0].asked_ns if goal.cancels else None,
        "end": goal.end_ns,
    }
    end = None if goal.end_ns is None else run.track.at(goal.end_ns)
    return {
        "id": goal.id,
        "action": goal.action,
        "type": goal.type_name,
        "owner": goal.owner,
        "status": goal.status or ("orphaned" if goal.abandoned_ns is not None else ""),
        **{
            name: None if time_ns is None else round(since_start_s(run, time_ns), 3)
            for name, time_ns in times.items()
        },
        "values": _fields(goal.values),
        "result": None if goal.result is None else _fields(goal.result),
        "messages": len(goal.feedback),
        "feedback": _feedback(run, goal),
        "place": None if end is None else [round(end[0], 3), round(end[1], 3)],
    }


def _feedback(run: RecordedRun, goal: RecordedGoal) -> list[dict[str, Any]]:
    """Return the numbers in a goal's feedback against time."""
    series: dict[str, list[tuple[int, float]]] = {}
    for time_ns, values in goal.feedback:
        for name, value in _flat("", values, every=True):
            is_number = isinstance(value, int | float | np.number)
            if is_number and not isinstance(value, bool) and len(series) <= MOST_FIELDS:
                series.setdefault(name, []).append((time_ns, float(value)))
    made = []
    for name, points in series.items():
        times = np.array([time_ns for time_ns, _ in points], np.int64)
        chosen = thinned(times, np.array([value for _, value in points]), FEEDBACK_POINTS)
        if len(chosen[1]) > 1 and np.ptp(chosen[1]) > 0:
            t = ((chosen[0] - run.start_ns) / 1e9).round(2).tolist()
            made.append({"name": name, "unit": "", "t": t, "v": chosen[1].round(4).tolist()})
    return made


def _fields(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return fields of a message by their dotted names, without empty ones."""
    fields = [
        (name, text)
        for name, value in _flat("", values)
        if (text := _short(value)) and not (name == "error_code" and value == 0)
    ]
    return fields[:MOST_FIELDS]


def _flat(
    prefix: str, values: Mapping[str, Any], *, every: bool = False
) -> Iterator[tuple[str, Any]]:
    """Yield fields by their dotted names; of messages inside a message, those that are not 0."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            yield from _flat(f"{prefix}{name}.", value, every=every)
        elif every or not prefix or (value if isinstance(value, str) else np.any(value)):
            yield f"{prefix}{name}", value


def _short(value: Any) -> str:
    match value:
        case bool() | np.bool_():
            return str(bool(value)).lower()
        case float() | np.floating():
            return number(float(value))
        case str() if value.startswith("/"):
            return value if len(value) <= PATH else f"…{value[1 - PATH :]}"
        case str():
            return cut(value, TEXT)
        case list() | np.ndarray():
            text = ", ".join(_short(part) for part in value[:3])
            is_short = len(value) <= 3 and len(text) <= PATH
            return text if is_short else f"{len(value)} of them"
        case Mapping():
            return ", ".join(f"{name} {_short(part)}" for name, part in _flat("", value))
    return str(value)


# ---- nodes, the robot, texts, pictures -----------------------------------------------------------


def _spans(run: RecordedRun) -> dict[str, Any]:
    """Return when each node ran: begin, end, status, the index of its message in the texts."""
    texts: dict[str, int] = {}

    def row(span: Span) -> list[Any]:
        begin, end = since_start_s(run, span.start_ns), since_start_s(run, span.end_ns)
        text = texts.setdefault(shown(span.message), len(texts))
        return [round(begin, 3), round(end, 3), SPAN_STATUS[span.status], text]

    most = max(MOST_SPANS // max(len(run.spans), 1), 1000)
    rows = [[row(span) for span in spans[-most:]] for spans in run.spans]
    left_out = sum(max(len(spans) - most, 0) for spans in run.spans)
    return {"rows": rows, "texts": list(texts), "left_out": left_out}


def _truth(run: RecordedRun) -> dict[str, list[float]]:
    """Return the true poses, if a simulation has them."""
    track = RobotTrack()
    for time_ns, x, y, yaw in zip(
        run.truth.times.tolist(), run.truth.x, run.truth.y, run.truth.yaw, strict=True
    ):
        at = since_start_s(run, time_ns)
        if track.is_due(at, POSE_NS / 1e9):
            track.add(round(at, 3), Pose2D(float(x), float(y), float(yaw)))
    return track.data()


def _log(run: RecordedRun) -> list[tuple[float, str, str, str]]:
    """Return the lines of all logs; of too many, those of the highest levels."""
    lines = list(run.log)
    for least in (0, 20, 30, 40):
        chosen = [line for line in lines if line.level >= least]
        if len(chosen) <= MOST_LINES:
            break
    return [
        (
            round(since_start_s(run, line.time_ns), 3),
            LEVELS.get(line.level, str(line.level)),
            line.name,
            line.text,
        )
        for line in (chosen or lines)[-MOST_LINES:]
    ]


def _pictures(run: RecordedRun) -> list[dict[str, Any]]:
    """Return pictures, spread over the run where there are many."""
    step = max(1, -(-len(run.pictures) // MOST_PICTURES))
    chosen, room = [], MOST_PICTURE_BYTES
    for picture in run.pictures[::step]:
        room -= len(picture.data)
        if room < 0:
            break
        chosen.append(
            {
                "name": picture.name,
                "t": round(since_start_s(run, picture.time_ns), 3),
                "type": picture.media_type,
                "data": base64.b64encode(picture.data).decode(),
            }
        )
    return chosen
