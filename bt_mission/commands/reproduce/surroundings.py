"""The world of a recorded run: what stands still, from the map and the scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from bt_mission.base.geometry import Pose2D
from bt_mission.commands.reproduce.evidence import Evidence, Floats, SeenScan, points_of
from bt_mission.commands.reproduce.tracing import Block, CellMap, Disc, Segment, Shape, trace

OCCUPIED_FROM = 65
MOST_MAPPED = 1500
"""Scans that a map is made of."""
HEIGHT = 0.5
FLOOR_EDGE_M = 0.5
STEP_M, STEP_RAD = 0.1, math.radians(6)
CELL_M, LARGEST_M = 0.05, 100.0
MAPPED_M = 8.0
"""Farther points are too inexact for a map."""
BLUR_M = 0.1
"""Points of a wall lie so far from each other: noise, poses, and rays that graze it."""
_BLUR = np.ones((5, 5), np.uint8)
HIT, MISS, MOST_ODDS = 0.9, 0.55, 3.5
OCCUPIED_ODDS, FREE_ODDS = 1.0, -1.1
"""Two ends of rays make an unknown cell occupied; two rays that pass make it free."""
LOST_RAYS = 0.25
"""Cells of walls on each ray without a return, from which it is lost and not free."""
CAME_AND_WENT = 0.6
"""A group of cells of which this share was free at another time is no part of the world."""


@dataclass(frozen=True)
class StaticSurroundings:
    """The things that stand still, as shapes.

    Attributes:
        shapes: Of walls and things.
        points: The points of scans that lie on them or near, m.
        is_mapped: Whether there was no map, and it was made of the scans.
        cells: The map.
    """

    shapes: Sequence[Shape]
    points: Floats
    is_mapped: bool
    cells: CellMap

    def distances(self, points: Floats) -> Floats:
        """Return the distance of each point to the nearest shape, m."""
        nearest = np.full(len(points), np.inf)
        for shape in self.shapes:
            np.minimum(nearest, shape.distances(points), out=nearest)
        return nearest


def keyframes(evidence: Evidence) -> list[SeenScan]:
    """Return the scans between which the robot has moved: those at rest repeat each other."""
    kept: list[SeenScan] = []
    last: Pose2D | None = None
    for scan in evidence.scans:
        pose = evidence.track.pose(scan.time_s)
        moved = last is None or (
            math.hypot(pose.x - last.x, pose.y - last.y) > STEP_M
            or abs(math.remainder(pose.yaw - last.yaw, math.tau)) > STEP_RAD
            or scan.time_s - kept[-1].time_s > 2.0
        )
        if moved:
            kept.append(scan)
            last = pose
    return kept


def surroundings(
    evidence: Evidence, doubtful: Sequence[tuple[float, float]] = ()
) -> StaticSurroundings:
    """Return what stands still around a recorded run.

    Args:
        doubtful: Times, s, in which scans or poses are not to be trusted.
    """
    trusted = [
        scan
        for scan in keyframes(evidence)
        if not any(begin <= scan.time_s <= end for begin, end in doubtful)
    ] or keyframes(evidence)
    points = [points_of(scan, evidence.lidar_pose(scan))[0] for scan in trusted]
    cloud = np.vstack(points) if points else np.empty((0, 2))
    grid = evidence.grid
    if grid is not None and evidence.is_localised:
        cells = CellMap(grid.cells >= OCCUPIED_FROM, grid.resolution, grid.x, grid.y)
        return StaticSurroundings(trace(cells, _thinned(cloud)), cloud, False, cells)
    cells = _mapped(evidence, doubtful)
    return StaticSurroundings(trace(cells, _thinned(cloud), smallest=2), cloud, True, cells)


MOST_POINTS = 40_000


def _thinned(points: Floats) -> Floats:
    return points[:: max(1, len(points) // MOST_POINTS)]


def _mapped(evidence: Evidence, doubtful: Sequence[tuple[float, float]]) -> CellMap:
    """Return a map of the scans, without what was there for a time only."""
    stride = max(1, len(evidence.scans) // MOST_MAPPED)
    views = [
        _View(scan, evidence.lidar_pose(scan))
        for scan in evidence.scans[::stride]
        if not any(begin <= scan.time_s <= end for begin, end in doubtful)
    ]
    if not any(len(view.ends) for view in views):
        return CellMap(np.zeros((1, 1), np.bool_), CELL_M, 0.0, 0.0)
    cells = _Cells(views)
    static = cells.static()
    if sum(cells.count_of(view.endless(), static) for view in views) < LOST_RAYS * sum(
        view.endless_rays.size for view in views
    ):  # else this lidar loses rays on surfaces, and they are not free
        static = _Cells(views, with_endless=True).static()
    return CellMap(static, CELL_M, *cells.corner)


class _View:
    """A scan from a place: the ends of its rays, and the places that they pass, m."""

    def __init__(self, scan: SeenScan, lidar: Pose2D) -> None:
        self._scan, self.lidar = scan, lidar
        points, _ = points_of(scan, lidar)
        self._lengths = np.hypot(points[:, 0] - lidar.x, points[:, 1] - lidar.y)
        near = self._lengths < MAPPED_M
        self.ends, self._lengths = points[near], self._lengths[near]
        self.endless_rays = np.flatnonzero(np.isposinf(scan.ranges))

    def passed(self) -> Floats:
        """Return places on rays, each up to the blur before its end."""
        away = self.ends - (self.lidar.x, self.lidar.y)
        bearings: Floats = np.arctan2(away[:, 1], away[:, 0])
        return self._places(bearings, self._lengths - BLUR_M)

    def endless(self) -> Floats:
        """Return places on rays without a return."""
        scan = self._scan
        rays = self.endless_rays.astype(np.float64)
        bearings: Floats = self.lidar.yaw + scan.angle_min + scan.increment * rays
        reach = min(scan.range_max, MAPPED_M) - BLUR_M
        return self._places(bearings, np.full(len(bearings), reach))

    def _places(self, bearings: Floats, lengths: Floats) -> Floats:
        steps = np.arange(self._scan.range_min, MAPPED_M, CELL_M)
        rays, numbers = np.nonzero(steps < lengths[:, None])
        away, angles = steps[numbers], bearings[rays]
        x = self.lidar.x + away * np.cos(angles)
        return np.column_stack((x, self.lidar.y + away * np.sin(angles)))


class _Cells:
    """Log-odds of cells, as the mapper of the robot has them, and the states that they have had.

    Args:
        views: In the order of time.
        with_endless: Rays without a return make cells free.
    """

    def __init__(self, views: Sequence[_View], *, with_endless: bool = False) -> None:
        ends = np.vstack([view.ends for view in views])
        middle = np.median(ends, axis=0)
        low = np.maximum(ends.min(axis=0), middle - LARGEST_M / 2) - BLUR_M
        high = np.minimum(ends.max(axis=0), middle + LARGEST_M / 2) + BLUR_M
        first = np.floor(low / CELL_M).astype(np.intp)
        columns, rows = np.ceil(high / CELL_M).astype(np.intp) - first
        self.corner = float(first[0] * CELL_M), float(first[1] * CELL_M)
        self._odds = np.zeros((rows, columns), np.float32)
        self._was_free = np.zeros((rows, columns), np.bool_)
        self._was_occupied = np.zeros((rows, columns), np.bool_)
        for view in views:
            passed = view.passed()
            self._add(view.ends, np.vstack((passed, view.endless())) if with_endless else passed)

    def static(self) -> npt.NDArray[np.bool_]:
        """Return the cells that were occupied, without those of things that came and went."""
        static = self._was_occupied.copy()
        labelled: Any = cv2.connectedComponents(static.astype(np.uint8), connectivity=8)
        groups = labelled[1].ravel()
        size = np.bincount(groups, minlength=labelled[0])
        free = np.bincount(groups, self._was_free.ravel(), minlength=labelled[0])
        static &= (free <= CAME_AND_WENT * size)[labelled[1]]
        static &= ~(self._was_free & (self._odds <= FREE_ODDS))
        return static

    def count_of(self, places: Floats, cells: npt.NDArray[np.bool_]) -> int:
        """Return how many of these cells are at the places."""
        return int((self._marked(places).astype(np.bool_) & cells).sum())

    def _add(self, ends: Floats, clear: Floats) -> None:
        """Add a scan. A ray does not free cells beside the ends of others: walls are blurred."""
        struck, passed = self._marked(ends), self._marked(clear)
        passed &= cv2.dilate(struck, _BLUR) == 0
        self._odds += HIT * struck - MISS * passed
        np.clip(self._odds, -MOST_ODDS, MOST_ODDS, out=self._odds)
        self._was_free |= self._odds <= FREE_ODDS
        self._was_occupied |= self._odds >= OCCUPIED_ODDS

    def _marked(self, places: Floats) -> npt.NDArray[np.uint8]:
        marks: npt.NDArray[np.uint8] = np.zeros(self._odds.shape, np.uint8)
        x, y = self.corner
        columns = np.floor((places[:, 0] - x) / CELL_M).astype(np.intp)
        rows = np.floor((places[:, 1] - y) / CELL_M).astype(np.intp)
        inside = (rows >= 0) & (columns >= 0)
        inside &= (rows < marks.shape[0]) & (columns < marks.shape[1])
        marks[rows[inside], columns[inside]] = 1
        return marks


# ---- as a file -------------------------------------------------------------------------------


def world_data(
    name: str, around: StaticSurroundings, start: Pose2D, evidence: Evidence, description: str
) -> dict[str, Any]:
    """Return the world as its file has it."""
    walls, boxes, cylinders = [], [], []
    for shape in around.shapes:
        match shape:
            case Segment():
                walls.append(
                    {
                        "from": _point(shape.a),
                        "to": _point(shape.b),
                        "thickness": round(shape.thickness, 3),
                        "height": HEIGHT,
                    }
                )
            case Block():
                boxes.append(
                    {
                        "x": round(shape.x, 3),
                        "y": round(shape.y, 3),
                        "size": [round(shape.length, 3), round(shape.width, 3), HEIGHT],
                        "yaw": round(math.degrees(math.remainder(shape.yaw, math.pi)), 1),
                    }
                )
            case Disc():
                cylinders.append(
                    {
                        "x": round(shape.x, 3),
                        "y": round(shape.y, 3),
                        "radius": round(shape.radius, 3),
                        "height": HEIGHT,
                    }
                )
    data: dict[str, Any] = {
        "name": name,
        "description": description,
        "size": _floor(around, evidence, start),
        "spawn": pose_data(start),
    }
    data |= {
        key: value
        for key, value in (("walls", walls), ("boxes", boxes), ("cylinders", cylinders))
        if value
    }
    if evidence.zones:
        names: dict[str, int] = {}
        data["zones"] = [
            {
                "name": zone.name or f"zone {number + 1}",
                "x": round(zone.x, 3),
                "y": round(zone.y, 3),
                "radius": round(zone.radius, 3),
            }
            for number, zone in enumerate(evidence.zones)
            if names.setdefault(zone.name or f"zone {number + 1}", number) == number
        ]
    return data


def pose_data(pose: Pose2D) -> dict[str, float]:
    """Return a pose in m and degrees."""
    return {
        "x": round(pose.x, 3),
        "y": round(pose.y, 3),
        "yaw": round(math.degrees(pose.yaw), 1),
    }


def _point(point: tuple[float, float]) -> list[float]:
    return [round(point[0], 3), round(point[1], 3)]


def _floor(around: StaticSurroundings, evidence: Evidence, start: Pose2D) -> list[float]:
    """Return the extent of the floor: its middle is the origin."""
    places = [around.cells.centres(around.cells.occupied), np.array([[start.x, start.y]])]
    places += [np.column_stack((evidence.track.x, evidence.track.y))]
    places += [np.array([[zone.x, zone.y] for zone in evidence.zones]).reshape(-1, 2)]
    reach = np.abs(np.vstack(places)).max(axis=0) + FLOOR_EDGE_M
    return [round(2 * float(reach[0]), 2), round(2 * float(reach[1]), 2)]
