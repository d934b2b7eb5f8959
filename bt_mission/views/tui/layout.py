"""The panes of the view on the screen, and what each of them shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from textwrap import wrap

from textual.app import ComposeResult
from textual.screen import Screen
from textual.widgets import Input

from bt_mission.base.text import lines_of
from bt_mission.executive.events.watched_mission import targets
from bt_mission.views.terminal.map_chart import MapChart
from bt_mission.views.terminal.marks import Marks, Span
from bt_mission.views.terminal.panels import (
    Rows,
    goal_rows,
    goals_title,
    header,
    log_rows,
    map_title,
    node_rows,
    path,
    requirement_rows,
    requirements_title,
    variable_rows,
)
from bt_mission.views.terminal.tree_rows import tree_row
from bt_mission.views.tui.pane import Pane
from bt_mission.views.tui.watch_model import WatchModel

REQUIREMENTS = "requirements"
PANELS = ("log", REQUIREMENTS, "goals", "variables", "map", "node")
"""The panels beside the tree, in the order in which one key selects them."""

WIDE_COLUMNS, WIDE_ROWS = 110, 26
"""From this size on all panels are shown together; below it one at a time."""

PANEL_ROWS = 14
"""Below this number of rows there is no panel, unless it is enlarged."""

PATH_ROWS = 8
"""Below this number of rows the running path is hidden."""

SIDE_COLUMNS = 64
"""The most columns for the panels beside the tree."""


TIME_ROWS = 4
"""With fewer rows, a recording's line of time gives way to the tree."""


