"""The world of a recorded run: what stands still, from the map and the scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from action_servers.core.maneuver import Scan
from action_servers.mapping.occupancy import OccupancyMapper
from bt_mission.core.geometry import Pose2D
from bt_mission.core.robot.model import RobotModel
from bt_mission.reproducing.evidence import Evidence, Floats, SeenScan, points_of
from bt_mission.reproducing.tracing import Block, CellMap, Disc, Segment, Shape, trace

OCCUPIED_FROM = 65
MOST_MAPPED = 1500
"""Scans that a map is made of."""
HEIGHT = 0.5
FLOOR_EDGE_M = 0.5
STEP_M, STEP_RAD = 0.1, math.radians(6)
CAME_AND_WENT = 0.6
"""A group of cells of which this share was free at another time is no part of the world."""


@dataclass(frozen=True)
class Surroundings:
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
    evidence: Evidence, robot: RobotModel, doubtful: Sequence[tuple[float, float]] = ()
) -> Surroundings:
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
        return Surroundings(trace(cells, _thinned(cloud)), cloud, False, cells)
    cells = _mapped(evidence, robot, doubtful)
    return Surroundings(trace(cells, _thinned(cloud), smallest=2), cloud, True, cells)


MOST_POINTS = 40_000


def _thinned(points: Floats) -> Floats:
    return points[:: max(1, len(points) // MOST_POINTS)]


def _mapped(
    evidence: Evidence, robot: RobotModel, doubtful: Sequence[tuple[float, float]]
) -> CellMap:
    """Return a map of the scans, without what was there for a time only."""
    lidar = robot.lidar.model_copy(
        update={
            "x": evidence.mount.x,
            "y": evidence.mount.y,
            "max_range": max((scan.range_max for scan in evidence.scans), default=3.5),
            "min_range": min((scan.range_min for scan in evidence.scans), default=0.12),
        }
    )
    mapper = OccupancyMapper(lidar)
    stride = max(1, len(evidence.scans) // MOST_MAPPED)
    free, occupied = _Sheet(), _Sheet()
    for number, scan in enumerate(evidence.scans[::stride]):
        if any(begin <= scan.time_s <= end for begin, end in doubtful):
            continue
        pose = evidence.track.pose(scan.time_s)
        mapper.add(
            Scan(
                scan.stamp_s,
                scan.angle_min + evidence.mount.yaw,
                scan.increment,
                scan.range_min,
                scan.range_max,
                scan.ranges,
            ),
            pose,
        )
        if number % 10 == 0:
            grid = mapper.grid()
            free.mark(grid, grid.cells == 0)
            occupied.mark(grid, grid.cells == 100)
    if mapper.empty:
        return CellMap(np.zeros((1, 1), np.bool_), 0.05, 0.0, 0.0)
    grid = mapper.grid()
    free.mark(grid, grid.cells == 0)
    occupied.mark(grid, grid.cells == 100)
    seen, was_free = occupied.on(grid), free.on(grid)
    static = seen.copy()
    labelled: Any = cv2.connectedComponents(seen.astype(np.uint8), connectivity=8)
    for label in range(1, labelled[0]):
        group = labelled[1] == label
        if was_free[group].mean() > CAME_AND_WENT:
            static &= ~group
    static &= ~(was_free & (grid.cells == 0))
    return CellMap(static, grid.resolution, grid.origin_x, grid.origin_y)


class _Sheet:
    """Marks on cells of a map that grows."""

    def __init__(self) -> None:
        self._marks: set[tuple[int, int]] = set()

    def mark(self, grid: Any, cells: Any) -> None:
        """Mark cells of a map as it is."""
        row, column = self._first(grid)
        rows, columns = np.nonzero(cells)
        self._marks.update(zip((rows + row).tolist(), (columns + column).tolist(), strict=True))

    def on(self, grid: Any) -> Any:
        """Return the marks on a map, as a mask."""
        row, column = self._first(grid)
        mask = np.zeros(grid.cells.shape, np.bool_)
        if self._marks:
            places = np.array(sorted(self._marks)) - (row, column)
            inside = ((places >= 0) & (places < mask.shape)).all(axis=1)
            mask[tuple(places[inside].T)] = True
        return mask

    @staticmethod
    def _first(grid: Any) -> tuple[int, int]:
        return round(grid.origin_y / grid.resolution), round(grid.origin_x / grid.resolution)


# ---- as a file -------------------------------------------------------------------------------


def world_data(
    name: str, around: Surroundings, start: Pose2D, evidence: Evidence, description: str
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


def _floor(around: Surroundings, evidence: Evidence, start: Pose2D) -> list[float]:
    """Return the extent of the floor: its middle is the origin."""
    places = [around.cells.centres(around.cells.occupied), np.array([[start.x, start.y]])]
    places += [np.column_stack((evidence.track.x, evidence.track.y))]
    places += [np.array([[zone.x, zone.y] for zone in evidence.zones]).reshape(-1, 2)]
    reach = np.abs(np.vstack(places)).max(axis=0) + FLOOR_EDGE_M
    return [round(2 * float(reach[0]), 2), round(2 * float(reach[1]), 2)]
