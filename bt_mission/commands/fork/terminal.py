"""The result of a fork, in lines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from bt_mission.base.text import escape_control, lines_of, seconds
from bt_mission.commands.fork.fork import ForkResult
from bt_mission.executive.events.log import verdict

SHOWN_S = 0.0005
"""A time that is rounded by less than this is shown as requested, s."""


def fork_lines(result: ForkResult, asked_s: float, changed: str = "") -> list[str]:
    """Return lines on what was recorded, how the fork ended, and where the two differ.

    Args:
        changed: In a fleet, the other robot whose run was changed, with the change.
    """
    source, report = result.source, result.report
    rounded = abs(result.at_s - asked_s) > SHOWN_S
    step = f" (the control step after {asked_s:g} s)" if rounded else ""
    what = "without a change" if result.change.is_none else f"with {result.change}"
    what = changed or what
    then = _outcome(*source.conclusion, source.summary.get("virtual_s", source.end_s))
    now = _outcome(*report.conclusion, report.virtual_s)
    lines = [
        f"recorded: {then}",
        f"forked at {seconds(result.at_s)}{step} {what}: {now}",
        f"  the same until there: {result.same_events} events, byte by byte",
    ]
    before = {requirement["name"]: requirement for requirement in source.requirements}
    unknown = "not watched" if source.summary else "not known"
    lines += [
        f"  requirement {requirement} (recorded: {_verdict(before.get(requirement.name), unknown)})"
        for requirement in report.requirements
    ]
    lines += _difference(result)
    if result.source.name:
        lines = [f"{result.source.name}: {lines[0]}", *lines[1:]]
    changed = "" if result.change.is_none else f"with {result.source.name}: {result.change}"
    for other in result.others:
        lines += fork_lines(other, result.at_s, changed)
    return [escape_control(line) for line in lines]


def _outcome(status: str, reason: str, at_s: float) -> str:
    return f"{verdict(status, '')} at {seconds(at_s)}" + (f": {reason}" if reason else "")


def _verdict(then: Mapping[str, Any] | None, unknown: str) -> str:
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
        yield from (f"  {line}" for line in lines_of(str(result.difference)))
