"""Everything that a view shows of one executive, and the user's selection; without a terminal."""

from __future__ import annotations

from bt_mission.executive.events.events import Event, RunStarted
from bt_mission.executive.events.mission_state import MissionState
from bt_mission.executive.events.source import ControlRequest, Received
from bt_mission.executive.events.watched_mission import WatchedMission
from bt_mission.views.terminal.tree_rows import Outline, scrolled_to


class WatchModel(WatchedMission):
    """A mission, and the user's place in its tree."""

    def __init__(self) -> None:
        super().__init__()
        self.outline = Outline(())
        self.cursor = 0
        """Index of the node that is selected."""
        self.top = 0
        """The first row of the tree in view."""
        self.is_following = True
        """Whether the selection follows the running nodes."""
        self.sought = ""
        self.hint = ""
        """The text in place of a tree before there is one."""

    def take(self, received: Received, wall_s: float) -> list[Event]:
        """Apply what was received, and move the selection. Return the events that change the state.

        Args:
            wall_s: Wall time of the reception, s.
        """
        happened = super().take(received, wall_s)
        self._go_along()
        return happened

    def show(self, mission: MissionState) -> None:
        """Show this from now on, with the user's place in the tree as long as that is the same."""
        if mission.tree is not self.mission.tree:
            self.on_tree(mission.tree)
        self.mission = mission
        self._go_along()

    def on_tree(self, tree: RunStarted | None) -> None:
        """Show another tree, from its first row on."""
        self.outline = Outline(tree.nodes if tree else ())
        self.cursor = self.top = 0

    def _go_along(self) -> None:
        if self.is_following and (focus := self.mission.focus) is not None:
            self.cursor = focus

    # ---- the tree ------------------------------------------------------------------------

    @property
    def cursor_row(self) -> int:
        """The row of the selected node, or of the folded one that hides it."""
        return self.outline.row_of(self.cursor) if self.outline.rows else 0

    def rows_in_view(self, height: int) -> list[int]:
        """Return the nodes whose rows are in view, with the selected one and what it runs."""
        outline = self.outline
        if not outline.rows:
            return []
        row = self.cursor_row
        above = [outline.row_of(node) for node in outline.path_to(outline.rows[row])[:-1]]
        self.top = scrolled_to(row, above, self.top, height, len(outline.rows))
        return outline.rows[self.top : self.top + height]

    def move(self, rows: int) -> None:
        """Select the node some rows further down; stop following."""
        if self.outline.rows:
            self.is_following = False
            row = min(max(self.cursor_row + rows, 0), len(self.outline.rows) - 1)
            self.cursor = self.outline.rows[row]

    def fold(self) -> None:
        """Fold the selected node; for a leaf or a folded one, select its parent."""
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
        """Select the next node with a text in its name, class or details.

        Return whether there is one.

        Args:
            start: Index from which to search.
            step: 1 looks downwards, -1 upwards.
        """
        self.sought = text
        wanted, tree = text.casefold(), self.mission.tree
        if tree is None or not wanted:
            return False

        def matches(index: int) -> bool:
            node = tree.nodes[index]
            words = (node.name, node.kind, self.mission.messages[index])
            return any(wanted in word.casefold() for word in words)

        row = self.outline.find(matches, start, step=step)
        if row is None:
            return False
        self.is_following = False
        self.cursor = row
        self.outline.reveal(row)
        return True

    @property
    def running_path(self) -> list[str]:
        """The names from the root to what runs."""
        tip, tree = self.mission.tip, self.mission.tree
        if tip is None or tree is None:
            return []
        return [tree.nodes[node].name for node in self.outline.path_to(tip)]

    # ---- wishes --------------------------------------------------------------------------

    def breakpoint(self) -> ControlRequest | None:
        """Return the request to set a breakpoint at the selected node, or to remove it."""
        return self.toggled_breakpoint(self.cursor)
