"""The line of time of a recording: where in it one is, how long it is, how it is played."""

from __future__ import annotations

from bt_mission.recording.replay.player import Player
from bt_mission.views.terminal.marks import Marks
from bt_mission.views.terminal.words import Span, bar

LEAST_BAR = 10
"""A bar of fewer characters says nothing."""


def time_line(player: Player, width: int, marks: Marks) -> list[Span]:
    """Time, a bar, the duration, the pace."""
    how = _how(player)
    now, end = f"{player.at_s:.2f}", f"{player.duration_s:.2f} s"
    now = f"{now:>{len(end) - 2}}"  # so that what follows stands still
    style = "running" if player.is_playing else "title"
    room = width - len(now) - len(end) - len(how) - 5
    if room < LEAST_BAR:
        return [(f"{now} of {end}", "title"), (f"  {' '.join(how.split())}", style)]
    drawn = bar(player.at_s, player.duration_s, room, marks)
    return [(f"{now} ", "title"), (drawn, "bar"), (f" {end}  ", ""), (how, style)]


def _how(player: Player) -> str:
    """In a fixed width, so that the bar does not jump."""
    if player.is_playing:
        how = "backwards" if player.is_backwards else "playing"
    elif player.is_at_end:
        how = "cut here" if player.timeline.why_cut else "at the end"
    else:
        how = "at the start" if player.is_at_start else "paused"
    return f"{how:<12} {f'{player.speed:.4g} x':>6}"
