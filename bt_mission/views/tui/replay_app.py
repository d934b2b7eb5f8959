"""The full-screen view of a recording."""

from __future__ import annotations

import math
import shlex
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

from textual.binding import Binding, BindingType

from bt_mission.base.text import seconds
from bt_mission.base.wall_clock import Stopwatch
from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.terminal.marks import Marks, Span, bar
from bt_mission.views.tui.keys import REPLAY_KEYS
from bt_mission.views.tui.view_app import Prompt, ViewApp
from bt_mission.views.tui.watch_model import WatchModel

LEAST_BAR = 10
"""A bar of fewer characters is useless."""

Suspend: TypeAlias = Callable[[], AbstractContextManager[Any]]
"""Gives the terminal back for a while."""


Fork: TypeAlias = Callable[[Path, float, list[str], Suspend], Path | None]
"""Forks a recording at a time, s, with a change as text, while the screen is free for it.

It returns the recording of the fork; None without one.
"""


class ReplayApp(ViewApp):
    """Plays a recording. At its end the view stays until the user leaves.

    Args:
        player: The recording, with its start time and speed.
        fork: Forks the recording at the instant that is shown; None does not offer it.
    """

    keys = REPLAY_KEYS
    leaving = "leave"
    has_time = True
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(key.keys, key.action, show=False) for key in REPLAY_KEYS
    ]

    def __init__(self, player: Player, marks: Marks, fork: Fork | None = None) -> None:
        super().__init__(marks)
        self.player = player
        self._fork = fork
        self._since_last = Stopwatch()

    def look(self) -> None:
        """Move on by the time that has passed, and show what was then."""
        passed_s, self._since_last = self._since_last.elapsed_s, Stopwatch()
        was_playing = self.player.is_playing
        self.player.advance(passed_s)
        if was_playing and self.player.is_at_end and self.player.timeline.why_cut:
            self.show_notice(f"the recording ends here: {self.player.timeline.why_cut}")
        self.draw()

    def draw(self) -> None:
        """Show the mission at the instant."""
        self.outlook.show(self.player.mission)
        line = time_line(self.player, self.size.width, self._marks)
        self._main.panes["time"].show([line])
        self._main.show(self.outlook, self.foot(), [("replay  ", "words")])

    def keys_now(self) -> list[str]:
        """The most frequent keys; the help has the others."""
        play = "p pause" if self.player.is_playing else "p play"
        more = ["s/S step", "r reverse", "+/- speed", "t time", f"Tab {self.next_panel}"]
        return [play, *more, "? help", "q leave"]

    # ---- keys ------------------------------------------------------------------------------

    def action_play(self) -> None:
        """Play or pause."""
        if self.player.is_playing:
            self.player.pause()
        else:
            self._since_last = Stopwatch()
            self.player.play()
        self.draw()

    def action_reverse(self) -> None:
        """Play the other way."""
        self._since_last = Stopwatch()
        self.player.reverse()
        self.draw()

    def action_speed(self, factor: float) -> None:
        """Faster, or slower."""
        self.player.faster(factor)
        self.draw()

    def action_step(self, steps: int) -> None:
        """Go to the next change of the tree, or the one before."""
        if not self.player.step(steps):
            self.show_notice(
                "the tree does not change after this" if steps > 0 else "no change before this"
            )
        self.draw()

    def action_start(self, steps: int) -> None:
        """Go to the next start of the selected node, or the one before."""
        node = self.outlook.cursor
        self.outlook.is_following = False  # or the selection would be another one there
        tree = self.player.mission.tree
        if not self.player.step_to_start(node, steps) and tree is not None:
            when = "later" if steps > 0 else "before this"
            self.show_notice(f"'{tree.nodes[node].name}' does not start {when}")
        self.draw()

    def action_skip(self, seconds: int) -> None:
        """On, or back."""
        self.player.skip(seconds)
        self.draw()

    def action_go(self, share: int) -> None:
        """Go to the start, or to the end."""
        self.player.go(share * self.player.duration_s)
        self.draw()

    def action_time(self) -> None:
        """Ask for a time, and go there."""
        self.ask(Prompt("seconds since the start; Enter goes there, Esc does not", self._go))

    def _go(self, text: str) -> None:
        try:
            at_s = float(text.strip().removesuffix("s"))
        except ValueError:
            at_s = math.nan
        if math.isfinite(at_s):
            self.player.go(at_s)
        else:
            self.show_notice(f"'{text}' is not a time: expected seconds, such as 12.5")

    def action_fork(self) -> None:
        """Ask for a change, and fork the recording at the instant that is shown."""
        if self._fork is None:
            self.show_notice("forks are not available here")
            return
        self.player.pause()
        hint = f"fork at {seconds(self.player.at_s)}: NAME=VALUE, or --mission FILE; Enter, or Esc"
        self.ask(Prompt(hint, self._fork_with))

    def _fork_with(self, text: str) -> None:
        assert self._fork is not None, "it was asked for only where it is offered"
        shown = self.player
        try:
            words = shlex.split(text)
        except ValueError as error:
            self.show_notice(f"'{text}' cannot be read: {error}")
            return
        path = self._fork(shown.timeline.path, shown.at_s, words, self.suspend)
        if path is None:
            self.show_notice("the fork failed; this is the original recording")
            return
        self.player = Player(read_timeline(path), speed=shown.speed, at_s=shown.at_s)
        self.outlook = WatchModel()
        self.show_notice(f"the fork: {path}")


def time_line(player: Player, width: int, marks: Marks) -> list[Span]:
    """Time, a bar, the duration, the pace."""
    how = _how(player)
    now, end = f"{player.at_s:.2f}", seconds(player.duration_s)
    now = f"{now:>{len(end) - 2}}"  # so that the text after it does not move
    style = "running" if player.is_playing else "title"
    room = width - len(now) - len(end) - len(how) - 5
    if room < LEAST_BAR:
        return [(f"{now} of {end}", "title"), (f"  {' '.join(how.split())}", style)]
    drawn = bar(player.at_s, player.duration_s, room, marks)
    return [(f"{now} ", "title"), (drawn, "bar"), (f" {end}  ", ""), (how, style)]


def _how(player: Player) -> str:
    """Return the pace in a fixed width, so that the bar does not jump."""
    if player.is_playing:
        how = "backwards" if player.is_backwards else "playing"
    elif player.is_at_end:
        how = "incomplete from here" if player.timeline.why_cut else "at the end"
    else:
        how = "at the start" if player.is_at_start else "paused"
    return f"{how:<12} {f'{player.speed:.4g} x':>6}"
