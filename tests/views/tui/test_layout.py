"""Panes on terminals of any size."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_mission.views.tui.layout import PANELS, PanePlace, arranged


@given(
    width=st.integers(1, 400),
    height=st.integers(1, 120),
    panel=st.sampled_from(PANELS),
    large=st.booleans(),
    timed=st.booleans(),
)
def test_panes_neither_overlap_nor_leave_the_terminal(
    width: int, height: int, panel: str, *, large: bool, timed: bool
):
    """Whatever its size; from three rows on what is shown fills it from top to bottom."""
    places = arranged(width, height, panel, is_large=large, has_time=timed)
    cells: set[tuple[int, int]] = set()
    for name, place in places.items():
        if name == "foot" and height == 1:
            continue  # below the edge, where nobody sees it
        own = {(place.x + x, place.y + y) for x in range(place.width) for y in range(place.height)}
        assert not own & cells, name
        assert all(x < width and y < height for x, y in own), name
        cells |= own
    assert {y for _, y in cells} == set(range(height))


@pytest.mark.parametrize(
    ("size", "shown"),
    [
        ((80, 24), {"head", "path", "foot", "tree", "log"}),
        ((140, 45), {"head", "path", "foot", "tree", *PANELS}),
        ((80, 10), {"head", "path", "foot", "tree"}),
        ((20, 6), {"head", "foot", "tree"}),
    ],
)
def test_what_there_is_room_for_is_shown(size: tuple[int, int], shown: set[str]):
    """The tree always."""
    assert set(arranged(*size, "log", is_large=False)) == shown


def test_an_enlarged_panel_takes_the_place_of_all_others():
    """Also on a terminal that is too low for one beside the tree."""
    assert arranged(80, 10, "map", is_large=True)["map"] == PanePlace(0, 2, 80, 7)
