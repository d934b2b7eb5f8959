"""The nodes of a mission with their outcomes, those that were reached ticked off."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator

from py_trees.common import Status

from bt_mission.base.text import escape_control
from bt_mission.executive.events.log import glyphs_for
from bt_mission.language.nodes.registry import KINDS
from bt_mission.scenarios.coverage.places import CoveragePlace
from bt_mission.views.drawing.nodes import can_show

WIDTH = 100


def outcome_rows(places: Iterable[CoveragePlace], encoding: str | None) -> Iterator[str]:
    """Yield the lines of a tree: each node, below it its outcomes.

    Args:
        places: The nodes in the order of their trees.
        encoding: Of the stream, which may lack signs.
    """
    glyphs, has_signs = glyphs_for(encoding), can_show(encoding)
    tick, missing = glyphs[Status.SUCCESS], glyphs[Status.INVALID]
    yield f"outcomes of nodes: {tick} some run reaches it, {missing} none does"
    tree = ""
    for place in places:
        if place.tree != tree:
            tree = place.tree
            yield f"tree {escape_control(tree)}:"
        sign = KINDS[place.kind].sign
        head = f"{sign.glyph if has_signs else sign.ascii} {escape_control(place.name)}  "
        indent = "  " * (place.depth + 1)
        parts = [
            f"{tick if runs else missing} {name}"
            for marks in (place.outcomes, place.branches)
            for name, runs in marks.items()
        ]
        words = "  ".join(part.replace(" ", "\N{NO-BREAK SPACE}") for part in parts)
        lines = textwrap.wrap(
            words,
            WIDTH,
            initial_indent=indent + head,
            subsequent_indent=f"{indent}    ",
            break_on_hyphens=False,
        )
        yield from (line.replace("\N{NO-BREAK SPACE}", " ") for line in lines)
