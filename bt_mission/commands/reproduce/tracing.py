"""Straight shapes from the cells of a map and the points of scans: walls, boxes, cylinders.

Small separate groups of cells become cylinders or boxes. Of the others, the longest straight runs
become walls, one after another, by the transform of Hough; a short rest becomes a box. The points
of scans then place each shape more finely than the cells can.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

Floats = npt.NDArray[np.float64]

SMALL_M = 0.75
"""A separate group of cells is one thing if it is not wider."""
ROUND_M = 0.022
"""A cylinder is one whose points are so near to a circle, RMS."""
LARGEST_RADIUS_M = 0.4
SHORTEST_WALL_M = 0.2
GAP_M = 0.22
"""A wall has no longer gap between its points."""
STRIP_M = 0.045
"""Points of a wall are so near to its line."""
REMOVED_M = 0.085
"""Points so near to a wall are explained by it."""
THINNEST_M = 0.02
MOST_WALLS = 300
ANGLES = np.radians(np.arange(0.0, 180.0, 1.0))


@dataclass(frozen=True)
class Segment:
    """A wall between two points, m."""

    a: tuple[float, float]
    b: tuple[float, float]
    thickness: float = THINNEST_M

    @property
    def length(self) -> float:
        """Its length, m."""
        return math.dist(self.a, self.b)

    def distances(self, points: Floats) -> Floats:
        """Return the distance of each point to it, m."""
        (ax, ay), (bx, by) = self.a, self.b
        direction = np.array([bx - ax, by - ay])
        along = ((points - (ax, ay)) @ direction) / max(float(direction @ direction), 1e-12)
        nearest = np.array([ax, ay]) + np.clip(along, 0, 1)[:, None] * direction
        away: Floats = np.hypot(*(points - nearest).T)
        return np.maximum(away - self.thickness / 2, 0.0)


@dataclass(frozen=True)
class Block:
    """A box: centre, length along its yaw (rad), width, m."""

    x: float
    y: float
    length: float
    width: float
    yaw: float

    def distances(self, points: Floats) -> Floats:
        """Return the distance of each point to its edges, m, inside and outside."""
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        dx, dy = points[:, 0] - self.x, points[:, 1] - self.y
        along = np.abs(cos * dx + sin * dy) - self.length / 2
        across = np.abs(cos * dy - sin * dx) - self.width / 2
        outside = np.hypot(np.maximum(along, 0), np.maximum(across, 0))
        return np.where(outside > 0, outside, -np.maximum(along, across))


@dataclass(frozen=True)
class Disc:
    """A cylinder, m."""

    x: float
    y: float
    radius: float

    def distances(self, points: Floats) -> Floats:
        """Return the distance of each point to its surface, m."""
        return np.abs(np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius)


Shape = Segment | Block | Disc


@dataclass(frozen=True)
class CellMap:
    """Cells of a map: `occupied[row, column]`; `resolution`, m, and the corner of the first."""

    occupied: npt.NDArray[np.bool_]
    resolution: float
    x: float
    y: float

    def centres(self, cells: npt.NDArray[np.bool_]) -> Floats:
        """Return the centres of cells, rows of x and y, m."""
        rows, columns = np.nonzero(cells)
        return np.column_stack(
            (self.x + (columns + 0.5) * self.resolution, self.y + (rows + 0.5) * self.resolution)
        )


def trace(cells: CellMap, points: Floats, *, smallest: int = 1) -> list[Shape]:
    """Return the shapes of a map.

    Args:
        points: Of scans, on the map, m.
        smallest: Groups of fewer cells are noise.
    """
    labels, sizes, spans = _components(cells.occupied)
    tree = KDTree(points) if len(points) else None
    shapes: list[Shape] = []
    rest: list[Floats] = []
    for label in range(1, len(sizes)):
        if sizes[label] < smallest:
            continue
        mask = labels == label if max(spans[label]) <= SMALL_M / cells.resolution else None
        if mask is not None:
            shape = _small(cells, mask, tree, points)
            if shape is not None:
                shapes.append(shape)
                continue
        rest.append(cells.centres(_surface(cells.occupied, labels == label)))
    if rest:
        shapes += _walls(np.vstack(rest), tree, points, cells.resolution)
    return shapes


def _components(
    occupied: npt.NDArray[np.bool_],
) -> tuple[npt.NDArray[np.int32], Sequence[int], Sequence[tuple[int, int]]]:
    components: Any = cv2.connectedComponentsWithStats(occupied.astype(np.uint8), connectivity=8)
    _, labels, stats, _ = components
    sizes = [int(size) for size in stats[:, cv2.CC_STAT_AREA]]
    spans = [(int(row[cv2.CC_STAT_WIDTH]), int(row[cv2.CC_STAT_HEIGHT])) for row in stats]
    return labels, sizes, spans


def _surface(occupied: npt.NDArray[np.bool_], mask: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the cells of a group at its edge: a lidar sees no others."""
    inside: Any = cv2.erode(
        np.pad(occupied, 1).astype(np.uint8), np.ones((3, 3), np.uint8), iterations=1
    )
    surface: npt.NDArray[np.bool_] = mask & ~inside[1:-1, 1:-1].astype(np.bool_)
    return surface


