"""Everything in a simulation that has a name: robots, what the world has, and what was spawned.

Pure: no ROS. Places are poses on the floor, in the map, or in the frame of another entity.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from bt_mission.base.diagnostics import did_you_mean, listed
from bt_mission.base.errors import BtMissionError
from bt_mission.base.geometry import Pose2D, composed
from sim.physics.physics import Physics
from sim.physics.prop_bodies import PropError
from sim.physics.props import Prop
from sim.robot.robot import SimulatedRobot
from sim.spawnables import Spawnable
from sim.world.shapes import Obstacle
from sim.world.world import FASTEST

Corner = tuple[float, float, float]

WORLD_FRAMES = ("", "map", "world")

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.\-/ ]{0,59}")


class Category(IntEnum):
    """The kind of an entity: simulation_interfaces/EntityCategory."""

    OBJECT = 0
    ROBOT = 1
    HUMAN = 2
    DYNAMIC_OBJECT = 4
    STATIC_OBJECT = 5


class UnknownEntityError(BtMissionError):
    """No entity has that name."""

    code = "BT-807"


class FixedEntityError(BtMissionError):
    """An operation that this simulation does not support for such an entity."""

    code = "BT-807"


class InvalidPoseError(BtMissionError):
    """An invalid pose, or one at which nothing can be."""

    code = "BT-807"


class InvalidNameError(BtMissionError):
    """A name that no entity can have."""

    code = "BT-807"


class NameTakenError(BtMissionError):
    """A name that another entity has."""

    code = "BT-807"


@dataclass(frozen=True, slots=True)
class EntityInfo:
    """The properties of an entity apart from its pose."""

    category: int
    description: str
    tags: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class EntityState:
    """The pose and velocity of an entity: m/s along x and y of the map, rad/s."""

    pose: Pose2D
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Entities:
    """The entities of one simulation by their unique names.

    A robot alone has the name of its model, otherwise its own name.
    """

    def __init__(self, physics: Physics, robots: Sequence[SimulatedRobot]) -> None:
        self._physics = physics
        self._obstacles = {obstacle.name: obstacle for obstacle in physics.world.obstacles}
        self._robots = {self._name_of(robot): robot for robot in robots}
        self._infos: dict[str, EntityInfo] = {}

    @property
    def names(self) -> list[str]:
        """All names: robots, the world's obstacles, what was spawned."""
        return [*self._robots, *self._obstacles, *(prop.name for prop in self._physics.props)]

    def state(self, name: str) -> EntityState:
        """Return where it is. Raises UnknownEntityError."""
        entity = self._find(name)
        if isinstance(entity, SimulatedRobot):
            return EntityState(Pose2D(*entity.pose), entity.map_velocity)
        if isinstance(entity, Prop):
            return EntityState(
                Pose2D(*entity.position, entity.obstacle.yaw), (*entity.velocity, 0.0)
            )
        if entity.motion is None:
            return EntityState(Pose2D(entity.x, entity.y, entity.yaw))
        x, y, vx, vy = entity.motion.at(self._physics.running_s)
        return EntityState(Pose2D(x, y, entity.yaw), (vx, vy, 0.0))

    def bounds(self, name: str) -> tuple[Corner, Corner]:
        """Return the lower and upper corner of a box around it, in its frame, m.

        Its frame is on the floor, in its middle (for a robot: below the middle of its axle). Raises
        UnknownEntityError.
        """
        entity = self._find(name)
        if isinstance(entity, SimulatedRobot):
            hull, body = entity.robot.hull, entity.robot.body
            top = entity.robot.base_height + body.heights[1]
            return (hull.rear, -hull.half_width, 0.0), (hull.front, hull.half_width, top)
        length, width, height = (entity.obstacle if isinstance(entity, Prop) else entity).size
        return (-length / 2, -width / 2, 0.0), (length / 2, width / 2, height)

    def info(self, name: str) -> EntityInfo:
        """Return what is known of it. Raises UnknownEntityError."""
        entity = self._find(name)
        if name in self._infos:
            return self._infos[name]
        if isinstance(entity, SimulatedRobot):
            return EntityInfo(Category.ROBOT, f"a {entity.robot.name}", ("robot",))
        if isinstance(entity, Prop):
            return EntityInfo(Category.OBJECT, f"a {entity.obstacle.kind}", ("spawned",))
        if entity.motion is None:
            return EntityInfo(Category.STATIC_OBJECT, f"a {entity.kind} of the world", ("world",))
        description = f"a {entity.kind} of the world, which moves"
        return EntityInfo(Category.DYNAMIC_OBJECT, description, ("world", "moving"))

    def set_info(self, name: str, info: EntityInfo) -> None:
        """Replace its properties, until it is deleted. Raises UnknownEntityError."""
        self._find(name)
        self._infos[name] = info

    def forget_absent(self) -> None:
        """Drop the properties of entities that are gone."""
        there = set(self.names)
        self._infos = {name: info for name, info in self._infos.items() if name in there}

    # ---- changes -------------------------------------------------------------------------

    def spawn(self, name: str, made: Spawnable, pose: Pose2D, *, may_rename: bool) -> str:
        """Put an entity on the floor, and return its name.

        `name` may be empty; then the name in the description counts. Raises InvalidNameError,
        NameTakenError, InvalidPoseError, and PropError if it does not fit or all are in use.
        """
        wanted = name or made.name or ""
        if wanted and not _NAME.fullmatch(wanted):
            raise InvalidNameError(
                "expected a name of 1 to 60 letters, digits, '_', '.', '-', '/' or spaces, the"
                f" first a letter, a digit or '_', got '{wanted[:60]}'"
            )
        if not wanted and not may_rename:
            raise InvalidNameError("no name is given; give one, or allow renaming")
        if wanted in self._taken and not may_rename:
            raise NameTakenError(f"the name '{wanted}' is taken; give another, or allow renaming")
        chosen = self._free_name(wanted or ("cylinder" if made.size is None else "box"))
        self._check_place(pose)
        self.forget_absent()
        self._physics.props.put(made.obstacle(chosen, pose))
        return chosen

    def delete(self, name: str) -> None:
        """Take what was spawned out of the world. Raises UnknownEntityError, FixedEntityError."""
        entity = self._find(name)
        if not isinstance(entity, Prop):
            what = "a robot" if isinstance(entity, SimulatedRobot) else "a part of the world"
            raise FixedEntityError(f"'{name}' is {what}: only what was spawned can be deleted")
        entity.remove()
        self.forget_absent()

    def move(self, name: str, state: EntityState) -> None:
        """Put it elsewhere at once; it continues at the velocity.

        Raises UnknownEntityError, FixedEntityError for a part of the world, InvalidPoseError, and
        SpawnError or PropError if it does not fit, or cannot move like that.
        """
        entity = self._find(name)
        if isinstance(entity, Obstacle):
            raise FixedEntityError(f"'{name}' is a part of the world: it stays as the world has it")
        self._check_place(state.pose)
        if not all(abs(speed) <= 2 * FASTEST for speed in state.velocity):
            text = ", ".join(f"{speed:g}" for speed in state.velocity)
            raise PropError(f"expected at most {2 * FASTEST:g} m/s and rad/s, got ({text})")
        if isinstance(entity, SimulatedRobot):
            pose = state.pose
            entity.put((pose.x, pose.y, pose.yaw), state.velocity)
        else:
            self._move_prop(entity, state)

    def in_map(self, frame: str, pose: Pose2D) -> Pose2D:
        """Return a pose in the map that is given in the frame of an entity, or of the world.

        Raises InvalidPoseError for a frame that is not known.
        """
        if frame in WORLD_FRAMES:
            return pose
        if frame not in self._taken:
            raise InvalidPoseError(
                f"no frame is known as '{frame[:60]}'; known are 'map', and those of the entities:"
                f" {listed(self.names, most=10)}"
            )
        return composed(self.state(frame).pose, pose)

    # ---- inside --------------------------------------------------------------------------

    @property
    def _taken(self) -> set[str]:
        return {*self.names, *self._physics.robot_names}

    def _find(self, name: str) -> SimulatedRobot | Obstacle | Prop:
        entity = self._robots.get(name) or self._obstacles.get(name)
        if entity is not None:
            return entity
        for prop in self._physics.props:
            if prop.name == name:
                return prop
        near = did_you_mean(name, self.names)
        raise UnknownEntityError(
            f"there is no '{name[:60]}'; there are {listed(self.names, most=10)}"
            + (f"; {near}" if near else "")
        )

    def _name_of(self, robot: SimulatedRobot) -> str:
        name = robot.name or robot.robot.name
        return name if name not in self._obstacles else f"robot {name}"

    def _free_name(self, wanted: str) -> str:
        taken, number, name = self._taken, 1, wanted
        while name in taken:
            number += 1
            name = f"{wanted[:55]}_{number}"
        return name

    def _check_place(self, pose: Pose2D) -> None:
        world = self._physics.world
        if not world.has_floor_at(pose.x, pose.y):
            raise InvalidPoseError(f"({pose.x:g}, {pose.y:g}) is not on {world.floor}")

    def _move_prop(self, prop: Prop, state: EntityState) -> None:
        vx, vy, turn = state.velocity
        if turn:
            raise PropError(f"'{prop.name}' cannot keep turning; give an angular velocity of 0")
        if math.hypot(vx, vy) > FASTEST:
            raise PropError(
                f"expected at most {FASTEST:g} m/s for '{prop.name}', got ({vx:g}, {vy:g})"
            )
        self._physics.props.relocate(prop, (state.pose.x, state.pose.y, state.pose.yaw))
        prop.move_at(vx, vy)
