"""Faults that topics and goals show: silences, late messages, answers that are lost or refused."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median

import numpy as np

from bt_mission.base.stamps import NS
from bt_mission.base.text import seconds
from bt_mission.commands.reproduce.diagnosed import DiagnosedFault, fault_at
from bt_mission.commands.reproduce.evidence import Evidence
from bt_mission.recording.goal_lives import RecordedGoal

STEP_S = 0.05
LATE_S = 0.15
"""An answer that is later than usual by more is late."""
LATE_SHARE = 0.12
FEW = 3
CANCEL_REJECTED = 1
"""The return code of a cancel; others say that the goal is unknown, or has ended."""
MOST_NAMED = 12
"""Of silences of one topic."""
IDLE_S = 0.12
"""A server that is not active for longer after a cancel request had gone before it."""


def silences(evidence: Evidence) -> Iterator[DiagnosedFault]:
    """Yield the silences of sensors."""
    start_s = evidence.start_ns / NS
    last_s = evidence.end_s
    odometry = list(_gaps(evidence, "odom", start_s))
    transforms = list(_gaps(evidence, "tf", start_s))
    for begin, end in list(_gaps(evidence, "scan", start_s))[:MOST_NAMED]:
        period = evidence.topics["scan"].period_s
        yield _silence(evidence, "lidar_dead", "scan", begin + period / 2, end, period)
    for begin, end in odometry[:MOST_NAMED]:
        period = evidence.topics["odom"].period_s
        both = "tf" not in evidence.topics or any(
            abs(other - begin) < 3 * period for other, _ in transforms
        )
        name = "odometry_dead" if both else "drop"
        yield _silence(evidence, name, "odom", begin + period / 2, end, period)
    covered = [(begin, end or last_s) for begin, end in odometry]
    for topic, name in (("imu", "imu_dead"), ("joint_states", "joints_dead")):
        for begin, end in list(_gaps(evidence, topic, start_s))[:MOST_NAMED]:
            period = evidence.topics[topic].period_s
            if not any(abs(begin - other) < 3 * period for other, _ in covered):
                yield _silence(evidence, name, topic, begin + period / 2, end, period)
    yield from _late_topics(evidence)


def _gaps(evidence: Evidence, topic: str, start_s: float) -> Iterator[tuple[float, float | None]]:
    life = evidence.topics.get(topic)
    if life is None:
        return
    for begin, end in life.silences(evidence.end_s + start_s):
        since = begin - start_s
        if since > -life.period_s:
            yield max(since, 0.0), None if end is None else end - start_s


def _silence(
    evidence: Evidence, name: str, topic: str, start: float, end: float | None, period: float
) -> DiagnosedFault:
    lasting = None if end is None else end - start - period / 4
    arguments = ("odom",) if name == "drop" else ()
    until = "the end" if end is None else seconds(end)
    return DiagnosedFault(
        fault_at(start, name, *arguments, lasting=lasting),
        f"no message on {topic} from {seconds(start)} to {until}, {1 / period:.3g} Hz otherwise",
        0.95 if evidence.topics[topic].count > 50 else 0.8,
        round(start, 2),
        None if end is None else round(end, 2),
    )


def _late_topics(evidence: Evidence) -> Iterator[DiagnosedFault]:
    """Yield topics whose messages arrive late for a time, by their stamps."""
    start_s = evidence.start_ns / NS
    for topic in ("scan", "odom"):
        life = evidence.topics.get(topic)
        table = None if life is None else life.lateness.table()
        if table is None or len(table) < 20:
            continue
        usual = float(np.median(table[:, 1]))
        late = table[:, 1] - usual
        if abs(usual) > 3600:
            continue  # another clock stamps them
        for begin, end in spans_where(table[:, 0], late > LATE_S, FEW):
            inside = (table[:, 0] >= begin) & (table[:, 0] <= end)
            by = round(float(np.median(late[inside])), 2)
            since = begin - start_s - by
            yield DiagnosedFault(
                fault_at(since, "delay", topic, by, lasting=end - begin),
                f"messages on {topic} are {by:g} s older than usual when they arrive",
                0.8,
                round(since, 2),
                round(end - start_s, 2),
            )


def spans_where(
    times: np.ndarray, is_so: np.ndarray, least: int, gap_s: float = 0.11
) -> list[tuple[float, float]]:
    """Return the spans of at least some samples at which something is so."""
    numbers = np.flatnonzero(is_so)
    if not len(numbers):
        return []
    spans = []
    first = last = numbers[0]
    count = 1
    for number in numbers[1:]:
        step = times[number] - times[last]
        if number - last > 1 and step > gap_s * 1.5:
            if count >= least:
                spans.append((float(times[first]), float(times[last])))
            first, count = number, 0
        last = number
        count += 1
    if count >= least:
        spans.append((float(times[first]), float(times[last])))
    return spans


# ---- goals -----------------------------------------------------------------------------------


def goal_faults(evidence: Evidence, silent: Sequence[DiagnosedFault]) -> Iterator[DiagnosedFault]:
    """Yield what goes wrong with goals.

    Args:
        silent: The silences of sensors, for which servers reject goals.
    """
    goals = [goal for goal in evidence.goals if goal.requested_ns is not None]
    answers = [_late(goal.answered_ns, goal.sent_ns) for goal in goals]
    results = [_late(goal.result_ns, goal.served_end_ns) for goal in goals]
    usual_answer = median([late for late in answers if late is not None] or [0.0])
    usual_result = median([late for late in results if late is not None] or [0.0])
    for goal, answer, result in zip(goals, answers, results, strict=True):
        sent = evidence.since_start(goal.start_ns)
        action = goal.action.lstrip("/")
        if goal.was_refused:
            if not _is_blind(silent, sent):
                yield _of_goal(sent, "reject_goals", action, "the goal is rejected", 0.85)
        elif goal.answered_ns is None:
            yield from _unanswered(evidence, goal, sent, action)
        elif answer is not None and answer > max(LATE_S, usual_answer + LATE_SHARE):
            by = round(answer - usual_answer, 2)
            why = f"the goal response takes {answer:.2g} s"
            fault = fault_at(sent - STEP_S / 2, "delay_answers", action, by, goals=1)
            yield DiagnosedFault(fault, why, 0.85, round(sent, 2), round(sent + answer, 2))
        if result is not None and result > max(LATE_S, usual_result + LATE_SHARE):
            at = evidence.since_start(goal.served_end_ns or goal.start_ns)
            by = round(result - usual_result, 2)
            fault = fault_at(at - STEP_S / 2, "delay_results", action, by, goals=1)
            why = f"the result takes {result:.2g} s after the end of the goal"
            yield DiagnosedFault(fault, why, 0.85, round(at, 2), round(at + result, 2))
        yield from _unfinished(evidence, goal, action)
        yield from _cancels(evidence, goal, action)
        yield from _aborted(evidence, goal, action)


def _late(arrived_ns: int | None, since_ns: int | None) -> float | None:
    if arrived_ns is None or since_ns is None:
        return None
    return (arrived_ns - since_ns) / NS


def _is_blind(silent: Sequence[DiagnosedFault], at: float) -> bool:
    return any(
        each.name in ("lidar_dead", "odometry_dead", "drop")
        and each.start < at < (each.end or np.inf) + 1.0
        for each in silent
    )


def _of_goal(at: float, name: str, action: str, why: str, confidence: float) -> DiagnosedFault:
    start = at - STEP_S / 2
    fault = fault_at(start, name, action, 1)
    return DiagnosedFault(fault, f"{action}: {why}", confidence, round(at, 2))


def _unanswered(
    evidence: Evidence, goal: RecordedGoal, sent: float, action: str
) -> Iterator[DiagnosedFault]:
    if evidence.end_s - sent < 0.5:
        return
    if goal.first_known_ns is not None or goal.feedback:
        why = "the server executes the goal, and its goal response is missing"
        yield _of_goal(sent, "drop_answers", action, why, 0.9)
    else:
        why = "neither a goal response nor any message of the server about the goal"
        yield _of_goal(sent, "ignore_goals", action, why, 0.8)


def _unfinished(evidence: Evidence, goal: RecordedGoal, action: str) -> Iterator[DiagnosedFault]:
    """Yield why the result of an accepted goal is missing."""
    if goal.status or goal.was_refused or goal.answered_ns is None:
        return
    if goal.served_end_ns is not None:
        at = evidence.since_start(goal.served_end_ns)
        if evidence.end_s - at > LATE_S:
            why = f"the server ends the goal as {goal.served_status}, and the result is missing"
            yield _of_goal(at, "drop_results", action, why, 0.9)
        return
    died = died_at(evidence, goal)
    if died is not None:
        yield DiagnosedFault(
            fault_at(died, "kill_server", action),
            f"{action}: neither feedback nor a result after {seconds(died)}",
            0.75,
            round(died, 2),
        )


def died_at(evidence: Evidence, goal: RecordedGoal) -> float | None:
    """Return when the server of an accepted goal was last active, if it disappears before its end.

    A server that serves a goal drives the base, or sends feedback.
    """
    if goal.end_ns is not None or goal.answered_ns is None:
        return None
    last_ns = max(goal.answered_ns or 0, goal.feedback[-1][0] if goal.feedback else 0)
    at = _base_stops(evidence, evidence.since_start(last_ns))
    return at if evidence.end_s - at >= 0.3 else None


def _base_stops(evidence: Evidence, at: float) -> float:
    """Return when commands to the base end after a time: feedback may be rare."""
    commands = evidence.commands
    moving = (np.abs(commands[:, 1]) > 1e-6) | (np.abs(commands[:, 2]) > 1e-6)
    after = commands[moving & (commands[:, 0] >= at)]
    return float(after[-1, 0]) + STEP_S / 2 if len(after) else at + STEP_S / 2


def _cancels(evidence: Evidence, goal: RecordedGoal, action: str) -> Iterator[DiagnosedFault]:
    for cancel in goal.cancels:
        at = evidence.since_start(cancel.asked_ns)
        was_over = goal.served_end_ns is not None and goal.served_end_ns <= cancel.asked_ns
        died = died_at(evidence, goal)
        if was_over or goal.answered_ns is None or (died is not None and died < at + IDLE_S):
            continue
        if cancel.answered_ns is None:
            if evidence.end_s - at > LATE_S:
                yield _of_goal(at, "ignore_cancels", action, "no response to a cancel", 0.85)
        elif cancel.code == CANCEL_REJECTED:
            why = f"a cancel is rejected with code {cancel.code}"
            yield _of_goal(at, "refuse_cancels", action, why, 0.85)


def _aborted(evidence: Evidence, goal: RecordedGoal, action: str) -> Iterator[DiagnosedFault]:
    """Yield an abort that its own result does not explain."""
    result = goal.result or {}
    code, message = result.get("error_code", None), str(result.get("error_msg", ""))
    if goal.status != "aborted" or message:
        return
    at = evidence.since_start(goal.served_end_ns or goal.result_ns or goal.start_ns)
    yield DiagnosedFault(
        fault_at(at - STEP_S / 2, "abort_goal", action, *([int(code)] if code else [])),
        f"{action}: the server aborts the goal without a reason",
        0.8 if code is not None else 0.5,
        round(at, 2),
        is_needed=code is not None,
    )
