"""The way of a car to a pose: a search over arcs ahead and back with its hull (hybrid A*).

D. Dolgov, S. Thrun, M. Montemerlo and J. Diebel, "Practical search techniques in path planning for
autonomous driving" (2008): places are exact, and of all that end in one cell with one heading, the
cheapest is kept. The guess of the rest is the distance around obstacles of a base that turns on
the spot. From some places a curve to the goal without regard to obstacles is tried
(:mod:`reeds_shepp`).
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass, field
from functools import cached_property
from itertools import groupby
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from scipy.sparse import csgraph

from action_servers.core.footprint import Footprint
from action_servers.core.grid import Floats, Survey
from action_servers.core.margins import HULL_M
from action_servers.navigation.path import SPACING_M, CostModel, Path, path_through
from action_servers.navigation.planner import PRICE_UNIT_M, RoadMap, road_map
from action_servers.navigation.reeds_shepp import Pieces, curves
from bt_mission.core.geometry import Pose2D

CURVATURE_SHARE = 0.9
"""Of the sharpest arc: the rest is for what the car strays from its way."""

KEPT_M = HULL_M + 0.04
"""Around the hull, m: what the governor keeps, and as much as the follower strays."""

MARGINS_M = (0.1, KEPT_M)
"""What is kept around the hull, m: where no way keeps the first, it may keep the second."""

_HEADINGS = 36
_TURN_RAD = math.tau / _HEADINGS
_CELL_M = 0.08
_SAMPLES = 3
_BACK = 1.5
_CUSP_M = 0.4
_BEND_M = 0.05
_DISCS = 1.5
_DISLIKE = 10.0
_TRIED = 4
_LEAST_SKIPPED = 4
_AFTER_FIRST = 300
_GOOD_ENOUGH = 0.9
"""No other way costs less than this share of the one that is taken."""
MOST_PLACES = 4_000
"""Places from which the search looks further, before it ends without a way; a third of them where
more than `KEPT_M` is kept."""

_Key: TypeAlias = tuple[int, int, int, int]
Spots: TypeAlias = npt.NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Stroke:
    """A part of the way in one direction; `yaws` (not wrapped) and `bends` (1/m) for each point."""

    path: Path
    yaws: Floats
    bends: Floats
    direction: int


@dataclass(frozen=True, eq=False)
class ArcWay:
    """Strokes, each of which begins where the last one ends."""

    strokes: tuple[Stroke, ...]

    @cached_property
    def length(self) -> float:
        """Length in metres."""
        return sum(stroke.path.length for stroke in self.strokes)

    @cached_property
    def poses(self) -> Floats:
        """All points with their yaw, `n x 3`."""
        return np.concatenate(
            [np.column_stack((stroke.path.points, stroke.yaws)) for stroke in self.strokes]
        )

    @cached_property
    def travelled(self) -> Floats:
        """The length up to each of the poses, m."""
        lengths = [stroke.path.length for stroke in self.strokes]
        before = np.cumsum([0.0, *lengths[:-1]])
        return np.concatenate(
            [
                start + stroke.path.travelled
                for start, stroke in zip(before, self.strokes, strict=True)
            ]
        )


class HullDiscs:
    """The hull as two rows of discs, which cover it."""

    def __init__(self, body: Footprint) -> None:
        length = body.front - body.rear
        count = max(1, math.ceil(_DISCS * length / body.half_width))
        half, aside = length / (2 * count), body.half_width / 2.0
        along = body.rear + half * (1 + 2 * np.arange(count))
        self.radius = math.hypot(half, aside)
        self.places: Spots = np.concatenate((along + 1j * aside, along - 1j * aside))
        """From the base's origin, m: ahead as the real part, left as the imaginary one."""

    def room(self, poses: Floats, survey: Survey) -> Floats:
        """Return the distance from the hull to the nearest obstacle at `n x 3` poses, m."""
        x, y, yaw = poses.T[:, :, None]
        spots = x + 1j * y + np.exp(1j * yaw) * self.places
        clearance = survey.clearance_at(np.column_stack((spots.real.ravel(), spots.imag.ravel())))
        rooms: Floats = clearance.reshape(spots.shape).min(axis=1) - self.radius
        return rooms


@dataclass(slots=True)
class _Place:
    x: float
    y: float
    heading: int
    price: float
    room: float
    before: _Place | None
    move: int


@dataclass(slots=True)
class _End:
    """A curve from a place to the goal."""

    place: _Place
    pieces: Pieces = field(default=())