def _small(
    cells: CellMap, mask: npt.NDArray[np.bool_], tree: KDTree | None, points: Floats
) -> Shape | None:
    """Return one thing as a cylinder or a box, if it is one."""
    centres = cells.centres(mask)
    half = cells.resolution / 2
    near = _near(tree, points, centres, cells.resolution * 1.2)
    if len(near) >= 8:
        disc = fit_disc(near)
        if disc is not None:
            return disc
    corners = np.vstack(
        [centres + np.array([dx, dy]) for dx in (-half, half) for dy in (-half, half)]
    )
    own = near if len(near) >= 12 else corners
    (x, y), (length, width), angle = cv2.minAreaRect(own.astype(np.float32))
    if length < width:
        length, width, angle = width, length, angle + 90.0
    filled = len(centres) * cells.resolution**2 / max(length * width, 1e-9)
    if width > 0.15 and filled < 0.55 and len(near) < 12:
        return None
    if width > 0.15 and len(near) >= 12 and _explained(near, (x, y, length, width, angle)) < 0.7:
        return None
    return Block(
        float(x),
        float(y),
        max(float(length), THINNEST_M),
        max(float(width), THINNEST_M),
        math.radians(float(angle)),
    )


def _explained(points: Floats, rect: tuple[float, float, float, float, float]) -> float:
    x, y, length, width, angle = rect
    block = Block(x, y, length, width, math.radians(angle))
    return float(np.mean(block.distances(points) < 0.04))


def _near(tree: KDTree | None, points: Floats, centres: Floats, within: float) -> Floats:
    if tree is None:
        return np.empty((0, 2))
    neighbors = tree.query_ball_point(centres, within)
    numbers = sorted({number for several in neighbors for number in several})
    return points[numbers]


def fit_disc(points: Floats) -> Disc | None:
    """Return the circle through points, if they lie on one (least squares, Kåsa 1976)."""
    x, y = points[:, 0], points[:, 1]
    matrix = np.column_stack((x, y, np.ones(len(points))))
    solved: Any = np.linalg.lstsq(matrix, x * x + y * y, rcond=None)
    centre_x, centre_y, rest = solved[0]
    centre_x, centre_y = centre_x / 2, centre_y / 2
    square = rest + centre_x**2 + centre_y**2
    if not 0 < square < LARGEST_RADIUS_M**2:
        return None
    disc = Disc(float(centre_x), float(centre_y), math.sqrt(square))
    angles = np.arctan2(y - disc.y, x - disc.x)
    widest = np.ptp(np.unwrap(np.sort(angles)))
    rms = float(np.sqrt(np.mean(disc.distances(points) ** 2)))
    return disc if rms < ROUND_M and widest > math.radians(100) and disc.radius > 0.02 else None


# ---- walls -----------------------------------------------------------------------------------


def _walls(centres: Floats, tree: KDTree | None, points: Floats, resolution: float) -> list[Shape]:
    left = centres
    walls: list[Segment] = []
    cos, sin = np.cos(ANGLES), np.sin(ANGLES)
    while len(left) >= 2 and len(walls) < MOST_WALLS:
        run = _longest_run(left, cos, sin)
        if run is None:
            break
        segment = _fitted(left[run])
        if segment.length < SHORTEST_WALL_M - resolution:
            break
        walls.append(segment)
        left = left[segment.distances(left) > REMOVED_M]
    refined = [_refined(wall, tree, points, resolution) for wall in walls]
    small = [_block_of(group, resolution) for group in _groups(left) if len(group) >= 2]
    return [*_joined(refined), *small]


