"""Props: obstacles that appear, move and vanish while the simulation runs.

    box = simulation.props.place("box", 1.0, 0.0, size=(0.2, 0.2, 0.3))
    box.move_to(1.0, 2.0, speed=0.5)
    box.remove()

They are not on any map. The lidar and the camera see them at once, and a robot that touches one has
a collision with its name. Moving props are not stopped: they push robots at their own speed
(`sim.physics.physics.Movers`), and pass through walls and other obstacles.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Protocol

import mujoco

from bt_mission.base.diagnostics import listed
from sim.physics.clearance import Gauge, touching
from sim.physics.names import BASE
from sim.physics.prop_bodies import MOST, PropBodies, PropError, shape
from sim.physics.simulator import FollowedSimulator
from sim.world.motion import Course, Drifting, PassingCourse, Point
from sim.world.shapes import Obstacle
from sim.world.world import FASTEST, World

RING = 0.05
"""Metres between the rings of places that are tried in search of a free one."""

_TOUCHING = 1e-6
"""Metres of penetration from which two bodies touch; bodies side by side do not."""


class PropPhysics(Protocol):
    """The physics that props are part of, as far as they need it."""

    model: mujoco.MjModel
    data: mujoco.MjData
    world: World
    time_ns: int
    names: list[str]
    robot_names: tuple[str, ...]
    prefixes: tuple[str, ...]
    obstacle_geoms: tuple[int, ...]

    @property
    def simulator(self) -> FollowedSimulator | None:
        """The simulator that moves the robot in place of MuJoCo, if any."""


@dataclass(frozen=True, slots=True)
class _Slot:
    q: int
    v: int
    geom: int


class Prop:
    """One prop in the world, from when it was placed until it is removed.

    Each motion starts at its place and replaces the one before. Metres, m/s; at most 2 m/s. Raises
    PropError for an impossible motion, and after it has been removed.
    """

    def __init__(self, props: Props, index: int, obstacle: Obstacle) -> None:
        self._props = props
        self._index = index
        self.obstacle = obstacle
        """Its shape, name and direction, and where it was placed."""
        self.course: Course = _standing(obstacle)
        """Where it is, as a function of the time since `since_ns`."""
        self.since_ns = props.time_ns

    def __repr__(self) -> str:
        return f"<{self.obstacle.kind} '{self.name}'>"

    @property
    def name(self) -> str:
        """The name of the prop in collisions."""
        return self.obstacle.name

    @property
    def is_placed(self) -> bool:
        """Whether it is in the world."""
        return self._props.holds(self, self._index)

    @property
    def position(self) -> Point:
        """Where its centre is now, or was when it was removed."""
        return self._now()[:2]

    @property
    def velocity(self) -> Point:
        """Its present velocity along x and y."""
        return self._now()[2:]

    def move_to(self, x: float, y: float, speed: float) -> None:
        """Move straight to a place, and stand."""
        self.follow([(x, y)], speed)

    def follow(self, points: Sequence[Point], speed: float) -> None:
        """Move straight from point to point, and stand at the last."""
        points = [self.position, *points]
        for x, y in points[1:]:
            self._props.check_floor(self.name, x, y)
        if not 0 < speed <= FASTEST:
            raise PropError(
                f"prop '{self.name}': expected a speed above 0 m/s and up to {FASTEST:g} m/s,"
                f" got {speed:g} m/s"
            )
        # Standing at a point for no time is to pass it.
        way = [points[0], *(b for a, b in pairwise(points) if math.dist(a, b) > 0)]
        self._go(PassingCourse(tuple(way), speed) if len(way) > 1 else Drifting(way[0]))

    def move_at(self, vx: float, vy: float) -> None:
        """Move at this velocity, along x and y of the map, until the next call."""
        if not math.hypot(vx, vy) <= FASTEST:
            raise PropError(
                f"prop '{self.name}': expected a velocity of at most {FASTEST:g} m/s,"
                f" got ({vx:g}, {vy:g}) m/s"
            )
        self._go(Drifting(self.position, (vx, vy)))

    def stop(self) -> None:
        """Stand at the present place."""
        self.move_at(0.0, 0.0)

    def remove(self) -> None:
        """Remove it. It may already be gone, e.g. by a reset."""
        if self.is_placed:
            self._props.remove(self._index)

    def begin_anew(self) -> None:
        """Return to the place where it was put."""
        self.course, self.since_ns = _standing(self.obstacle), self._props.time_ns

    def _go(self, course: Course) -> None:
        if not self.is_placed:
            raise PropError(f"prop '{self.name}' is not in the world any more; place a new one")
        self.course, self.since_ns = course, self._props.time_ns

    def _now(self) -> tuple[float, float, float, float]:
        return self.course.at((self._props.time_ns - self.since_ns) / 1e9)


def _no_room(obstacle: Obstacle, touched: str, hint: str = "") -> PropError:
    x, y, yaw_deg = obstacle.x, obstacle.y, math.degrees(obstacle.yaw)
    return PropError(
        f"prop '{obstacle.name}' does not fit at ({x:g}, {y:g}, {yaw_deg:g} deg): it would be in"
        f" {'the robot' if touched == BASE else f'{touched!r}'}; place it elsewhere{hint}"
    )


def _standing(obstacle: Obstacle) -> Course:
    return Drifting((obstacle.x, obstacle.y))


class Props:
    """The props of one simulation: at most `count` at one time."""

    def __init__(self, physics: PropPhysics, bodies: PropBodies) -> None:
        self._physics = physics
        self._bodies = bodies
        self._slots = [
            _Slot(*addresses, geom)
            for addresses, geom in zip(bodies.addresses, bodies.geoms, strict=True)
        ]
        self.placed: dict[int, Prop] = {}
        """Those in the world, by their spare bodies, in the order in which they were placed."""
        self.shown: tuple[Obstacle | None, ...] = tuple(bodies.shown)
        """The present obstacle of every spare body."""

    def __len__(self) -> int:
        return len(self.placed)

    def __iter__(self) -> Iterator[Prop]:
        """Those in the world, in the order in which they were placed."""
        return iter(tuple(self.placed.values()))

    def __getitem__(self, name: str) -> Prop:
        """Return the prop of that name in the world. Raises KeyError."""
        return {prop.name: prop for prop in self}[name]

    @property
    def count(self) -> int:
        """The number of props that there can be at one time."""
        return len(self._slots)

    @property
    def time_ns(self) -> int:
        """The present instant, ns."""
        return self._physics.time_ns

    def place(  # noqa: PLR0913 - keywords, and a box or a cylinder
        self,
        name: str,
        x: float,
        y: float,
        yaw_deg: float = 0.0,
        *,
        size: tuple[float, float, float] | None = None,
        radius: float | None = None,
        height: float = 0.5,
        colour: str = "orange",
        even_into_the_robot: bool = False,
        nearest_free: bool = False,
    ) -> Prop:
        """Put a box of this size (along its own x, y, z), or a cylinder, on the floor; metres.

        Raises PropError if all props are in the world already, for a name that is taken, an invalid
        size, place or colour, and if it would touch a robot or an obstacle. With
        `even_into_the_robot` robots do not count, and are then pushed out of it. With
        `nearest_free` it is put at the nearest place where it touches nothing.
        """
        obstacle = shape(name, (x, y, yaw_deg), size, radius, height, colour)
        return self.put(
            obstacle, even_into_the_robot=even_into_the_robot, nearest_free=nearest_free
        )

    def put(
        self,
        obstacle: Obstacle,
        *,
        even_into_the_robot: bool = False,
        nearest_free: bool = False,
    ) -> Prop:
        """Put an obstacle of any shape at its place. Raises PropError as `place` does."""
        simulator = self._physics.simulator
        if simulator is not None:
            raise PropError(simulator.refusal("an obstacle that appears"))
        slot = self._free(obstacle.name)
        self._check_name(obstacle.name)
        if not nearest_free:
            self.check_floor(obstacle.name, obstacle.x, obstacle.y)
        prop = self.placed[slot] = Prop(self, slot, obstacle)
        touched: str | None = None
        for tried in self._around(obstacle) if nearest_free else (obstacle,):
            prop.obstacle = tried
            prop.begin_anew()
            self._bodies.show(slot, tried)
            self._changed()
            touched = self._touched(slot, robots=not even_into_the_robot)
            if touched is None:
                return prop
        self.remove(slot)
        assert touched is not None, "at least one place was tried"
        hint = ", or say even_into_the_robot=True"
        raise _no_room(obstacle, touched, hint if touched not in self._obstacles() else "")

    def _around(self, obstacle: Obstacle) -> Iterator[Obstacle]:
        """Yield an obstacle at places of the floor, the nearest to its own first."""
        length, width = self._physics.world.size
        x = min(max(obstacle.x, -length / 2), length / 2)
        y = min(max(obstacle.y, -width / 2), width / 2)
        yield replace(obstacle, x=x, y=y)
        for ring in range(1, math.ceil(math.hypot(length, width) / RING)):
            for number in range(count := 6 * ring):
                angle = 2 * math.pi * number / count
                to_x, to_y = x + ring * RING * math.cos(angle), y + ring * RING * math.sin(angle)
                if self._physics.world.has_floor_at(to_x, to_y):
                    yield replace(obstacle, x=round(to_x, 6), y=round(to_y, 6))

    def relocate(self, prop: Prop, place: tuple[float, float, float]) -> None:
        """Put one that is in the world elsewhere at once, to stand: x m, y m, yaw rad.

        Raises PropError if it would touch something; it then stays in place.
        """
        x, y, yaw = place
        self.check_floor(prop.name, x, y)
        (slot,) = (slot for slot, placed in self.placed.items() if placed is prop)
        before = prop.obstacle, prop.course, prop.since_ns
        prop.obstacle = replace(prop.obstacle, x=x, y=y).turned(yaw)
        prop.begin_anew()
        self._bodies.show(slot, prop.obstacle)
        self._changed()
        touched = self._touched(slot, robots=True)
        if touched is not None:
            refused = _no_room(prop.obstacle, touched)
            prop.obstacle, prop.course, prop.since_ns = before
            self._bodies.show(slot, prop.obstacle)
            self._changed()
            raise refused

    def put_back(self) -> list[str]:
        """Return each to the place where it was put, and remove those whose place is occupied.

        Returns the names of those.
        """
        for prop in self:
            prop.begin_anew()
        if not self:
            return []
        self._changed()
        names = []
        for slot, prop in tuple(self.placed.items()):
            if self._touched(slot, robots=True) is not None:
                names.append(prop.name)
                self.remove(slot)
        return names

    def clear(self) -> None:
        """Remove all."""
        for slot in tuple(self.placed):
            self.remove(slot)

    # ---- for the physics and for props ---------------------------------------------------

    def move(self, data: mujoco.MjData, time_ns: int) -> None:
        """Set positions and velocities to those at this time."""
        qpos, qvel = data.qpos, data.qvel
        for index, prop in self.placed.items():
            slot = self._slots[index]
            x, y, vx, vy = prop.course.at((time_ns - prop.since_ns) / 1e9)
            qpos[slot.q], qpos[slot.q + 1] = x, y
            qvel[slot.v], qvel[slot.v + 1] = vx, vy

    def holds(self, prop: Prop, index: int) -> bool:
        """Return whether a prop is in the world."""
        return self.placed.get(index) is prop

    def remove(self, index: int) -> None:
        """Remove a spare body from the world."""
        slot, data = self._slots[index], self._physics.data
        self._bodies.hide(index)
        del self.placed[index]
        data.qpos[slot.q : slot.q + 2] = 0.0
        data.qvel[slot.v : slot.v + 2] = 0.0
        self._changed()

    def check_floor(self, name: str, x: float, y: float) -> None:
        """Raise PropError for a place that is not on the floor."""
        world = self._physics.world
        if not world.has_floor_at(x, y):
            raise PropError(f"prop '{name}': ({x:g}, {y:g}) is not on {world.floor}")

    # ---- inside --------------------------------------------------------------------------

    def _changed(self) -> None:
        """Update everything that depends on the props at this instant."""
        self.shown = tuple(self._bodies.shown)
        data = self._physics.data
        self.move(data, self.time_ns)
        mujoco.mj_kinematics(self._physics.model, data)

    def _free(self, name: str) -> int:
        for index in range(self.count):
            if index not in self.placed:
                return index
        there = listed([prop.name for prop in self]) if self else ""
        raise PropError(
            f"no free prop for '{name}': this simulation has {self.count}"
            + (f", all in the world: {there}; remove one, or" if there else ";")
            + f" make it with props={self.count + 1} or more (up to {MOST})"
        )

    def _obstacles(self) -> list[str]:
        return [
            *(obstacle.name for obstacle in self._physics.world.obstacles),
            *(prop.name for prop in self),
        ]

    def _check_name(self, name: str) -> None:
        if not 1 <= len(name) <= 60:
            raise PropError(f"expected a name of 1 to 60 letters for a prop, got {len(name)}")
        if name in self._obstacles() or name in self._physics.robot_names:
            raise PropError(
                f"the name '{name}' is taken: collisions are reported by it; choose another"
            )

    def _touched(self, index: int, *, robots: bool) -> str | None:
        """Return the name of the obstacle that a prop touches, or None."""
        physics, geom = self._physics, self._slots[index].geom
        others = [other for other in physics.obstacle_geoms if other != geom]
        if robots:
            others += [
                other for prefix in physics.prefixes for other in touching(physics.model, prefix)
            ]
        clearance = Gauge(physics.model, physics.names, [geom], others).measure(physics.data, 0.0)
        return clearance.obstacle if clearance.distance < -_TOUCHING else None