@dataclass(frozen=True)
class PanePlace:
    """Of a pane: its upper left corner and its size, in cells."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True)
class Content:
    """The content of a view, as far as it takes space.

    Attributes:
        has_time: Whether there is a line of time above the last one.
        requirements: The number of requirements of the mission.
    """

    has_time: bool = False
    requirements: int = 0


def arranged(
    width: int, height: int, panel: str, content: Content, *, is_large: bool
) -> dict[str, PanePlace]:
    """The place of each pane that is shown.

    Args:
        panel: Which one is shown where there is room for one.
        is_large: Does it take the place of the tree, and of all others?
    """
    places = {"head": PanePlace(0, 0, width, 1)}
    top = 1
    if height >= PATH_ROWS:
        places["path"] = PanePlace(0, 1, width, 1)
        top = 2
    bottom = max(height - 1, top)
    places["foot"] = PanePlace(0, bottom, width, 1)
    if content.has_time and height >= TIME_ROWS:
        bottom -= 1
        places["time"] = PanePlace(0, bottom, width, 1)
    rows = bottom - top
    if is_large:
        places[panel] = PanePlace(0, top, width, rows)
    elif width >= WIDE_COLUMNS and height >= WIDE_ROWS:
        places |= _wide(width, top, rows, content.requirements)
    elif height >= PANEL_ROWS:
        below = min(max(rows // 3, 5), 12)
        places["tree"] = PanePlace(0, top, width, rows - below)
        places[panel] = PanePlace(0, bottom - below, width, below)
    else:
        places["tree"] = PanePlace(0, top, width, rows)
    return places


def _wide(width: int, top: int, rows: int, requirements: int) -> dict[str, PanePlace]:
    """Tree, requirements and log on the left, the others on the right."""
    side = min(width * 2 // 5, SIDE_COLUMNS)
    left, x = width - side - 1, width - side
    log = max(rows // 4, 6)
    node, goals = max(rows // 4, 6), max(rows // 5, 5)
    variables = max(rows // 7, 4)
    chart = rows - node - goals - variables
    heights = (("map", chart), ("goals", goals), ("variables", variables), ("node", node))
    judged = min(requirements + 1, max(rows // 4, 4)) if requirements else 0
    places = {
        "tree": PanePlace(0, top, left, rows - log - judged),
        "log": PanePlace(0, top + rows - log, left, log),
    }
    if judged:
        places[REQUIREMENTS] = PanePlace(0, top + rows - log - judged, left, judged)
    y = top
    for name, height in heights:
        places[name] = PanePlace(x, y, side, height)
        y += height
    return places


def _wrapped(text: str, width: int) -> Rows:
    """A text in the place of what is not there, in rows that fit."""
    return [
        [(row, "words")]
        for line in lines_of(text)
        for row in wrap(line, max(width, 10), subsequent_indent="  ")
    ]


BARE = ("head", "path", "time", "foot")
"""Panes without a title."""


class MainScreen(Screen[None]):
    """The tree, and panels around it or below it.

    Args:
        has_time: Is there a line of time, as of a recording?
    """

    DEFAULT_CSS = """
    MainScreen { background: ansi_default; color: ansi_default; }
    MainScreen > Pane { position: absolute; display: none; }
    #search {
        position: absolute; display: none; height: 1; border: none; padding: 0;
        background: ansi_default; color: ansi_default;
    }
    """
    AUTO_FOCUS = ""

    def __init__(self, marks: Marks, *, has_time: bool = False) -> None:
        super().__init__()
        self._content = Content(has_time=has_time)
        self._marks = marks
        self._chart = MapChart(marks)
        self.panes = {
            name: Pane(marks, has_rule=name not in BARE, id=name)
            for name in (*BARE, "tree", *PANELS)
        }
        self.search = Input(id="search", compact=True, select_on_focus=False)
        self.search.cursor_blink = False
        self.panel = "log"
        self.is_large = False
        self.scroll = 0
        """Rows by which an enlarged panel is scrolled."""
        self._chosen: int | None = None

    def compose(self) -> ComposeResult:
        """All panes; :meth:`place_panes` puts them in their places."""
        yield from self.panes.values()
        yield self.search

    def place_panes(self) -> None:
        """Give each pane its place on a screen of the present size."""
        width, height = self.size
        places = arranged(width, height, self.panel, self._content, is_large=self.is_large)
        for name, pane in self.panes.items():
            place = places.get(name)
            pane.display = place is not None and place.height > 0 and place.width > 0
            if place is not None:
                pane.styles.offset = (place.x, place.y)
                pane.styles.width, pane.styles.height = place.width, place.height
        foot = places["foot"]
        self.search.styles.offset = (0, foot.y)
        self.search.styles.width = width

    def is_shown(self, name: str) -> bool:
        """Is a pane on the screen?"""
        return bool(self.panes[name].display)

    def show(self, outlook: WatchModel, foot: list[Span], before: Sequence[Span] = ()) -> None:
        """Show what is known now.

        Args:
            before: What stands before the mission's name.
        """
        mission, marks = outlook.mission, self._marks
        content = replace(self._content, requirements=len(mission.requirements))
        if content != self._content:
            self._content = content
            self.place_panes()
        width = self.size.width
        head = header(mission, mission.robot, outlook.pace.factor, marks, outlook.file_note)
        self.panes["head"].show([[*before, *head]])
        self.panes["path"].show([path(outlook.running_path, width, marks)])
        self.panes["foot"].show([foot])
        self._show_tree(outlook)
        for name in PANELS:
            if self.is_shown(name):
                rows, title = self._panel(name, outlook)
                self._show_panel(name, rows, title)

    def _show_tree(self, outlook: WatchModel) -> None:
        pane = self.panes["tree"]
        if not self.is_shown("tree"):
            return
        indices = outlook.rows_in_view(pane.room)
        chosen = outlook.cursor_row - outlook.top if indices else None
        rows: Rows = []
        for number, index in enumerate(indices):
            is_chosen = number == chosen
            row = tree_row(
                outlook.mission,
                outlook.outline,
                index,
                pane.size.width - 1,
                self._marks,
                is_chosen=is_chosen,
            )
            rows.append([(self._marks.cursor if is_chosen else " ", "key"), *row])
        count = len(outlook.outline.rows)
        right = (
            f"{outlook.top + 1} to {outlook.top + len(rows)} of {count}"
            if len(rows) < count
            else ""
        )
        title = "tree, following" if outlook.is_following else "tree"
        if outlook.mission.tree is None:
            rows = _wrapped(outlook.hint, pane.size.width)
        pane.show(rows, title, right)

    def _panel(self, name: str, outlook: WatchModel) -> tuple[Rows, str]:
        mission, marks, pane = outlook.mission, self._marks, self.panes[name]
        match name:
            case "goals":
                return goal_rows(mission, marks), goals_title(mission)
            case "requirements":
                return requirement_rows(mission, marks), requirements_title(mission)
            case "variables":
                return variable_rows(mission, marks), "variables"
            case "map":
                places, size = targets(mission), pane.size
                rows = self._chart.draw(mission.robot, places, size.width, pane.room)
                return rows, map_title(mission.robot)
            case "node":
                return node_rows(mission, outlook.cursor, pane.size.width, marks), "selected node"
        start_ns = mission.tree.time_ns if mission.tree else 0
        log = mission.log
        first = max(len(log) - pane.room - self.scroll, 0)
        shown = [log[at] for at in range(first, min(first + pane.room, len(log)))]
        return log_rows(shown, start_ns, marks), "log"

    def _show_panel(self, name: str, rows: Rows, title: str) -> None:
        pane = self.panes[name]
        right = ""
        if name != "log":  # which is cut already, at its beginning
            self.scroll = min(self.scroll, max(len(rows) - pane.room, 0))
            if len(rows) > pane.room:
                right = f"{len(rows)} rows"
                rows = rows[self.scroll : self.scroll + pane.room]
        pane.show(rows, title, right)
