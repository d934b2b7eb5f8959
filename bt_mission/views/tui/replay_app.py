"""The full-screen view of a recording."""

from __future__ import annotations

import math
from typing import ClassVar

from textual.binding import Binding, BindingType

from bt_mission.core.wall_clock import Stopwatch
from bt_mission.recording.replay.player import Player
from bt_mission.views.terminal.marks import Marks
from bt_mission.views.terminal.time_line import time_line
from bt_mission.views.tui.keys import REPLAY_KEYS
from bt_mission.views.tui.view_app import Prompt, ViewApp


class ReplayApp(ViewApp):
    """Plays a recording. At its end the picture stays until somebody leaves.

    :param player: where in which recording to begin, and how fast.
    """

    keys = REPLAY_KEYS
    leaving = "leave"
    has_time = True
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding(key.keys, key.action, show=False) for key in REPLAY_KEYS
    ]

    def __init__(self, player: Player, marks: Marks) -> None:
        super().__init__(marks)
        self.player = player
        self._since_last = Stopwatch()

    def look(self) -> None:
        """Move on by the time that has passed, and show what was then."""
        passed_s, self._since_last = self._since_last.elapsed_s, Stopwatch()
        was_playing = self.player.is_playing
        self.player.advance(passed_s)
        if was_playing and self.player.is_at_end and self.player.timeline.why_cut:
            self.tell(f"the recording ends here: {self.player.timeline.why_cut}")
        self.draw()

    def draw(self) -> None:
        """Show the mission as it was."""
        self.outlook.show(self.player.mission)
        line = time_line(self.player, self.size.width, self._marks)
        self._main.panes["time"].show([line])
        self._main.show(self.outlook, self.foot(), [("replay  ", "words")])

    def keys_now(self) -> list[str]:
        """Those that are asked for most; the others are in the help."""
        play = "p pause" if self.player.is_playing else "p play"
        more = ["s/S step", "r reverse", "+/- speed", "t time", f"Tab {self.next_panel}"]
        return [play, *more, "? help", "q leave"]

    # ---- keys ------------------------------------------------------------------------------

    def action_play(self) -> None:
        """Play, or stand still."""
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
        """To the next change of the tree, or the one before."""
        if not self.player.step(steps):
            self.tell("the tree does not change after this" if steps > 0 else "nothing before this")
        self.draw()

    def action_start(self, steps: int) -> None:
        """To the next start of the selected node, or the one before."""
        node = self.outlook.cursor
        self.outlook.is_following = False  # or the selection would be another one there
        tree = self.player.mission.tree
        if not self.player.step_to_start(node, steps) and tree is not None:
            when = "later" if steps > 0 else "before this"
            self.tell(f"'{tree.nodes[node].name}' does not start {when}")
        self.draw()

    def action_skip(self, seconds: int) -> None:
        """On, or back."""
        self.player.skip(seconds)
        self.draw()

    def action_go(self, share: int) -> None:
        """To the start, or to the end."""
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
            self.tell(f"'{text}' is no time: expected seconds, such as 12.5")