class ArcSearch:
    """A search that is done in parts: :meth:`advance` until it `is_over`; then `way` is the result.

    `cost` is that of the planner: its comfort counts here beyond the hull, around which the way
    keeps `kept` metres, or the room of its ends if that is less.
    """

    def __init__(
        self,
        survey: Survey,
        body: Footprint,
        sharpest: float,
        ends: tuple[Pose2D, Pose2D],
        cost: CostModel,
        kept: float = KEPT_M,
    ) -> None:
        self._kept = kept
        self._most = MOST_PLACES if kept <= KEPT_M else MOST_PLACES // 3
        self._start, self._goal = ends
        self._survey = survey
        self._discs = HullDiscs(body)
        self._curvature = CURVATURE_SHARE * sharpest
        self._comfort = kept + cost.comfort - cost.radius
        self.way: ArcWay | None = None
        self.is_over = False
        self._places = 0
        self._count = 0
        self._first_at = self._cheapest = math.inf
        self._closed: dict[_Key, float] = {}
        self._make_moves()
        self._left = self._prices_to_goal(cost, body)
        poses = np.array([(end.x, end.y, end.yaw) for end in ends])
        start_room, goal_room = self._discs.room(poses, survey)
        self._needed_at_goal = min(self._kept, goal_room - 1e-3)
        self._open: list[tuple[float, int, _Place | _End]] = []
        if goal_room > 0.0 and start_room > 0.0:
            first = _Place(self._start.x, self._start.y, 0, 0.0, float(start_room), None, -1)
            self._push(self._guess(first), first)

    def advance(self, places: int) -> None:
        """Look from at most `places` more places."""
        for _ in range(places):
            if self.is_over:
                return
            if not self._open or self._places > min(self._most, self._first_at + _AFTER_FIRST):
                self._end(self._best_end())
                return
            _, _, place = heapq.heappop(self._open)
            if isinstance(place, _End):
                self._end(place)
                return
            key = self._key(place)
            if self._closed.get(key, math.inf) <= place.price:
                continue
            self._closed[key] = place.price
            self._places += 1
            self._look_from(place)

    def _look_from(self, place: _Place) -> None:
        left = self._guess(place) - place.price
        if place.before is None or self._places % max(_LEAST_SKIPPED, int(left / 0.3)) == 0:
            self._try_curves(place)
        spots = self._moves[place.heading] + complex(place.x, place.y)
        rooms = self._rooms(spots)
        for move, room in enumerate(rooms.tolist()):
            if room < self._kept and room < place.room - 1e-3:
                continue
            if room < 0.0:
                continue
            bend, direction = _MOVES[move]
            moved = self._moved[place.heading][move]
            price = place.price + self._price(room) * self._step_m * (
                1.0 if direction > 0 else _BACK
            )
            if place.move >= 0:
                bend_before, direction_before = _MOVES[place.move]
                if direction != direction_before:
                    price += _CUSP_M
                if bend != bend_before:
                    price += _BEND_M
            heading = (place.heading + bend * direction) % _HEADINGS
            new = _Place(
                place.x + moved.real, place.y + moved.imag, heading, price, room, place, move
            )
            if self._closed.get(self._key(new), math.inf) > price:
                guess = self._guess(new)
                if guess < _GOOD_ENOUGH * self._cheapest:
                    self._push(guess, new)

    def _try_curves(self, place: _Place) -> None:
        start = self._pose(place)
        for pieces in curves(start, self._goal, self._curvature)[:_TRIED]:
            if place.price + sum(abs(length) for _, length in pieces) >= self._cheapest:
                return
            poses = _driven(start, pieces, self._curvature)[0]
            rooms = self._discs.room(poses, self._survey)
            near_goal = np.hypot(poses[:, 0] - self._goal.x, poses[:, 1] - self._goal.y) < 0.5
            needed = np.where(near_goal, self._needed_at_goal, min(self._kept, place.room - 1e-3))
            if (rooms < needed).any() or (rooms < 0.0).any():
                continue
            self._first_at = min(self._first_at, self._places)
            price = place.price + self._curve_price(place, pieces, rooms)
            if price < self._cheapest:
                self._cheapest = price
                self._push(_GOOD_ENOUGH * price, _End(place, pieces))

    def _curve_price(self, place: _Place, pieces: Pieces, rooms: Floats) -> float:
        level = float(np.mean([self._price(room) for room in rooms.tolist()] or [1.0]))
        direction = 0 if place.move < 0 else _MOVES[place.move][1]
        price = 0.0
        for _, length in pieces:
            sign = 1 if length > 0.0 else -1
            price += abs(length) * level * (1.0 if sign > 0 else _BACK) + _BEND_M
            price += _CUSP_M if sign == -direction else 0.0
            direction = sign
        return price

    def _push(self, guess: float, place: _Place | _End) -> None:
        self._count += 1
        heapq.heappush(self._open, (guess, self._count, place))

    def _best_end(self) -> _End | None:
        ends = [row for row in self._open if isinstance(row[2], _End)]
        if not ends:
            return None
        end = min(ends)[2]
        assert isinstance(end, _End)
        return end

    def _end(self, end: _End | None) -> None:
        self.is_over = True
        if end is None:
            return
        pieces: list[tuple[int, float]] = []
        place: _Place | None = end.place
        while place is not None and place.before is not None:
            bend, direction = _MOVES[place.move]
            pieces.append((bend, direction * self._step_m))
            place = place.before
        self.way = _way(self._start, (*reversed(pieces), *end.pieces), self._curvature)

    def _key(self, place: _Place) -> _Key:
        direction = 0 if place.move < 0 else _MOVES[place.move][1]
        return (
            math.floor(place.x / _CELL_M),
            math.floor(place.y / _CELL_M),
            place.heading,
            direction,
        )

    def _pose(self, place: _Place) -> Pose2D:
        return Pose2D(place.x, place.y, self._start.yaw + place.heading * _TURN_RAD)

    def _price(self, room: float) -> float:
        lack = min(1.0, max(0.0, (self._comfort - room) / (self._comfort - self._kept)))
        return 1.0 + _DISLIKE * lack * lack

    def _guess(self, place: _Place) -> float:
        row, column = self._survey.cell(place.x, place.y)
        rows, columns = self._left.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return math.inf
        return place.price + float(self._left[row, column])

    def _prices_to_goal(self, cost: CostModel, body: Footprint) -> Floats:
        """Return for each cell the price to the goal of a disc as wide as the car; inf for none."""
        radius = body.half_width + self._kept
        narrow = CostModel(radius, radius + self._comfort - self._kept, cost.margin)
        roads: RoadMap = road_map(self._survey, narrow)
        left = np.full(self._survey.shape, np.inf)
        near = roads.free_near((self._goal.x, self._goal.y), 0.3)
        if near:
            prices = csgraph.dijkstra(roads.edges, indices=near[0]) * PRICE_UNIT_M
            left[roads.node >= 0] = prices[roads.node[roads.node >= 0]]
        return left

    def _make_moves(self) -> None:
        """Compute where the discs of the hull are on each move from each heading."""
        self._step_m = _TURN_RAD / self._curvature
        parts = np.arange(1, _SAMPLES + 1) / _SAMPLES * self._step_m
        shape = _HEADINGS, len(_MOVES), _SAMPLES * len(self._discs.places)
        self._moves = np.empty(shape, complex)
        self._moved = np.empty((_HEADINGS, len(_MOVES)), complex)
        for index, (bend, direction) in enumerate(_MOVES):
            turned = bend * direction * parts * self._curvature
            if bend:
                radius = bend / self._curvature
                along = radius * np.sin(turned) + 1j * radius * (1.0 - np.cos(turned))
            else:
                along = direction * parts + 0j
            discs = along[:, None] + np.exp(1j * turned)[:, None] * self._discs.places
            for heading in range(_HEADINGS):
                facing = np.exp(1j * (self._start.yaw + heading * _TURN_RAD))
                self._moves[heading, index] = (facing * discs).ravel()
                self._moved[heading, index] = facing * along[-1]

    def _rooms(self, spots: Spots) -> Floats:
        """Return the room around the hull on each move, from the nearest nodes of the lattice."""
        survey = self._survey
        half = 0.5 * survey.resolution
        rows, columns = survey.clearance.shape
        column = np.rint((spots.real - survey.origin_x) / half).astype(np.intp)
        row = np.rint((spots.imag - survey.origin_y) / half).astype(np.intp)
        inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
        known = survey.clearance[np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)]
        rooms: Floats = np.where(inside, known, 0.0).min(axis=1) - self._discs.radius
        return rooms


