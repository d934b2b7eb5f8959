"""Faults that the scans show: noise, bias, blind rays, scans that repeat; and things that come."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from bt_mission.base.geometry import Pose2D
from bt_mission.base.text import seconds
from bt_mission.commands.reproduce.diagnosed import DiagnosedFault, fault_at
from bt_mission.commands.reproduce.evidence import Evidence, Floats, SeenScan, points_of
from bt_mission.commands.reproduce.silences import spans_where
from bt_mission.commands.reproduce.surroundings import HEIGHT, StaticSurroundings
from bt_mission.commands.reproduce.tracing import Block, Disc, Segment, fit_disc

MOST_SCANS = 1500
NOISE_M, BIAS_M, BLIND_SHARE = 0.008, 0.025, 0.06
NOISY_M, BIASED_M, LOST_SHARE = 0.03, 0.02, 0.1
"""A lidar whose scans all differ more from the world is so by its nature, which is no fault."""
SILENT_NOISE_M = 0.012
LEAST_BIAS_M, AGREES = 0.03, 0.75
"""M, and the share of rays that agree on it: less is within what a robot's place is known by."""
LEAST_SCANS = 3
NEW_M = 0.13
"""A point this far from all that stands still belongs to something that came."""
BLUR_SHARE, BLUR_M, BLURS, MOST_BLUR_M = 60, 0.02, 2.5, 0.1
"""Of a scan, this percentile of the distances to the world is its blur, m: more than usual, it is
of the pose, and a thing has to be farther away by this multiple. A scan of more shows nothing."""
FIT_SHARE, FIT_ROUNDS, FIT_STEP = 70, 6, 1e-3
MOST_SHIFT_M, MOST_SHIFT_RAD = 0.5, 0.3
"""The percentage of points that decide where a scan fits, and how far it may be from its place."""
EXACT_M, FAR_SHARE = 3.5, 0.04
"""Ranges beyond this vary by this share of the rest, m; from there, rays miss thin things."""
WALL_M, ASKEW_M = 0.4, 0.3
"""A thing that is longer, and so near to the world, cannot be distinguished from a wall."""
THROUGH_M = 0.2
"""A ray that reaches so far past a place shows that nothing is there."""
SEEN_THROUGH = 0.25
"""A place is empty if something is there in a smaller share of scans."""
CLUSTER_M = 0.16
LEAST_POINTS = 3
FOLLOWED_M = 0.4
LEAST_SEEN_S = 0.4
MOVES_M = 0.4
MOST_OBSTACLES = 4
THICKNESS_M = 0.1
"""Of a thing of which one side was seen only."""


def battery_faults(evidence: Evidence) -> Iterator[DiagnosedFault]:
    """Yield jumps of the battery's charge."""
    table = evidence.battery
    if len(table) < 3:
        return
    scale = 100.0 if float(table[:, 1].max()) > 1.5 else 1.0
    shares = table[:, 1] / scale
    for number in np.flatnonzero(np.abs(np.diff(shares)) > 0.03)[:6]:
        at, share = float(table[number, 0]), min(max(float(shares[number + 1]), 0.0), 1.0)
        start = at + 0.01
        yield DiagnosedFault(
            fault_at(start, "battery_charge", round(share, 3)),
            f"the charge goes from {shares[number]:.0%} to {share:.0%} at once",
            0.95,
            round(start, 2),
        )


def frozen_faults(evidence: Evidence) -> Iterator[DiagnosedFault]:
    """Yield the spans in which scans repeat the one before, to the last bit."""
    period = evidence.topics["scan"].period_s if "scan" in evidence.topics else 0.1
    for begin, end in evidence.frozen:
        if end - begin < 1.5 * period or end < 0:
            continue
        lasting = None if end >= evidence.end_s - period else end - begin - period
        yield DiagnosedFault(
            fault_at(begin + period / 2, "lidar_frozen", lasting=lasting),
            f"scans repeat exactly from {seconds(begin)} to {seconds(end)}",
            0.95,
            round(begin + period / 2, 2),
            None if lasting is None else round(end, 2),
        )


# ---- scans against the world -----------------------------------------------------------------


