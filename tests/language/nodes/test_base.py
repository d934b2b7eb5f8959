"""Nodes are frozen data with a walk."""

import pytest
from pydantic import ValidationError

from bt_mission.sessions.load import load


def test_the_walk_is_in_the_order_of_the_file():
    """A node, then what is below it, then what is behind it."""
    tree = load(
        "mission: m\ntree:\n  sequence:\n    - wait: 1\n    - repeat: {count: 2}\n"
        "      do: {fallback: [{wait: 2}]}\n    - wait: 3\n"
    ).tree
    kinds = [node.kind for node in tree.walk()]
    assert kinds == ["sequence", "wait", "repeat", "fallback", "wait", "wait"]
    (second,) = tree.below[1].below[0].below
    assert second.label == "wait"
    assert second.below == ()


def test_nodes_are_frozen():
    """A tree that is built from them can trust them."""
    node = load("mission: m\ntree: {wait: 1}\n").tree
    with pytest.raises(ValidationError, match="frozen"):
        node.seconds = 2  # type: ignore[attr-defined]