_MOVES = ((0, 1), (1, 1), (-1, 1), (0, -1), (1, -1), (-1, -1))
"""Side of the arc, and direction."""


def _driven(start: Pose2D, pieces: Pieces, curvature: float) -> tuple[Floats, Floats, Floats]:
    """Return the poses along pieces, `n x 3`, and at each the curvature and the direction."""
    x, y, yaw = start.x, start.y, start.yaw
    parts, bends, signs = [], [], []
    for side, length in pieces:
        count = max(1, math.ceil(abs(length) / SPACING_M))
        along = np.linspace(0.0, length, count + 1)
        bend = side * curvature
        yaws = yaw + bend * along
        if side:
            xs = x + (np.sin(yaws) - math.sin(yaw)) / bend
            ys = y - (np.cos(yaws) - math.cos(yaw)) / bend
        else:
            xs, ys = x + along * math.cos(yaw), y + along * math.sin(yaw)
        parts.append(np.column_stack((xs, ys, yaws)))
        bends.append(np.full(count + 1, bend))
        signs.append(np.full(count + 1, 1.0 if length > 0.0 else -1.0))
        x, y, yaw = float(xs[-1]), float(ys[-1]), float(yaws[-1])
    if not parts:
        return np.array([(x, y, yaw)]), np.zeros(1), np.ones(1)
    return np.concatenate(parts), np.concatenate(bends), np.concatenate(signs)


def _way(start: Pose2D, pieces: Pieces, curvature: float) -> ArcWay:
    strokes = []
    at = start
    for is_ahead, group in groupby(pieces, lambda piece: piece[1] > 0.0):
        poses, bends, _ = _driven(at, tuple(group), curvature)
        new = np.concatenate(([True], np.hypot(*np.diff(poses[:, :2], axis=0).T) > 1e-6))
        poses, bends = poses[new], bends[new]
        at = Pose2D(*poses[-1].tolist())
        if len(poses) > 1:
            path = path_through(poses[:, :2])
            strokes.append(Stroke(path, poses[:, 2], bends, 1 if is_ahead else -1))
    return ArcWay(tuple(strokes))
