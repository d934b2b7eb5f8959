"""Panes on terminals of any size."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_mission.views.tui.layout import PANELS, REQUIREMENTS, Content, PanePlace, arranged


@given(
    width=st.integers(1, 400),
    height=st.integers(1, 120),
    panel=st.sampled_from(PANELS),
    large=st.booleans(),
    timed=st.booleans(),
    requirements=st.integers(0, 30),
)
def test_panes_neither_overlap_nor_leave_the_terminal(
    width: int, height: int, panel: str, *, large: bool, timed: bool, requirements: int
):
    """Whatever its size; from three rows on what is shown fills it from top to bottom."""
    content = Content(has_time=timed, requirements=requirements)
    places = arranged(width, height, panel, content, is_large=large)
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
    ("size", "requirements", "shown"),
    [
        ((80, 24), 20, {"head", "path", "foot", "tree", "log"}),
        ((140, 45), 1, {"head", "path", "foot", "tree", *PANELS}),
        ((140, 45), 0, {"head", "path", "foot", "tree", *PANELS} - {REQUIREMENTS}),
        ((80, 10), 20, {"head", "path", "foot", "tree"}),
        ((20, 6), 20, {"head", "foot", "tree"}),
    ],
)
def test_what_there_is_room_for_is_shown(size: tuple[int, int], requirements: int, shown: set[str]):
    """The tree always; requirements where the mission has any."""
    content = Content(requirements=requirements)
    assert set(arranged(*size, "log", content, is_large=False)) == shown


def test_twenty_requirements_leave_room_for_the_tree():
    """They are scrolled in the enlarged panel; a few stand there in full."""
    for count, rows in ((3, 4), (20, 9)):
        places = arranged(120, 40, "log", Content(requirements=count), is_large=False)
        assert places[REQUIREMENTS].height == rows
        assert places["tree"].height > 15


def test_an_enlarged_panel_takes_the_place_of_all_others():
    """Also on a terminal that is too low for one beside the tree."""
    assert arranged(80, 10, "map", Content(), is_large=True)["map"] == PanePlace(0, 2, 80, 7)
