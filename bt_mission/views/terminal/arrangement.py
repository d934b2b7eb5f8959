"""Where the panes of a watcher's view stand on a terminal of any size."""

from __future__ import annotations

from dataclasses import dataclass

PANELS = ("log", "goals", "variables", "map", "node")
"""What may stand beside the tree, in the order in which one key goes through them."""

WIDE_COLUMNS, WIDE_ROWS = 110, 26
"""From this size on all panels are there at once; below it one at a time."""

PANEL_ROWS = 14
"""Below so many rows there is no panel at all, unless it is enlarged."""

PATH_ROWS = 8
"""Below so many rows the running path gives way to the tree."""

SIDE_COLUMNS = 64
"""At most so many for the panels beside the tree."""


TIME_ROWS = 4
"""Below so many rows a recording's line of time gives way to the tree."""


@dataclass(frozen=True)
class PanePlace:
    """Of a pane: its upper left corner and its size, in cells."""

    x: int
    y: int
    width: int
    height: int


def arranged(
    width: int, height: int, panel: str, *, is_large: bool, has_time: bool = False
) -> dict[str, PanePlace]:
    """The place of each pane that is shown.

    Args:
        panel: Which one is shown where there is room for one.
        is_large: Does it take the place of the tree, and of all others?
        has_time: Is there a line of time above the last one?
    """
    places = {"head": PanePlace(0, 0, width, 1)}
    top = 1
    if height >= PATH_ROWS:
        places["path"] = PanePlace(0, 1, width, 1)
        top = 2
    bottom = max(height - 1, top)
    places["foot"] = PanePlace(0, bottom, width, 1)
    if has_time and height >= TIME_ROWS:
        bottom -= 1
        places["time"] = PanePlace(0, bottom, width, 1)
    rows = bottom - top
    if is_large:
        places[panel] = PanePlace(0, top, width, rows)
    elif width >= WIDE_COLUMNS and height >= WIDE_ROWS:
        places |= _wide(width, top, rows)
    elif height >= PANEL_ROWS:
        below = min(max(rows // 3, 5), 12)
        places["tree"] = PanePlace(0, top, width, rows - below)
        places[panel] = PanePlace(0, bottom - below, width, below)
    else:
        places["tree"] = PanePlace(0, top, width, rows)
    return places


def _wide(width: int, top: int, rows: int) -> dict[str, PanePlace]:
    """Tree and log on the left, the others on the right."""
    side = min(width * 2 // 5, SIDE_COLUMNS)
    left, x = width - side - 1, width - side
    log = max(rows // 4, 6)
    node, goals = 6, max(rows // 5, 5)
    variables = max(rows // 7, 4)
    chart = rows - node - goals - variables
    heights = (("map", chart), ("goals", goals), ("variables", variables), ("node", node))
    places = {
        "tree": PanePlace(0, top, left, rows - log),
        "log": PanePlace(0, top + rows - log, left, log),
    }
    y = top
    for name, height in heights:
        places[name] = PanePlace(x, y, side, height)
        y += height
    return places
