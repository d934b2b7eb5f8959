"""Colours and sizes of pictures; families differ in shape and sign, too."""

from __future__ import annotations

from bt_mission.views.drawing.nodes import Family

FILLS = {
    Family.COMPOSITE: "#e4ebfa",
    Family.DECORATOR: "#fcefd2",
    Family.CONDITION: "#efe3f7",
    Family.ACTION: "#dff2e1",
    Family.MESSAGE: "#dcf1f5",
    Family.SUBTREE: "#ffffff",
    Family.OTHER: "#efefef",
}
STROKES = {
    Family.COMPOSITE: "#3d5a99",
    Family.DECORATOR: "#a9781b",
    Family.CONDITION: "#7d4aa0",
    Family.ACTION: "#2f7d3b",
    Family.MESSAGE: "#23788a",
    Family.SUBTREE: "#444444",
    Family.OTHER: "#777777",
}
INK = "#1c1c1c"
FAINT = "#555555"
PAPER = "#ffffff"
EDGE = "#8a8a8a"

FONT = "DejaVu Sans, Verdana, Helvetica, Arial, sans-serif"
NAME_PX = 13
DETAIL_PX = 11
LINE_PX = 15
PADDING_PX = 8
GAP_X_PX = 18
GAP_Y_PX = 30
MARGIN_PX = 16
WRAP_PX = 215
"""Details are wrapped at this width."""

MOST_DETAIL_LINES = 10
"""A goal with a long list would otherwise fill the page."""
