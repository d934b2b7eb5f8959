"""Rows of a tree: folded, revealed, found."""

from __future__ import annotations

import pytest

from bt_mission.views.terminal.tree_rows import Outline
from tests.support.watched import tree


@pytest.fixture
def outline() -> Outline:
    """0 explore, 1 look around, 2 repeat with 3 drive and 4 turn away."""
    return Outline(tree().nodes)


def test_all_nodes_are_shown_at_first(outline: Outline):
    """In the order of the tree, each with its depth."""
    assert outline.rows == [0, 1, 2, 3, 4]
    assert outline.depth == [0, 1, 1, 2, 2]


def test_a_folded_node_hides_what_lies_below_it(outline: Outline):
    """And says how much that is; a leaf does not fold."""
    outline.fold(2)
    assert (outline.rows, outline.hidden(2), outline.hidden(0)) == ([0, 1, 2], 2, 0)
    outline.fold(1)
    assert outline.folded == {2}
    outline.unfold(2)
    assert outline.rows == [0, 1, 2, 3, 4]


def test_a_hidden_node_has_the_row_of_the_folded_one_above_it(outline: Outline):
    """Folds within folds, too."""
    outline.fold(2)
    assert outline.row_of(4) == 2
    outline.fold(0)
    assert outline.row_of(4) == 0


def test_a_hidden_node_is_revealed(outline: Outline):
    """Other folds stay."""
    outline.fold_all()
    assert outline.rows == [0, 1, 2]
    assert outline.reveal(3) == 3
    assert outline.rows == [0, 1, 2, 3, 4]


def test_a_search_goes_round(outline: Outline):
    """Downwards and upwards; the node itself is found last."""
    assert outline.find(lambda index: index in (1, 4), 1) == 4
    assert outline.find(lambda index: index in (1, 4), 4) == 1
    assert outline.find(lambda index: index in (1, 4), 1, step=-1) == 4
    assert outline.find(lambda index: index == 1, 1) == 1
    assert outline.find(lambda _: False, 1) is None


def test_the_path_leads_from_the_root(outline: Outline):
    """All nodes above, and the node."""
    assert outline.path_to(4) == [0, 2, 4]


def test_a_tree_two_thousand_levels_deep_is_arranged():
    """No recursion: a chain is a tree, too."""
    deep = tree("\n".join("  " * level + str(level) for level in range(2_000)))
    outline = Outline(deep.nodes)
    outline.fold(10)
    assert len(outline.rows) == 11
    assert outline.row_of(1_999) == 10
