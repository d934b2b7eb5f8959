"""Where boxes stand."""

from __future__ import annotations

from collections.abc import Iterator

from hypothesis import given
from hypothesis import strategies as st

from bt_mission.views.drawing.layout import NodeBox, place

SIZES = st.integers(10, 200).map(float)
TREES = st.recursive(
    st.builds(NodeBox, SIZES, SIZES),
    lambda boxes: st.builds(NodeBox, SIZES, SIZES, st.lists(boxes, min_size=1, max_size=4)),
    max_leaves=25,
)
GAP_X, GAP_Y = 10.0, 30.0


def boxes(root: NodeBox) -> Iterator[NodeBox]:
    """All boxes of a tree."""
    yield root
    for child in root.children:
        yield from boxes(child)


@given(TREES)
def test_no_box_touches_another_and_all_are_on_the_page(root: NodeBox) -> None:
    """Whatever their sizes; the page is as small as it can be."""
    width, height = place(root, GAP_X, GAP_Y)
    results = list(boxes(root))
    for index, first in enumerate(results):
        for other in results[index + 1 :]:
            apart_x = max(first.x, other.x) - min(first.x + first.width, other.x + other.width)
            apart_y = max(first.y, other.y) - min(first.y + first.height, other.y + other.height)
            assert apart_x >= GAP_X - 1e-6 or apart_y >= -1e-6
    assert min(box.x for box in results) == 0.0 or abs(min(box.x for box in results)) < 1e-6
    assert abs(max(box.x + box.width for box in results) - width) < 1e-6
    assert abs(max(box.y + box.height for box in results) - height) < 1e-6


@given(TREES)
def test_children_stand_in_order_below_the_middle_of_their_parent(root: NodeBox) -> None:
    """All at one height, the gap below it."""
    place(root, GAP_X, GAP_Y)
    for box in boxes(root):
        if box.children:
            first, last = box.children[0], box.children[-1]
            assert abs((first.middle + last.middle) / 2 - box.middle) < 1e-6
            assert all(child.y == box.y + box.height + GAP_Y for child in box.children)
            xs = [child.x for child in box.children]
            assert xs == sorted(xs)


def test_a_deep_subtree_reaches_below_a_short_neighbour() -> None:
    """So pictures stay narrow."""
    wide = NodeBox(50, 20, [NodeBox(300, 20)])
    root = NodeBox(50, 20, [NodeBox(50, 20), wide])
    width, _ = place(root, 10, 10)
    assert width < 50 + 10 + 300
