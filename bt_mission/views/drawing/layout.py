"""The places of the boxes of a tree: children in a row below their parent, as near as they fit.

Each subtree keeps the outline of its left and of its right side, from its top to its bottom. The
next one is pushed along it until no two boxes are too near. So small boxes fit below a short
neighbour, whatever its level.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field


@dataclass
class NodeBox:
    """A box with those below it; ``x`` and ``y`` are its upper left corner, once placed."""

    width: float
    height: float
    children: list[NodeBox] = field(default_factory=list)
    x: float = 0.0
    y: float = 0.0

    def walk(self) -> Iterator[NodeBox]:
        """Yield this box and all below it, depth first."""
        yield self
        for child in self.children:
            yield from child.walk()

    @property
    def middle(self) -> float:
        """The x of its centre."""
        return self.x + self.width / 2


@dataclass(frozen=True)
class _Piece:
    """A part of an outline: from ``top`` to ``bottom`` the side is at ``x``."""

    top: float
    bottom: float
    x: float


@dataclass
class _Outline:
    """Both sides of a subtree from top to bottom without gaps, relative to its root's centre."""

    left: list[_Piece]
    right: list[_Piece]


def place(root: NodeBox, gap_x: float, gap_y: float) -> tuple[float, float]:
    """Place every box, the leftmost at x = 0. Return width and height of the whole."""
    offsets: dict[int, float] = {}
    outline = _arrange(root, 0.0, (gap_x, gap_y), offsets)
    shift = -min(piece.x for piece in outline.left)
    waiting = [(root, shift)]
    while waiting:
        box, middle = waiting.pop()
        box.x = middle - box.width / 2
        waiting += [(child, middle + offsets[id(child)]) for child in box.children]
    return shift + max(piece.x for piece in outline.right), outline.left[-1].bottom


def _arrange(
    box: NodeBox, top: float, gaps: tuple[float, float], offsets: dict[int, float]
) -> _Outline:
    """Compute the height of each box, and its offset from its parent's centre.

    Return the outline.
    """
    gap_x, gap_y = gaps
    half, box.y = box.width / 2, top
    bottom = top + box.height
    # What is above a box, up to its parent, is for the line between them.
    above = top - gap_y if top else top
    left, right = [_Piece(above, bottom, -half)], [_Piece(above, bottom, half)]
    if not box.children:
        return _Outline(left, right)
    places: list[float] = []
    lefts: list[_Piece] = []
    rights: list[_Piece] = []
    for child in box.children:
        below = _arrange(child, bottom + gap_y, gaps, offsets)
        at = max((gap_x + overlap for overlap in _overlaps(rights, below.left)), default=0.0)
        places.append(at)
        lefts += _beyond(_moved(below.left, at), lefts)
        moved = list(_moved(below.right, at))
        rights = [*moved, *_beyond(rights, moved)]
    middle = (places[0] + places[-1]) / 2
    for child, at in zip(box.children, places, strict=True):
        offsets[id(child)] = at - middle
    return _Outline([*left, *_moved(lefts, -middle)], [*right, *_moved(rights, -middle)])


def _overlaps(right: list[_Piece], left: list[_Piece]) -> Iterable[float]:
    """Yield how far a left side would reach into a right one, wherever they are side by side."""
    index = other = 0
    while index < len(right) and other < len(left):
        first, second = right[index], left[other]
        if min(first.bottom, second.bottom) > max(first.top, second.top):
            yield first.x - second.x
        if first.bottom <= second.bottom:
            index += 1
        else:
            other += 1


def _moved(pieces: Iterable[_Piece], by: float) -> Iterable[_Piece]:
    return (_Piece(piece.top, piece.bottom, piece.x + by) for piece in pieces)


def _beyond(pieces: Iterable[_Piece], known: list[_Piece]) -> list[_Piece]:
    """The pieces below all that is known."""
    end = known[-1].bottom if known else float("-inf")
    return [
        _Piece(max(piece.top, end), piece.bottom, piece.x) for piece in pieces if piece.bottom > end
    ]
