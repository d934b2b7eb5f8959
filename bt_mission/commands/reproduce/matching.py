"""Poses from scans, where nothing places the robot on a map: each scan is fitted to those before.

Scans that the robot has moved between are laid over the points of the earlier ones, which removes
most of the drift of odometry. Fitted are points to lines (A. Censi, "An ICP variant using a
point-to-line metric", ICRA 2008), from the place that odometry says.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from bt_mission.base.geometry import Pose2D, composed, relative
from bt_mission.commands.reproduce.evidence import Evidence, Floats, Path2D, SeenScan, points_of
from bt_mission.commands.reproduce.surroundings import keyframes

MOST_KEYFRAMES = 800
ROUNDS = 12
FARTHEST_M = 0.35
LEAST_SHARE = 0.5
"""Of the points, that lie near earlier ones; with fewer, odometry is kept."""
CELL_M = 0.04
NEIGHBOURS = 6
MOST_STEP_M, MOST_STEP_RAD = 0.5, 0.5
"""Larger corrections are mistakes."""
FAR_S, CLEAR_S = 0.7, 0.02
"""S from a span to the scans around it: not more, and not less."""
LEAST_POINTS, MOST_OFF_M = 30, 0.2
"""Points of a scan that can be compared; one farther off is of another thing."""
BETTER = 0.8
"""The share of one misfit that another has to exceed."""


def matched(evidence: Evidence) -> Evidence:
    """Return the evidence with poses corrected by its scans, if nothing localises the robot."""
    if evidence.is_localised or len(evidence.scans) < 3:
        return evidence
    frames = keyframes(evidence)
    frames = [*frames[:: max(1, len(frames) // MOST_KEYFRAMES)], evidence.scans[-1]]
    track = evidence.track
    known: Floats = np.empty((0, 2))
    correction = Pose2D(0.0, 0.0, 0.0)
    times, corrections = [], []
    for scan in frames:
        guess = composed(correction, track.pose(scan.time_s))
        points = _points(scan, evidence.mount)
        pose = guess if len(known) < 30 else _fitted(points, guess, known)
        known = _with(known, _placed(points, pose))
        # The frame of odometry on the map, so that the poses between two scans move along.
        correction = composed(pose, relative(track.pose(scan.time_s), Pose2D(0.0, 0.0, 0.0)))
        times.append(scan.time_s)
        corrections.append((correction.x, correction.y, correction.yaw))
    return replace(evidence, track=_corrected(track, np.array(times), np.array(corrections)))


def is_seen(evidence: Evidence, begin: float, end: float, driven: Path2D) -> bool:
    """Return whether the robot has moved other than its wheels, by the scans around a span.

    A localiser that corrects itself moves the robot on the map alone: then the later scan lies on
    the earlier one where the wheels have put it. Without two scans nothing denies the motion.

    Args:
        driven: The path by the wheels alone.
    """
    before = [scan for scan in evidence.scans if begin - FAR_S < scan.time_s < begin - CLEAR_S]
    after = [scan for scan in evidence.scans if end + CLEAR_S < scan.time_s < end + FAR_S]
    if not before or not after:
        return True
    first, last = before[-1], after[0]
    known, points = (_points(scan, evidence.mount) for scan in (first, last))
    if min(len(known), len(points)) < LEAST_POINTS:
        return True
    on_map, by_wheels = (
        _misfit(_placed(points, relative(path.pose(first.time_s), path.pose(last.time_s))), known)
        for path in (evidence.track, driven)
    )
    return by_wheels > BETTER * on_map


def _misfit(placed: Floats, known: Floats) -> float:
    """Return how far points lie from the lines of known ones, in the mean, m."""
    distances, nearest = KDTree(known).query(placed, k=NEIGHBOURS)
    groups = known[nearest]
    middles = groups.mean(axis=1)
    off = ((middles - placed) * _normals(groups - middles[:, None])).sum(axis=1)
    is_near = (distances[:, -1] < FARTHEST_M) & (np.abs(off) < MOST_OFF_M)
    return float(np.where(is_near, np.abs(off), MOST_OFF_M).mean())


def _points(scan: SeenScan, mount: Pose2D) -> Floats:
    return points_of(scan, mount)[0]


def _placed(points: Floats, pose: Pose2D) -> Floats:
    cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.column_stack(
        (
            pose.x + cos * points[:, 0] - sin * points[:, 1],
            pose.y + sin * points[:, 0] + cos * points[:, 1],
        )
    )


def _fitted(points: Floats, guess: Pose2D, known: Floats) -> Pose2D:
    """Return the pose at which points of the robot's frame lie on known ones."""
    tree = KDTree(known)
    pose, share = guess, 0.0
    for number in range(ROUNDS):
        placed = _placed(points, pose)
        within = FARTHEST_M if number < ROUNDS // 2 else FARTHEST_M / 3
        distances, nearest = tree.query(placed, k=NEIGHBOURS)
        near = distances[:, -1] < within
        share = float(near.mean()) if len(near) else 0.0
        if near.sum() < 20:
            return guess
        groups = known[nearest[near]]
        middles = groups.mean(axis=1)
        normals = _normals(groups - middles[:, None])
        off = ((middles - placed[near]) * normals).sum(axis=1)
        arms = placed[near] - (pose.x, pose.y)
        turning = arms[:, 0] * normals[:, 1] - arms[:, 1] * normals[:, 0]
        weight = 1 / (1 + (off / 0.05) ** 2)
        matrix = np.column_stack((normals, turning)) * weight[:, None]
        solved: Any = np.linalg.lstsq(
            np.vstack((matrix, np.eye(3) * 0.3)), np.append(off * weight, np.zeros(3)), rcond=None
        )
        dx, dy, turn = map(float, solved[0])
        pose = Pose2D(pose.x + dx, pose.y + dy, pose.yaw + turn)
        if math.hypot(dx, dy) < 1e-4 and abs(turn) < 1e-4 and number >= ROUNDS // 2:
            break
    moved = math.dist((pose.x, pose.y), (guess.x, guess.y))
    turned = abs(math.remainder(pose.yaw - guess.yaw, math.tau))
    is_good = share > LEAST_SHARE and moved < MOST_STEP_M and turned < MOST_STEP_RAD
    return pose if is_good else guess


def _normals(groups: Floats) -> Floats:
    """Return the directions across groups of points around their middles."""
    xx = (groups[..., 0] ** 2).sum(axis=1)
    yy = (groups[..., 1] ** 2).sum(axis=1)
    xy = (groups[..., 0] * groups[..., 1]).sum(axis=1)
    along = 0.5 * np.arctan2(2 * xy, xx - yy)
    return np.column_stack((-np.sin(along), np.cos(along)))


def _with(known: Floats, points: Floats) -> Floats:
    """Return known points with new ones, one for each small cell."""
    if not len(known):
        every = points
    else:
        distances, _ = KDTree(known).query(points)
        every = np.vstack((known, points[distances > CELL_M]))
    return every[-40_000:]


def _corrected(track: Path2D, times: Floats, corrections: Floats) -> Path2D:
    x = np.interp(track.times, times, corrections[:, 0])
    y = np.interp(track.times, times, corrections[:, 1])
    yaw = np.interp(track.times, times, np.unwrap(corrections[:, 2]))
    cos, sin = np.cos(yaw), np.sin(yaw)
    return Path2D(
        track.times,
        x + cos * track.x - sin * track.y,
        y + sin * track.x + cos * track.y,
        track.yaw + yaw,
        "scans",
    )
