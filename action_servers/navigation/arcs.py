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
from bisect import bisect_left, bisect_right
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import groupby
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from action_servers.core.clearance import HULL_M, Footprint
from action_servers.core.grid import Floats, Survey
from action_servers.navigation.path import SPACING_M, CostModel, Path, path_through
from action_servers.navigation.planner import PRICE_UNIT_M, RoadMap, road_map
from action_servers.navigation.reeds_shepp import Pieces, curves
from bt_mission.base.geometry import Pose2D

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

    def yaw_at(self, distance: float) -> float:
        """Return the yaw `distance` metres along the stroke, rad."""
        travelled, yaws, _ = self._lists
        index = min(max(1, bisect_right(travelled, distance)), len(travelled) - 1)
        before, after = travelled[index - 1], travelled[index]
        share = min(max(0.0, (distance - before) / (after - before)), 1.0)
        return yaws[index - 1] + share * (yaws[index] - yaws[index - 1])

    def bend_at(self, distance: float) -> float:
        """Return the curvature at the first point from `distance` metres on, 1/m."""
        travelled, _, bends = self._lists
        return bends[min(bisect_left(travelled, distance), len(bends) - 1)]

    @cached_property
    def _lists(self) -> tuple[list[float], list[float], list[float]]:
        """As lists: single numbers of an array take ten times as long to read."""
        return self.path.travelled.tolist(), self.yaws.tolist(), self.bends.tolist()


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
        self._each = [(spot.real, spot.imag) for spot in self.places.tolist()]
        self._middle = 0.5 * (body.front + body.rear)
        self._reach = float(np.abs(self.places - self._middle).max())

    def room(self, poses: Floats, survey: Survey) -> Floats:
        """Return the distance from the hull to the nearest obstacle at `n x 3` poses, m."""
        x, y, yaw = poses.T[:, :, None]
        spots = x + 1j * y + np.exp(1j * yaw) * self.places
        clearance = survey.clearance_at(spots.view(np.float64).reshape(-1, 2))
        rooms: Floats = clearance.reshape(spots.shape).min(axis=1) - self.radius
        return rooms

    def room_at(self, pose: Pose2D, survey: Survey, enough: float) -> float:
        """Return the distance from the hull to the nearest obstacle at one pose, at most `enough`.

        Metres. Where the middle of the hull is far from everything, its discs are not looked at.
        """
        x, y, cosine, sine = pose.x, pose.y, math.cos(pose.yaw), math.sin(pose.yaw)
        clearance, middle = survey.clearance_of, self._middle
        needed = enough + self.radius
        # Interpolation may add a node's distance to each of the two places.
        far = needed + self._reach + 2 * survey.resolution
        if clearance(x + cosine * middle, y + sine * middle) >= far:
            return enough
        nearest = [
            clearance(x + cosine * ahead - sine * left, y + sine * ahead + cosine * left)
            for ahead, left in self._each
        ]
        return min(needed, *nearest) - self.radius


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

    `roads` are those of the planner. The comfort of their cost counts here beyond the hull, around
    which the way keeps `kept` metres, or the room of its ends if that is less.
    """

    def __init__(
        self,
        roads: RoadMap,
        body: Footprint,
        sharpest: float,
        ends: tuple[Pose2D, Pose2D],
        kept: float = KEPT_M,
    ) -> None:
        self._kept = kept
        self._most = MOST_PLACES if kept <= KEPT_M else MOST_PLACES // 3
        self._start, self._goal = ends
        self._survey = survey = roads.survey
        self._discs = HullDiscs(body)
        self._curvature = CURVATURE_SHARE * sharpest
        self._comfort = kept + roads.cost.comfort - roads.cost.radius
        self.way: ArcWay | None = None
        self.is_over = False
        self._places = 0
        self._count = 0
        self._first_at = self._cheapest = math.inf
        self._closed: dict[_Key, float] = {}
        self._make_moves()
        self._left = self._prices_to_goal(roads, body)
        poses = np.array([(end.x, end.y, end.yaw) for end in ends])
        start_room, goal_room = self._discs.room(poses, survey)
        self._needed_at_goal = min(self._kept, goal_room - 1e-3)
        self._open: list[tuple[float, int, _Place | _End]] = []
        if goal_room > 0.0 and start_room > 0.0:
            first = _Place(self._start.x, self._start.y, 0, 0.0, float(start_room), None, -1)
            self._push(self._left_at(first.x, first.y), first)

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
            direction = _MOVES[place.move][1] if place.move >= 0 else 0
            key = _key(place.x, place.y, place.heading, direction)
            if self._closed.get(key, math.inf) <= place.price:
                continue
            self._closed[key] = place.price
            self._places += 1
            self._look_from(place)

    def _look_from(self, place: _Place) -> None:
        left = self._left_at(place.x, place.y)
        if place.before is None or self._places % max(_LEAST_SKIPPED, int(left / 0.3)) == 0:
            self._try_curves(place)
        rooms = self._rooms(place)
        moved_by = self._moved[place.heading]
        least = min(self._kept, place.room - 1e-3)
        turned_before, direction_before = _MOVES[place.move] if place.move >= 0 else (0, 0)
        for move, (bend, direction) in enumerate(_MOVES):
            room = rooms[move]
            if room < least or room < 0.0:
                continue
            step = self._step_m if direction > 0 else self._step_back_m
            price = place.price + self._price(room) * step
            if direction_before:
                if direction != direction_before:
                    price += _CUSP_M
                if bend != turned_before:
                    price += _BEND_M
            x, y = place.x + moved_by[move].real, place.y + moved_by[move].imag
            heading = (place.heading + bend * direction) % _HEADINGS
            if self._closed.get(_key(x, y, heading, direction), math.inf) > price:
                guess = price + self._left_at(x, y)
                if guess < _GOOD_ENOUGH * self._cheapest:
                    self._push(guess, _Place(x, y, heading, price, room, place, move))

    def _try_curves(self, place: _Place) -> None:
        start = self._pose(place)
        tried = [
            pieces
            for pieces in curves(start, self._goal, self._curvature)[:_TRIED]
            # In the open it would cost least.
            if place.price + self._curve_price(place, pieces, 1.0) < self._cheapest
        ]
        if not tried:
            return
        parts = [_parts(start, pieces, self._curvature) for pieces in tried]
        poses, _ = _driven([part for each in parts for part in each])
        rooms = self._discs.room(poses, self._survey)
        near_goal = np.hypot(poses[:, 0] - self._goal.x, poses[:, 1] - self._goal.y) < 0.5
        needed = np.where(near_goal, self._needed_at_goal, min(self._kept, place.room - 1e-3))
        is_tight, prices = rooms < np.maximum(needed, 0.0), self._prices(rooms)
        end = 0
        for pieces, each in zip(tried, parts, strict=True):
            begin, end = end, end + sum(len(part.shares) for part in each)
            if is_tight[begin:end].any():
                continue
            self._first_at = min(self._first_at, self._places)
            level = float(prices[begin:end].mean())
            price = place.price + self._curve_price(place, pieces, level)
            if price < self._cheapest:
                self._cheapest = price
                self._push(_GOOD_ENOUGH * price, _End(place, pieces))

    def _curve_price(self, place: _Place, pieces: Pieces, level: float) -> float:
        """Return the price of a curve whose metre ahead costs `level` in the mean."""
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

    def _pose(self, place: _Place) -> Pose2D:
        return Pose2D(place.x, place.y, self._start.yaw + place.heading * _TURN_RAD)

    def _price(self, room: float) -> float:
        lack = min(1.0, max(0.0, (self._comfort - room) / (self._comfort - self._kept)))
        return 1.0 + _DISLIKE * lack * lack

    def _prices(self, rooms: Floats) -> Floats:
        """Return the price of a metre ahead in each room."""
        lack = np.clip((self._comfort - rooms) / (self._comfort - self._kept), 0.0, 1.0)
        prices: Floats = 1.0 + _DISLIKE * lack * lack
        return prices

    def _left_at(self, x: float, y: float) -> float:
        """Return the guess of the price from a place to the goal."""
        survey, left = self._survey, self._left
        row = math.floor((y - survey.origin_y) / survey.resolution)
        column = math.floor((x - survey.origin_x) / survey.resolution)
        rows, columns = left.shape
        if not (0 <= row < rows and 0 <= column < columns):
            return math.inf
        return left.item(row, column)

    def _prices_to_goal(self, roads: RoadMap, body: Footprint) -> Floats:
        """Return for each cell the price to the goal of a disc as wide as the car; inf for none.

        The planner's roads serve where they keep as much, within half a cell.
        """
        radius = body.half_width + self._kept
        if radius < roads.cost.radius - 0.5 * self._survey.resolution:
            narrow = CostModel(radius, radius + self._comfort - self._kept, roads.cost.margin)
            roads = road_map(self._survey, narrow)
        left = np.full(self._survey.shape, np.inf)
        near = roads.free_near((self._goal.x, self._goal.y), 0.3)
        if near:
            prices = roads.prices_to(near[0])[0] * PRICE_UNIT_M
            left[roads.node >= 0] = prices[roads.node[roads.node >= 0]]
        return left

    def _make_moves(self) -> None:
        """Compute where the discs of the hull are on each move from each heading."""
        self._step_m = _TURN_RAD / self._curvature
        self._step_back_m = _BACK * self._step_m
        parts = np.arange(1, _SAMPLES + 1) / _SAMPLES * self._step_m
        spots, ends = [], []
        for bend, direction in _MOVES:
            turned = bend * direction * parts * self._curvature
            if bend:
                radius = bend / self._curvature
                along = radius * np.sin(turned) + 1j * radius * (1.0 - np.cos(turned))
            else:
                along = direction * parts + 0j
            discs = along[:, None] + np.exp(1j * turned)[:, None] * self._discs.places
            spots.append(discs.ravel())
            ends.append(along[-1])
        facing = np.exp(1j * (self._start.yaw + np.arange(_HEADINGS) * _TURN_RAD))
        moves = facing[:, None, None] * np.array(spots)
        self._moved: list[list[complex]] = (facing[:, None] * np.array(ends)).tolist()
        survey = self._survey
        self._half_m = 0.5 * survey.resolution
        self._moves: Floats = np.stack((moves.imag, moves.real), axis=1) / self._half_m
        around = np.pad(survey.clearance, 1)  # beyond the grid is no room
        self._around, self._columns = around.ravel(), around.shape[1]
        self._last_node = np.array(around.shape)[:, None, None] - 1.0

    def _rooms(self, place: _Place) -> list[float]:
        """Return the room around the hull on each move, from the nearest nodes of the lattice."""
        survey, half_m = self._survey, self._half_m
        row = (place.y - survey.origin_y) / half_m + 1
        column = (place.x - survey.origin_x) / half_m + 1
        places = self._moves[place.heading] + np.array((row, column))[:, None, None]
        np.rint(places, out=places)
        np.clip(places, 0.0, self._last_node, out=places)
        nodes = (places[0] * self._columns + places[1]).astype(np.intp)
        rooms: list[float] = (self._around[nodes].min(axis=1) - self._discs.radius).tolist()
        return rooms


def _key(x: float, y: float, heading: int, direction: int) -> _Key:
    return math.floor(x / _CELL_M), math.floor(y / _CELL_M), heading, direction


_MOVES = ((0, 1), (1, 1), (-1, 1), (0, -1), (1, -1), (-1, -1))
"""Side of the arc, and direction."""


class _Part(NamedTuple):
    """A piece of a curve from a pose on, and which shares of its length its points are at."""

    x: float
    y: float
    yaw: float
    bend: float
    length: float
    shares: Floats


def _parts(start: Pose2D, pieces: Pieces, curvature: float) -> list[_Part]:
    """Return the pieces of a curve with their beginnings; of none, the start alone."""
    x, y, yaw = start.x, start.y, start.yaw
    parts = []
    for side, length in pieces or ((0, 0.0),):
        bend, half = side * curvature, side * curvature * length / 2
        shares = _shares(max(1, math.ceil(abs(length) / SPACING_M)))
        parts.append(_Part(x, y, yaw, bend, length, shares))
        chord = 2.0 * math.sin(half) / bend if side else length
        x, y = x + chord * math.cos(yaw + half), y + chord * math.sin(yaw + half)
        yaw += 2 * half
    return parts


@lru_cache(maxsize=256)
def _shares(count: int) -> Floats:
    return np.linspace(0.0, 1.0, count + 1)


def _driven(parts: list[_Part]) -> tuple[Floats, Floats]:
    """Return the poses along pieces, `n x 3`, and the curvature at each."""
    counts = [len(part.shares) for part in parts]
    rows = np.repeat(np.array([part[:5] for part in parts]), counts, axis=0)
    x, y, yaw, bends, lengths = rows.T
    along = np.concatenate([part.shares for part in parts]) * lengths
    half_turns = 0.5 * bends * along
    chords, middles = along * np.sinc(half_turns / math.pi), yaw + half_turns
    poses = np.empty((len(along), 3))
    poses[:, 0], poses[:, 1] = x + chords * np.cos(middles), y + chords * np.sin(middles)
    poses[:, 2] = yaw + 2 * half_turns
    return poses, bends


def _way(start: Pose2D, pieces: Pieces, curvature: float) -> ArcWay:
    strokes = []
    at = start
    for is_ahead, group in groupby(pieces, lambda piece: piece[1] > 0.0):
        poses, bends = _driven(_parts(at, tuple(group), curvature))
        new = np.concatenate(([True], np.hypot(*np.diff(poses[:, :2], axis=0).T) > 1e-6))
        poses, bends = poses[new], bends[new]
        at = Pose2D(*poses[-1].tolist())
        if len(poses) > 1:
            path = path_through(poses[:, :2])
            strokes.append(Stroke(path, poses[:, 2], bends, 1 if is_ahead else -1))
    return ArcWay(tuple(strokes))