@dataclass(frozen=True)
class Sight:
    """How scans differ from what the world shows; one value for each scan."""

    times: Floats
    noise: Floats
    bias: Floats
    lost: Floats
    agreement: Floats
    """The share of rays that differ in the direction of the bias, by a half to twice as much."""
    lost_rays: npt.NDArray[np.bool_]
    """Rays without a return where a surface is in range: a row for each scan."""
    expected_rays: npt.NDArray[np.bool_]
    bearings: Floats


def ray_lengths(around: StaticSurroundings, lidar: Pose2D, angles: Floats) -> Floats:
    """Return the distance of the nearest surface along each ray, m; infinite without one."""
    nearest = np.full(len(angles), np.inf)
    directions = np.column_stack((np.cos(angles), np.sin(angles)))
    for shape in around.shapes:
        match shape:
            case Segment():
                _meet(nearest, lidar, directions, shape.a, shape.b)
            case Block():
                for a, b in _edges(shape):
                    _meet(nearest, lidar, directions, a, b)
            case Disc():
                dx, dy = shape.x - lidar.x, shape.y - lidar.y
                along = directions @ np.array([dx, dy])
                across = dx * dx + dy * dy - along**2
                half = shape.radius**2 - across
                hit = (half > 0) & (along > 0)
                np.minimum(
                    nearest,
                    np.where(hit, along - np.sqrt(np.maximum(half, 0)), np.inf),
                    out=nearest,
                )
    return nearest


def _edges(block: Block) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    cos, sin = math.cos(block.yaw), math.sin(block.yaw)
    corners = [
        (
            block.x + cos * a * block.length / 2 - sin * b * block.width / 2,
            block.y + sin * a * block.length / 2 + cos * b * block.width / 2,
        )
        for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
    ]
    return list(zip(corners, [*corners[1:], corners[0]], strict=True))


def _meet(
    nearest: Floats,
    lidar: Pose2D,
    directions: Floats,
    a: tuple[float, float],
    b: tuple[float, float],
) -> None:
    """Shorten rays to where they meet a segment."""
    edge_x, edge_y = b[0] - a[0], b[1] - a[1]
    to_x, to_y = a[0] - lidar.x, a[1] - lidar.y
    cross = directions[:, 0] * edge_y - directions[:, 1] * edge_x
    with np.errstate(divide="ignore", invalid="ignore"):
        along_ray = (to_x * edge_y - to_y * edge_x) / cross
        along_edge = (to_x * directions[:, 1] - to_y * directions[:, 0]) / cross
    hit = (along_ray > 0) & (along_edge >= 0) & (along_edge <= 1)
    np.minimum(nearest, np.where(hit, along_ray, np.inf), out=nearest)


