"""What a view shows of one executive, and its user's place in the tree."""

from __future__ import annotations

import pytest

from bt_mission.executive.events.messages import FrameTransform
from bt_mission.views.terminal.tree_rows import scrolled_to
from bt_mission.views.tui.watch_model import WatchModel
from tests.support.watched import S, ScriptedExecutive, begun


@pytest.fixture
def outlook(executive: ScriptedExecutive) -> WatchModel:
    """A view of it."""
    outlook = WatchModel()
    outlook.take(executive.take(needs_statuses=True), 0.0)
    return outlook


def test_a_new_mission_begins_with_a_new_tree(executive: ScriptedExecutive, outlook: WatchModel):
    """Folds, selection and trail are those of the mission before."""

    def place(model: WatchModel) -> tuple[int, int, int]:
        return model.cursor, len(model.mission.robot.trail), len(model.outline.rows)

    executive.show((FrameTransform("map", "base_link", 1.0, 0.0, 0.0),))
    outlook.take(executive.take(needs_statuses=False), 1.0)
    outlook.move(2)
    outlook.fold()
    assert place(outlook) == (2, 1, 3)
    executive.begin("another")
    outlook.take(executive.take(needs_statuses=False), 2.0)
    assert place(outlook) == (0, 0, 5)


def test_the_pace_is_that_of_the_mission(executive: ScriptedExecutive, outlook: WatchModel):
    """Its stamps against the wall."""
    for tenth in range(1, 11):
        executive.detail(0.5)
        outlook.take(executive.take(needs_statuses=False), tenth / 10)
    assert outlook.pace.factor == pytest.approx(5.0)


def test_without_a_mission_no_key_does_harm():
    """There is nothing to select, to fold or to find."""
    outlook = WatchModel()
    for act in (outlook.fold, outlook.unfold, outlook.toggle, outlook.fold_all, outlook.follow):
        act()
    outlook.move(1)
    assert outlook.breakpoint() is None
    assert not outlook.search("x", 0)
    assert (outlook.rows_in_view(10), outlook.running_path, outlook.cursor_row) == ([], [], 0)


def test_a_search_looks_at_names_classes_and_words(
    executive: ScriptedExecutive, outlook: WatchModel
):
    """Whatever their case; what hides the node is unfolded."""
    executive.change(0.1, turn_away="failure: aborted: BLOCKED")
    outlook.take(executive.take(needs_statuses=False), 0.0)
    outlook.fold_all()
    assert outlook.search("blocked", 0)
    assert (outlook.cursor, outlook.cursor_row) == (4, 4)
    assert outlook.search("ACTIONLEAF", 4)
    assert outlook.cursor == 0
    assert not outlook.search("nowhere", 0)


@pytest.mark.parametrize(
    ("row", "above", "top", "shown"),
    [
        (3, [0], 0, 0),  # in view: nothing moves
        (30, [0, 29], 0, 21),  # below: as little as needed
        (5, [0, 4], 20, 0),  # above: with all that fits above it
        (50, [0, 45, 49], 48, 45),  # in view, but not what it belongs to
        (99, [0], 0, 90),  # the end of the list
        (0, [], 50, 0),
    ],
)
def test_a_list_scrolls_no_further_than_it_has_to(row: int, above: list[int], top: int, shown: int):
    """Of a hundred rows ten are in view."""
    assert scrolled_to(row, above, top, 10, 100) == shown


def test_without_room_nothing_is_in_view():
    """A pane of no height asks for no row."""
    assert scrolled_to(5, [0], 3, 0, 100) == 0


def test_only_what_has_come_counts_as_news(executive: ScriptedExecutive, outlook: WatchModel):
    """So that nothing is drawn for nothing."""
    assert not outlook.take(executive.take(needs_statuses=False), 0.0)
    executive.say("hello")
    assert outlook.take(executive.take(needs_statuses=False), 0.0)
    assert outlook.mission.log[-1].text == "hello"
    assert outlook.mission.now_ns == S


def test_nodes_are_called_by_their_names():
    """A path says which where several have the name."""
    executive = begun("root\n  drive\n  turn\n  turn\n")
    outlook = WatchModel()
    outlook.take(executive.take(needs_statuses=False), 0.0)
    assert outlook.with_names("pauses before '0.0'") == "pauses before 'drive'"
    assert outlook.with_names("pauses before '0.2'") == "pauses before 'turn' (0.2)"
    assert outlook.with_names("unknown node '0.7'") == "unknown node '0.7'"
