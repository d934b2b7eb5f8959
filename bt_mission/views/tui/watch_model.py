"""All that a view shows of one executive, and what its user has chosen; without a terminal."""

from __future__ import annotations

from collections import Counter, deque

from bt_mission.events import messages
from bt_mission.events.events import MissionStarted
from bt_mission.events.mission_state import MissionState
from bt_mission.events.source import ControlRequest, Heard, Verb
from bt_mission.views.terminal.tree_rows import Outline, scrolled_to

WINDOW_S = 3.0
"""Wall time over which the pace is taken."""


class RealTimeFactor:
    """Virtual seconds per second, over the last few seconds."""

    def __init__(self) -> None:
        self._seen: deque[tuple[int, float]] = deque()

    def note(self, time_ns: int, wall_s: float) -> None:
        """Take in a ROS time, ns, and the wall time at which it was heard, s."""
        if self._seen and time_ns < self._seen[-1][0]:
            self._seen.clear()  # time has begun anew
        self._seen.append((time_ns, wall_s))
        while self._seen[-1][1] - self._seen[0][1] > WINDOW_S and len(self._seen) > 2:
            self._seen.popleft()

    @property
    def factor(self) -> float | None:
        """Virtual seconds per second; None where too little was heard."""
        if len(self._seen) < 2:
            return None
        (first_ns, first_s), (last_ns, last_s) = self._seen[0], self._seen[-1]
        wall_s = last_s - first_s
        return (last_ns - first_ns) / 1e9 / wall_s if wall_s > 0.2 else None


class WatchModel:
    """A mission, and the user's place in its tree."""

    def __init__(self) -> None:
        self.mission = MissionState()
        self.outline = Outline(())
        self.pace = RealTimeFactor()
        self.cursor = 0
        """Index of the node that is selected."""
        self.top = 0
        """The first row of the tree in view."""
        self.is_following = True
        """Does the selection go with what runs?"""
        self.sought = ""
        self.hint = ""
        """What stands in the place of the tree as long as there is none."""
        self.limits = ""
        """What who is watched cannot tell or do."""

    def take(self, heard: Heard, wall_s: float) -> bool:
        """Take in what has come; gives whether anything has.

        Args:
            wall_s: Wall time at which it came, s.
        """
        for message in heard.messages:
            self._note_pace(message, wall_s)
            for one in self.mission.take(message):
                if isinstance(one, MissionStarted):
                    self._show_tree(one)
                    self.pace = RealTimeFactor()
        for reading in heard.robot:
            self.mission.take(reading)
        self._go_along()
        return bool(heard.messages or heard.robot or heard.answers)

    def show(self, mission: MissionState) -> None:
        """Show this from now on, with the user's place in the tree as long as that is the same."""
        if mission.tree is not self.mission.tree:
            self._show_tree(mission.tree)
        self.mission = mission
        self._go_along()

    def _show_tree(self, tree: MissionStarted | None) -> None:
        self.outline = Outline(tree.nodes if tree else ())
        self.cursor = self.top = 0

    def _go_along(self) -> None:
        if self.is_following and self.mission.tip is not None:
            self.cursor = self.mission.tip

    def _note_pace(self, message: messages.Told, wall_s: float) -> None:
        if isinstance(message, messages.DetailsUpdate | messages.Changes) and (
            self.mission.tree is not None and message.run == self.mission.tree.run
        ):
            self.pace.note(message.time_ns, wall_s)

    # ---- the tree ------------------------------------------------------------------------

    @property
    def cursor_row(self) -> int:
        """The row of the selected node, or of the folded one that hides it."""
        return self.outline.row_of(self.cursor) if self.outline.rows else 0

    def rows_in_view(self, height: int) -> list[int]:
        """The nodes whose rows are in view: the selected one is, with what it runs below."""
        outline = self.outline
        if not outline.rows:
            return []
        row = self.cursor_row
        above = [outline.row_of(one) for one in outline.path_to(outline.rows[row])[:-1]]
        self.top = scrolled_to(row, above, self.top, height, len(outline.rows))
        return outline.rows[self.top : self.top + height]

    def move(self, rows: int) -> None:
        """Select the node so many rows further down; from now on by hand."""
        if self.outline.rows:
            self.is_following = False
            row = min(max(self.cursor_row + rows, 0), len(self.outline.rows) - 1)
            self.cursor = self.outline.rows[row]

    def fold(self) -> None:
        """Hide what is below the selected node; of a leaf or a folded one, go to its parent."""
        if not self.outline.rows:
            return
        shown = self.outline.rows[self.cursor_row]
        self.is_following = False
        if self.outline.has_children(shown) and shown not in self.outline.folded:
            self.outline.fold(shown)
            self.cursor = shown
        else:
            self.cursor = self.outline.path_to(shown)[-2:][0]

    def unfold(self) -> None:
        """Show what is below the selected node."""
        if self.outline.rows:
            self.cursor = self.outline.rows[self.cursor_row]
            self.outline.unfold(self.cursor)

    def toggle(self) -> None:
        """Fold or unfold the selected node."""
        if not self.outline.rows:
            return
        if self.outline.rows[self.cursor_row] in self.outline.folded:
            self.unfold()
        elif self.outline.has_children(self.cursor):
            self.fold()

    def fold_all(self) -> None:
        """Hide all but the first two levels, or show everything where something is hidden."""
        if self.outline.folded:
            self.outline.unfold_all()
        elif self.outline.rows:
            self.outline.fold_all()

    def follow(self) -> None:
        """Go with what runs, or no longer."""
        self.is_following = not self.is_following
        self._go_along()

    def search(self, text: str, start: int, *, step: int = 1) -> bool:
        """Select the next node with a text in its name, class or words; gives whether there is one.

        Args:
            start: Index from which to look on.
            step: 1 looks downwards, -1 upwards.
        """
        self.sought = text
        wanted, tree = text.casefold(), self.mission.tree
        if tree is None or not wanted:
            return False

        def matches(index: int) -> bool:
            node = tree.nodes[index]
            words = (node.name, node.kind, self.mission.messages[index])
            return any(wanted in one.casefold() for one in words)

        found = self.outline.find(matches, start, step=step)
        if found is None:
            return False
        self.is_following = False
        self.cursor = found
        self.outline.reveal(found)
        return True

    @property
    def running_path(self) -> list[str]:
        """The names from the root to what runs."""
        tip, tree = self.mission.tip, self.mission.tree
        if tip is None or tree is None:
            return []
        return [tree.nodes[one].name for one in self.outline.path_to(tip)]

    def with_names(self, text: str) -> str:
        """Give a text the names of nodes for their paths, such as ``'0.1'``; a path says which."""
        nodes = self.mission.tree.nodes if self.mission.tree else ()
        names = Counter(node.name for node in nodes)
        for node in nodes:
            where = f" ({node.path})" if names[node.name] > 1 else ""
            text = text.replace(f"'{node.path}'", f"'{node.name}'{where}")
        return text

    # ---- wishes --------------------------------------------------------------------------

    def breakpoint(self) -> ControlRequest | None:
        """The wish to set a breakpoint at the selected node, or to remove the one that is set."""
        tree = self.mission.tree
        if tree is None:
            return None
        node = tree.nodes[self.cursor]
        for name in (node.path, node.name):
            if name in self.mission.breakpoints:
                return ControlRequest(Verb.UNBREAK, name)
        return ControlRequest(Verb.BREAK, node.path)