def _longest_run(points: Floats, cos: Floats, sin: Floats) -> npt.NDArray[np.intp] | None:
    """Return the numbers of the points of the longest straight run."""
    best: npt.NDArray[np.intp] | None = None
    most = 0.0
    rho = points @ np.vstack((cos, sin))
    bins = np.round((rho - rho.min()) / STRIP_M).astype(np.int64)
    width = int(bins.max()) + 1
    counts = np.zeros((len(ANGLES), width), np.int64)
    for number in range(len(ANGLES)):
        counts[number] = np.bincount(bins[:, number], minlength=width)
    for flat in np.argsort(counts, axis=None)[::-1][:24]:
        number, place = divmod(int(flat), width)
        if counts[number, place] < 2:
            continue
        middle = rho.min() + place * STRIP_M
        near = np.flatnonzero(np.abs(rho[:, number] - middle) <= STRIP_M)
        along = points[near] @ np.array([-sin[number], cos[number]])
        order = np.argsort(along)
        breaks = np.flatnonzero(np.diff(along[order]) > GAP_M)
        for part in np.split(order, breaks + 1):
            length = float(np.ptp(along[part])) if len(part) > 1 else 0.0
            # Of equal lengths the one whose points lie closer together on the line is better.
            spread = float(np.std(rho[near[part], number]))
            value = length - 3 * spread
            if value > most:
                best, most = near[part], value
    return best


def _fitted(points: Floats) -> Segment:
    """Return the segment through points: their main axis."""
    middle = points.mean(axis=0)
    parts: Any = np.linalg.svd(points - middle, full_matrices=False)
    direction = parts[2][0]
    along = (points - middle) @ direction
    a, b = middle + along.min() * direction, middle + along.max() * direction
    return Segment((float(a[0]), float(a[1])), (float(b[0]), float(b[1])))


def _refined(wall: Segment, tree: KDTree | None, points: Floats, resolution: float) -> Segment:
    """Return a wall where the points of scans have it, and its ends half a cell farther."""
    half = resolution / 2
    a, b = np.array(wall.a), np.array(wall.b)
    direction = (b - a) / max(wall.length, 1e-9)
    if tree is not None:
        steps = np.linspace(0, 1, max(2, int(wall.length / 0.05)))[:, None]
        near = _near(tree, points, a + steps * (b - a), 0.07)
        normal = np.array([-direction[1], direction[0]])
        if len(near) >= 15:
            along, off = (near - a) @ direction, (near - a) @ normal
            inside = (along > 0.03) & (along < wall.length - 0.03)
            if inside.sum() >= 15 and np.ptp(along[inside]) > 0.3 * wall.length:
                slope, offset = _robust_line(along[inside], off[inside])
                a = a + normal * offset
                b = a + direction * wall.length + normal * slope * wall.length
                rest = off[inside] - offset - slope * along[inside]
                spread = float(np.percentile(np.abs(rest), 90))
                thickness = min(max(THINNEST_M, 2 * (spread - 0.016)), 0.06)
                direction = (b - a) / max(float(np.hypot(*(b - a))), 1e-9)
                a, b = a - half * direction, b + half * direction
                return Segment((float(a[0]), float(a[1])), (float(b[0]), float(b[1])), thickness)
    a, b = a - half * direction, b + half * direction
    return Segment(
        (float(a[0]), float(a[1])), (float(b[0]), float(b[1])), max(THINNEST_M, resolution)
    )


def _robust_line(along: Floats, off: Floats) -> tuple[float, float]:
    """Return slope and offset of a line, with the points that are far from it left out."""
    keep = np.ones(len(along), np.bool_)
    slope, offset = 0.0, float(np.median(off))
    for _ in range(3):
        rest = off - offset - slope * along
        keep = np.abs(rest - np.median(rest)) < 0.03
        if keep.sum() < 10:
            break
        fitted: Any = np.polyfit(along[keep], off[keep], 1)
        slope, offset = float(fitted[0]), float(fitted[1])
    return slope, offset


def _joined(walls: list[Segment]) -> list[Shape]:
    """Return walls without those that lie along a longer one."""
    kept: list[Segment] = []
    for wall in sorted(walls, key=lambda each: -each.length):
        samples = np.linspace(0, 1, 9)[:, None] * (np.array(wall.b) - wall.a) + wall.a
        if any((other.distances(samples) < 0.05).mean() > 0.85 for other in kept):
            continue
        kept.append(wall)
    return list(kept)


def _groups(points: Floats) -> list[Floats]:
    """Return points that are near to each other together."""
    if not len(points):
        return []
    tree = KDTree(points)
    left = set(range(len(points)))
    groups = []
    while left:
        group, edge = set(), {left.pop()}
        while edge:
            group |= edge
            near = {
                number
                for several in tree.query_ball_point(points[list(edge)], 0.12)
                for number in several
            }
            edge = near & left
            left -= edge
        groups.append(points[sorted(group)])
    return groups


def _block_of(points: Floats, resolution: float) -> Block:
    (x, y), (length, width), angle = cv2.minAreaRect(points.astype(np.float32))
    return Block(
        float(x),
        float(y),
        max(float(length), resolution),
        max(float(width), resolution),
        math.radians(float(angle)),
    )
