"""What a fork has come to, in lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bt_mission.core.text import escape_control, seconds
from bt_mission.events.log import verdict
from bt_mission.recording.forks.change import ForkChange
from bt_mission.recording.forks.fork import ForkResult
from bt_mission.recording.forks.source import ForkSource
from bt_mission.recording.forks.sweep import SweepResult, Try

SHOWN_S = 0.0005
"""A time that is rounded by less than this is shown as it was asked for, s."""


def told(result: ForkResult, asked_s: float, changed: str = "") -> list[str]:
    """Tell what was recorded, what has become of it, and where the two part.

    Args:
        changed: Of a fleet, the other robot whose run was changed, with the change.
    """
    source, report = result.source, result.report
    rounded = abs(result.at_s - asked_s) > SHOWN_S
    step = f" (the control step after {asked_s:g} s)" if rounded else ""
    what = "without a change" if result.change.is_none else f"with {result.change}"
    what = changed or what
    then = _outcome(*source.outcome, source.summary.get("virtual_s", source.end_s))
    now = _outcome(report.status, report.reason, report.virtual_s)
    lines = [
        f"recorded: {then}",
        f"forked at {seconds(result.at_s)}{step} {what}: {now}",
        f"  the same until there: {result.same_events} events, byte by byte",
    ]
    before = {one["name"]: one for one in source.requirements}
    unknown = "not watched" if source.summary else "not known"
    lines += [
        f"  requirement {one} (recorded: {_verdict(before.get(one.name), unknown)})"
        for one in report.requirements
    ]
    lines += _difference(result)
    if result.source.name:
        lines = [f"{result.source.name}: {lines[0]}", *lines[1:]]
    changed = "" if result.change.is_none else f"with {result.source.name}: {result.change}"
    for other in result.others:
        lines += told(other, result.at_s, changed)
    return [escape_control(line) for line in lines]


def try_line(one: Try) -> str:
    """Tell of one try of a sweep."""
    return escape_control(f"  forked at {seconds(one.at_s):>9}: {_ending(one)}")


def told_sweep(
    source: ForkSource, change: ForkChange, found: SweepResult, wall_s: float
) -> list[str]:
    """Tell the last instant at which a change would have saved a mission, and what was tried."""
    then = _outcome(*source.outcome, source.summary.get("virtual_s", source.end_s))
    lines = [f"recorded: {then}"]
    lines += [
        f"  requirement {one['name']}: {_verdict(one)}"
        for one in source.requirements
        if one.get("verdict") == "violated"
    ]
    if found.last is None:
        lines.append(f"with {change}: saved at none of the instants that were tried")
    else:
        at_s = found.last.at_s
        lines.append(f"with {change} from {seconds(at_s)} on, it is saved: {_ending(found.last)}")
    if found.last is not None and found.next is not None:
        at_s = found.next.at_s
        lines.append(
            f"  one control step later, at {seconds(at_s)}, it is not: {_ending(found.next)}"
        )
    left = f"; {found.skipped} such instants were left out (--tries)" if found.skipped else ""
    lines.append(
        f"  {len(found.tries)} of {found.control_steps} control steps were tried, in {wall_s:.0f} "
        f"s: where nodes changed, from the last one back{left}. Nothing is known of the others"
    )
    return [escape_control(line) for line in lines]


def _ending(one: Try) -> str:
    if one.status == "refused":
        return f"not possible: {one.reason}"
    return _outcome(one.status, one.reason, one.virtual_s)


def _outcome(status: str, reason: str, at_s: float) -> str:
    return f"{verdict(status, '')} at {seconds(at_s)}" + (f": {reason}" if reason else "")


def _verdict(then: Mapping[str, Any] | None, unknown: str = "") -> str:
    if then is None:
        return unknown
    margin, unit = then.get("margin"), then.get("unit", "")
    by = f" by {abs(margin):.4g} {unit}".rstrip() if isinstance(margin, int | float) else ""
    return f"{then.get('verdict', '?')}{by}"


def _difference(result: ForkResult) -> Iterator[str]:
    if result.difference is None:
        events = len(result.source.trace) - 1
        what = "identical" if result.change.is_none else "the change makes no difference"
        known = "" if result.source.is_whole else " that were recorded"
        yield f"  {what}: all {events} events of the trace{known}, byte by byte"
    else:
        yield "  first difference (< recorded, > forked):"
        yield from (f"  {line}" for line in str(result.difference).splitlines())