def sight_of(evidence: Evidence, around: StaticSurroundings) -> Sight | None:
    """Return how scans differ from the world; None without scans."""
    scans = evidence.scans[:: max(1, len(evidence.scans) // MOST_SCANS)]
    sizes = [scan.ranges.size for scan in scans]
    if not sizes:
        return None
    size = max(set(sizes), key=sizes.count)
    scans = [scan for scan in scans if scan.ranges.size == size]
    rows = [_compare(scan, around, evidence.lidar_pose(scan)) for scan in scans]
    first = scans[0]
    numbers = np.arange(size, dtype=np.float64)
    bearings: Floats = evidence.mount.yaw + first.angle_min + first.increment * numbers
    return Sight(
        np.array([scan.time_s for scan in scans]),
        np.array([row[0] for row in rows]),
        np.array([row[1] for row in rows]),
        np.array([row[2] for row in rows]),
        np.array([row[3] for row in rows]),
        np.array([row[4] for row in rows]),
        np.array([row[5] for row in rows]),
        bearings,
    )


def _compare(
    scan: SeenScan, around: StaticSurroundings, lidar: Pose2D
) -> tuple[float, float, float, float, npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
    ranges = scan.ranges.astype(np.float64)
    numbers = np.arange(ranges.size, dtype=np.float64)
    angles: Floats = lidar.yaw + scan.angle_min + scan.increment * numbers
    expected = ray_lengths(around, lidar, angles)
    with np.errstate(invalid="ignore"):
        got = (ranges >= scan.range_min) & (ranges <= scan.range_max)
        visible = (expected > scan.range_min + 0.1) & (expected < scan.range_max - 0.15)
    difference = np.where(got & visible, ranges - np.where(visible, expected, 0.0), np.nan)
    near = np.abs(difference) < 0.4
    with np.errstate(invalid="ignore"):
        second = np.abs(ranges[:-2] - 2 * ranges[1:-1] + ranges[2:])
    smooth = got[:-2] & got[1:-1] & got[2:]
    noise = float(np.median(second[smooth])) / (0.6745 * math.sqrt(6)) if smooth.sum() > 10 else 0.0
    bias = float(np.median(difference[near])) if near.sum() > 10 else 0.0
    lost = visible & ~got
    share = float(lost.sum() / visible.sum()) if visible.sum() > 10 else 0.0
    agrees = np.abs(difference[near] - bias) < max(abs(bias) / 2, BIAS_M)
    return noise, bias, share, float(agrees.mean()) if agrees.size else 0.0, lost, visible


def sight_faults(evidence: Evidence, around: StaticSurroundings) -> Iterator[DiagnosedFault]:
    """Yield noise, bias and blindness of the lidar."""
    sight = sight_of(evidence, around)
    if sight is None or len(sight.times) < 2 * LEAST_SCANS:
        return
    step = float(np.median(np.diff(sight.times)))
    usual_noise, spread = _usual(sight.noise, NOISY_M, SILENT_NOISE_M)
    noisy = sight.noise > 1.35 * usual_noise + NOISE_M / 2 + spread
    for begin, end, lasting in _spans(evidence, sight, noisy, step):
        if lasting is None and begin <= sight.times[0] + step:
            continue  # from the first scan to the last: it is the lidar's own
        inside = (sight.times >= begin) & (sight.times <= end)
        level = float(np.median(sight.noise[inside]))
        sigma = round(math.sqrt(max(level**2 - usual_noise**2, 1e-6)), 3)
        yield DiagnosedFault(
            fault_at(begin - step / 2, "lidar_noise", sigma, lasting=lasting),
            f"ranges of neighbouring rays vary by {level:.3f} m, {usual_noise:.3f} m otherwise",
            0.9,
            round(begin - step / 2, 2),
            None if lasting is None else round(end, 2),
        )
    usual_bias = float(np.median(sight.bias))
    size, spread = _usual(np.abs(sight.bias), BIASED_M, 0.0)
    usual_bias = math.copysign(size, usual_bias) if size else 0.0
    off = np.abs(sight.bias - usual_bias) > BIAS_M + spread + 3 * min(size, BIASED_M)
    for begin, end, lasting in _spans(evidence, sight, off, step):
        inside = (sight.times >= begin) & (sight.times <= end)
        metres = round(float(np.median(sight.bias[inside])) - usual_bias, 2)
        # A wrong pose makes the ranges of one side longer, and those of the other shorter.
        agrees = float(np.median(sight.agreement[inside])) > AGREES
        if abs(metres) < LEAST_BIAS_M or not agrees:
            continue
        yield DiagnosedFault(
            fault_at(begin - step / 2, "lidar_bias", metres, lasting=lasting),
            f"ranges are {metres:+g} m from the surfaces of the world",
            0.85,
            round(begin - step / 2, 2),
            None if lasting is None else round(end, 2),
        )
    usual_lost, spread = _usual(sight.lost, LOST_SHARE, 0.0)
    blind = sight.lost > usual_lost + BLIND_SHARE + spread
    for begin, end, lasting in _spans(evidence, sight, blind, step):
        yield _blind(sight, begin, end, lasting, step)


def _usual(values: Floats, most: float, sound: float) -> tuple[float, float]:
    """Return the usual value, and by how much values differ from it without a fault.

    Args:
        most: The median of a good lidar is smaller.
        sound: Usual if the median is larger for a part of the run only; then a fault lasts long.
    """
    middle, low = float(np.median(values)), float(np.percentile(values, 10))
    if middle < most:
        return middle, 0.0
    return (sound, 0.0) if low < most else (middle, 3 * (middle - low))


def _spans(
    evidence: Evidence, sight: Sight, is_so: npt.NDArray[np.bool_], step: float
) -> list[tuple[float, float, float | None]]:
    spans = spans_where(sight.times, is_so, LEAST_SCANS, gap_s=2.1 * step)
    at_the_end = evidence.end_s - 1.5 * step
    return [
        (begin, end, None if end >= at_the_end else end - begin + step)
        for begin, end in spans
        if begin >= 0 or end > 0
    ]


def _blind(
    sight: Sight, begin: float, end: float, lasting: float | None, step: float
) -> DiagnosedFault:
    inside = (sight.times >= begin) & (sight.times <= end)
    expected = sight.expected_rays[inside].sum(axis=0)
    lost = sight.lost_rays[inside].sum(axis=0)
    known = expected >= max(2, 0.3 * inside.sum())
    share = np.where(known, lost / np.maximum(expected, 1), 0.0)
    blind = known & (share > 0.9)
    start = begin - step / 2
    stop = None if lasting is None else round(end, 2)
    if blind.sum() >= 3 and share[known & ~blind].mean() < 0.1:
        low, high = _sector(sight.bearings, blind)
        return DiagnosedFault(
            fault_at(start, "lidar_blind", (low, high), lasting=lasting),
            f"no returns between {low:g} and {high:g} deg, where the world has surfaces",
            0.9,
            round(start, 2),
            stop,
        )
    part = round(min(float(lost.sum() / max(expected.sum(), 1)), 1.0), 2)
    return DiagnosedFault(
        fault_at(start, "lidar_blind", share=part, lasting=lasting),
        f"{part:.0%} of the rays have no return, where the world has surfaces",
        0.85,
        round(start, 2),
        stop,
    )


def _sector(bearings: Floats, blind: npt.NDArray[np.bool_]) -> tuple[float, float]:
    """Return the sector of blind rays, degrees: outside of the largest gap between them."""
    degrees = np.sort(np.degrees(np.angle(np.exp(1j * bearings[blind]))))
    gaps = np.diff(np.concatenate((degrees, [degrees[0] + 360])))
    widest = int(np.argmax(gaps))
    low, high = float(degrees[(widest + 1) % len(degrees)]), float(degrees[widest])
    middle = low + ((high - low) % 360) / 2
    half = ((high - low) % 360) / 2 + 0.5
    middle = (middle + 180) % 360 - 180
    return round(middle - half, 1), round(middle + half, 1)


def fit_of(evidence: Evidence, around: StaticSurroundings) -> Floats:
    """Return how well scans fit the world: rows of times, s, and the usual distance from it, m."""
    rows = []
    for scan in evidence.scans[:: max(1, len(evidence.scans) // MOST_SCANS)]:
        points, _ = points_of(scan, evidence.lidar_pose(scan))
        if len(points) > LEAST_POINTS:
            rows.append((scan.time_s, float(np.percentile(around.distances(points), BLUR_SHARE))))
    return np.array(rows, np.float64).reshape(-1, 2)


# ---- things that come and go -----------------------------------------------------------------


@dataclass
class _SeenObject:
    """A thing in scans that is not in the world: places over time."""

    times: list[float] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)
    points: list[Floats] = field(default_factory=list)
    viewers: list[tuple[float, float]] = field(default_factory=list)


@dataclass(frozen=True)
class Visitor:
    """A thing that was there for a time, with its motion; lengths are m, times s.

    Attributes:
        places: Where it was, each with its time; one if it stood.
        was_there: Whether it was there when its place was first seen.
    """

    start: float
    end: float | None
    x: float
    y: float
    radius: float | None
    size: tuple[float, float]
    yaw: float
    places: Sequence[tuple[float, float, float]]
    was_there: bool
    points: Floats

    @property
    def moves(self) -> bool:
        """Whether it moves."""
        return len(self.places) > 1


def visitors(
    evidence: Evidence, around: StaticSurroundings, doubtful: Sequence[tuple[float, float]]
) -> list[Visitor]:
    """Return the things that scans show besides the world, the longest seen first."""
    tracks: list[_SeenObject] = []
    stride = max(1, len(evidence.scans) // MOST_SCANS)
    for scan in evidence.scans[::stride]:
        if any(begin - 0.1 <= scan.time_s <= end + 0.1 for begin, end in doubtful):
            continue
        lidar = evidence.lidar_pose(scan)
        points, rays = points_of(scan, lidar)
        if not len(points):
            continue
        points, distances = settled(around, points, lidar)
        blur = max(float(np.percentile(distances, BLUR_SHARE)) - BLUR_M, 0.0)
        if blur > MOST_BLUR_M:
            continue
        far = np.hypot(points[:, 0] - lidar.x, points[:, 1] - lidar.y) - EXACT_M
        new = distances > NEW_M + FAR_SHARE * np.maximum(far, 0.0) + BLURS * blur
        for cluster in _clusters(points[new], rays[new]):
            _follow(tracks, scan.time_s, cluster, (lidar.x, lidar.y))
    seen = [
        track
        for track in tracks
        if len(track.times) >= LEAST_SCANS and track.times[-1] - track.times[0] >= LEAST_SEEN_S
    ]
    seen.sort(key=lambda track: track.times[0] - track.times[-1])
    several = [_visitor(evidence, track) for track in seen[: 4 * MOST_OBSTACLES]]
    # A map of the same scans has what stood there all the time, so the rest is blur.
    plausible = [
        each
        for each in several
        if each is not None
        and not (around.is_mapped and not each.moves and _stays(evidence, each))
        and not _is_wall(around, each)
    ]
    return plausible[:MOST_OBSTACLES]


def settled(around: StaticSurroundings, points: Floats, lidar: Pose2D) -> tuple[Floats, Floats]:
    """Return the points of a scan where they fit the world best, with their distances from it, m.

    Where a localiser is wrong by a little, walls would else be things that came. Most points
    decide, so that a thing stays where it is. A scan that shows nothing new stays as it is.
    """
    best, distances = points, around.distances(points)
    shift = np.zeros(3)
    if (distances > NEW_M).sum() < LEAST_POINTS:
        return best, distances
    fit = float(np.percentile(distances, FIT_SHARE))
    for _ in range(FIT_ROUNDS):
        placed = _shifted(points, lidar, shift)
        now = around.distances(placed)
        near = now <= np.percentile(now, FIT_SHARE)
        slopes = np.column_stack(
            [
                (around.distances(_shifted(placed[near], lidar, step)) - now[near]) / FIT_STEP
                for step in FIT_STEP * np.eye(3)
            ]
        )
        shift = shift - np.linalg.lstsq(slopes, now[near], rcond=None)[0]
        if math.hypot(shift[0], shift[1]) > MOST_SHIFT_M or abs(shift[2]) > MOST_SHIFT_RAD:
            break
        placed = _shifted(points, lidar, shift)
        now = around.distances(placed)
        if float(np.percentile(now, FIT_SHARE)) < fit:
            best, distances, fit = placed, now, float(np.percentile(now, FIT_SHARE))
    return best, distances


def _shifted(points: Floats, lidar: Pose2D, shift: Floats) -> Floats:
    """Return points moved by m and turned around the lidar by rad."""
    x, y = points[:, 0] - lidar.x, points[:, 1] - lidar.y
    cos, sin = math.cos(shift[2]), math.sin(shift[2])
    return np.column_stack(
        (lidar.x + cos * x - sin * y + shift[0], lidar.y + sin * x + cos * y + shift[1])
    )


def _is_wall(around: StaticSurroundings, thing: Visitor) -> bool:
    """Return whether a thing is long and lies along the world: a wall, seen from a wrong pose."""
    distance = float(np.percentile(around.distances(thing.points), 80))
    return thing.radius is None and thing.size[0] > WALL_M and distance < ASKEW_M


def _stays(evidence: Evidence, thing: Visitor) -> bool:
    """Return whether the place of a thing is never seen empty."""
    place = np.array([thing.x, thing.y])
    end = evidence.end_s if thing.end is None else thing.end
    return thing.was_there or (
        _presence(evidence, place, evidence.first_s, thing.start) >= SEEN_THROUGH
        and _presence(evidence, place, end, evidence.end_s) >= SEEN_THROUGH
    )


def _clusters(points: Floats, rays: npt.NDArray[np.intp]) -> Iterator[Floats]:
    if len(points) < LEAST_POINTS:
        return
    jump = (np.hypot(*np.diff(points, axis=0).T) > CLUSTER_M) | (np.diff(rays) > 4)
    parts = np.split(np.arange(len(points)), np.flatnonzero(jump) + 1)
    closes = math.dist(points[0], points[-1]) < CLUSTER_M and len(parts) > 1
    if closes:
        parts = [np.concatenate((parts[-1], parts[0])), *parts[1:-1]]
    for part in parts:
        if len(part) >= LEAST_POINTS:
            yield points[part]


def _follow(
    tracks: list[_SeenObject], now: float, cluster: Floats, viewer: tuple[float, float]
) -> None:
    place = cluster.mean(axis=0)
    near = [
        (math.dist(track.places[-1], place), number)
        for number, track in enumerate(tracks)
        if now - track.times[-1] < 8.0 and track.times[-1] < now
    ]
    distance, number = min(near, default=(math.inf, -1))
    if distance > FOLLOWED_M:
        tracks.append(_SeenObject())
        number = len(tracks) - 1
    track = tracks[number]
    track.times.append(now)
    track.places.append((float(place[0]), float(place[1])))
    track.points.append(cluster)
    track.viewers.append(viewer)


def _visitor(evidence: Evidence, track: _SeenObject) -> Visitor | None:
    """Return the thing of a track; None if it is not there most of the time."""
    places = np.array(track.places)
    places = _smoothed(np.array(track.times), places)
    moves = _has_moved(evidence, track, places)
    if not moves and _presence(evidence, np.median(places, axis=0), *_span(track)) < 0.5:
        return None
    points = track.points[len(track.points) // 2] if moves else np.vstack(track.points)
    disc = fit_disc(points) if len(points) >= 6 else None
    viewer = np.mean(track.viewers, axis=0)
    if disc is not None:
        x, y, radius, size, yaw = disc.x, disc.y, disc.radius, (0.0, 0.0), 0.0
    else:
        x, y, size, yaw = _box(points, viewer)
        radius = None
    start, was_there = _appears(evidence, track, (x, y))
    stays = track.times[-1] >= evidence.end_s - 0.5
    end = None if stays else _vanishes(evidence, track, (x, y))
    route = (
        [
            (track.times[number], float(places[number, 0]), float(places[number, 1]))
            for number in range(0, len(track.times), max(1, len(track.times) // 12))
        ]
        if moves
        else [(start, x, y)]
    )
    return Visitor(start, end, x, y, radius, size, yaw, route, was_there, np.vstack(track.points))


def _span(track: _SeenObject) -> tuple[float, float]:
    return track.times[0], track.times[-1]


def _has_moved(evidence: Evidence, track: _SeenObject, places: Floats) -> bool:
    """Return whether its first place is empty at the end of a track, and its last one before.

    The middle of what is seen of a long thing moves with the robot, too.
    """
    if float(np.hypot(*(places.max(axis=0) - places.min(axis=0)))) <= MOVES_M:
        return False
    first, last = _span(track)
    early, late = first + (last - first) / 3, last - (last - first) / 3
    return (
        _presence(evidence, places[0], late, evidence.end_s) < SEEN_THROUGH
        and _presence(evidence, places[-1], evidence.first_s, early) < SEEN_THROUGH
    )


def _presence(evidence: Evidence, place: Floats, begin: float, end: float) -> float:
    """Return the share of scans between two times in which something is at a place; 1 of none."""
    there = through = 0
    for scan in evidence.scans:
        if begin <= scan.time_s <= end:
            past = _past(evidence, scan, (float(place[0]), float(place[1])))
            if past is not None:
                through += bool((past > THROUGH_M).sum() >= 2)
                there += bool((np.abs(past) <= THROUGH_M).any())
    return there / (there + through) if there + through else 1.0


def _smoothed(times: Floats, places: Floats) -> Floats:
    """Return the medians of places within half a second: single clusters jump."""
    return np.array(
        [np.median(places[np.abs(times - time) <= 0.5], axis=0) for time in times], np.float64
    )


def _box(points: Floats, viewer: Floats) -> tuple[float, float, tuple[float, float], float]:
    """Return the box of which points show one or two sides: a thin one reaches behind them."""
    (x, y), (length, width), angle = cv2.minAreaRect(points.astype(np.float32))
    if length < width:
        length, width, angle = width, length, angle + 90
    yaw = math.radians(angle)
    if width < THICKNESS_M:
        normal = np.array([-math.sin(yaw), math.cos(yaw)])
        away = 1.0 if normal @ (np.array([x, y]) - viewer) > 0 else -1.0
        depth = min(max(length, THICKNESS_M), 0.3)
        front = np.array([x, y]) - away * normal * width / 2
        x, y = front + away * normal * depth / 2
        width = depth
    return float(x), float(y), (max(float(length), 0.05), max(float(width), 0.05)), yaw


def _appears(
    evidence: Evidence, track: _SeenObject, place: tuple[float, float]
) -> tuple[float, bool]:
    """Return when a thing appears, and whether it may have been there from the start."""
    first = track.times[0]
    before = [scan for scan in evidence.scans if scan.time_s < first]
    for scan in reversed(before):
        if _sees_through(evidence, scan, place):
            return (scan.time_s + first) / 2, False
    return 0.0, True


def _vanishes(evidence: Evidence, track: _SeenObject, place: tuple[float, float]) -> float | None:
    """Return when a thing has gone; None if nobody looked there later."""
    last = track.times[-1]
    for scan in evidence.scans:
        if scan.time_s > last and _sees_through(evidence, scan, place):
            return (scan.time_s + last) / 2
    return None


def _sees_through(evidence: Evidence, scan: SeenScan, place: tuple[float, float]) -> bool:
    """Return whether rays pass a place to what is behind it."""
    past = _past(evidence, scan, place)
    return past is not None and bool((past > THROUGH_M).sum() >= 2)


def _past(evidence: Evidence, scan: SeenScan, place: tuple[float, float]) -> Floats | None:
    """Return how far three rays reach past a place, m; None out of range."""
    lidar = evidence.lidar_pose(scan)
    distance = math.dist(place, (lidar.x, lidar.y))
    bearing = math.atan2(place[1] - lidar.y, place[0] - lidar.x) - lidar.yaw - scan.angle_min
    number = round((bearing % math.tau) / abs(scan.increment)) if scan.increment else 0
    if number >= scan.ranges.size or distance > min(scan.range_max - 0.3, EXACT_M):
        return None
    near = scan.ranges[[number - 1, number, (number + 1) % scan.ranges.size]]
    past: Floats = near.astype(np.float64) - distance
    return past


def visitor_faults(seen: Sequence[Visitor]) -> Iterator[DiagnosedFault]:
    """Yield things that come as faults: they appear, move, and go."""
    for number, visitor in enumerate(seen, 1):
        name = f"thing {number}"
        at = (round(visitor.places[0][1], 3), round(visitor.places[0][2], 3))
        if not visitor.moves:
            at = (round(visitor.x, 3), round(visitor.y, 3))
        start = 0.05 if visitor.was_there else visitor.start
        lasting = None if visitor.end is None else visitor.end - start
        if visitor.radius is not None:
            kind = "spawn_cylinder"
            shape: dict[str, Any] = {"radius": round(visitor.radius, 3), "height": HEIGHT}
        else:
            kind = "spawn_box"
            shape = {"size": (*(round(edge, 3) for edge in visitor.size), HEIGHT)}
        turned = {} if kind == "spawn_cylinder" else {"yaw": round(math.degrees(visitor.yaw), 1)}
        fault = fault_at(
            start, kind, at=at, name=name, nearest_free=True, lasting=lasting, **shape, **turned
        )
        yield DiagnosedFault(
            fault,
            f"scans show a thing at ({at[0]:.2f}, {at[1]:.2f}) m that is not in the world",
            0.85,
            round(start, 2),
            None if visitor.end is None else round(visitor.end, 2),
            is_needed=False,
        )
        yield from _moves(name, visitor)


def _moves(name: str, visitor: Visitor) -> Iterator[DiagnosedFault]:
    legs = list(zip(visitor.places, visitor.places[1:], strict=False))
    for (t0, x0, y0), (t1, x1, y1) in legs:
        way = math.dist((x0, y0), (x1, y1))
        if way < 0.05 or t1 <= t0:
            continue
        speed = round(min(max(way / (t1 - t0), 0.02), 2.0), 3)
        fault = fault_at(
            t0, "move_box", name, at=(round(x1, 3), round(y1, 3)), speed=speed, nearest_free=True
        )
        yield DiagnosedFault(
            fault, f"it moves at {speed:g} m/s", 0.7, round(t0, 2), round(t1, 2), is_needed=False
        )
