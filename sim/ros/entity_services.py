"""The standard services for entities of a simulation: list, read, move, spawn, delete."""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from typing import Any

from geometry_msgs.msg import Vector3
from rclpy.exceptions import InvalidNamespaceException
from rclpy.node import Node
from rclpy.validate_namespace import validate_namespace
from simulation_interfaces import msg, srv

from bt_mission.base.diagnostics import InputError, quoted
from bt_mission.base.errors import BtMissionError
from bt_mission.base.geometry import Pose2D
from bt_mission.base.ros_log import log_of
from sim import entities as errors
from sim.entities import Entities, EntityInfo, EntityState
from sim.ros import entity_messages
from sim.ros.name_patterns import PatternError, matching
from sim.ros.requests import Code, Feature, Offer, RefusedError, fill_result, offer
from sim.ros.run_control import RunControl
from sim.spawnables import (
    SPAWNABLES,
    FormatError,
    NoResourceError,
    RobotsAreFixedError,
    Spawnable,
    read_spawnable,
)

MOST_SPAWNED = 64
"""The number of entities that one request may spawn."""

MOST_TAGS = 50


class SpawnCode(IntEnum):
    """Why nothing was spawned: simulation_interfaces/SpawnResult."""

    NAME_NOT_UNIQUE = 101
    NAME_INVALID = 102
    UNSUPPORTED_FORMAT = 103
    NO_RESOURCE = 104
    NAMESPACE_INVALID = 105
    RESOURCE_PARSE_ERROR = 106
    INVALID_POSE = 109
    ENTITIES_SPAWN_FAILED = 150


INVALID_POSE = 101
"""Of simulation_interfaces/SetEntityState."""

_SPAWN_CODES: tuple[tuple[type[BtMissionError], int], ...] = (
    (errors.NameTakenError, SpawnCode.NAME_NOT_UNIQUE),
    (errors.InvalidNameError, SpawnCode.NAME_INVALID),
    (errors.InvalidPoseError, SpawnCode.INVALID_POSE),
    (FormatError, SpawnCode.UNSUPPORTED_FORMAT),
    (NoResourceError, SpawnCode.NO_RESOURCE),
    (InputError, SpawnCode.RESOURCE_PARSE_ERROR),
    (RobotsAreFixedError, Code.FEATURE_UNSUPPORTED),
)
_CODES: tuple[tuple[type[BtMissionError], int], ...] = (
    (errors.UnknownEntityError, Code.NOT_FOUND),
    (errors.FixedEntityError, Code.FEATURE_UNSUPPORTED),
    (errors.InvalidPoseError, INVALID_POSE),
)


class EntityServices:
    """The services for the entities of a simulation.

    Args:
        node: The node of the services.
        control: Whether the simulator is about to end.
        entities: The entities of the simulation.
        fill_now: Fills a stamp with the time on `/clock`, and returns it.
    """

    def __init__(
        self,
        node: Node,
        control: RunControl,
        entities: Entities,
        fill_now: Callable[[Any], Any],
    ) -> None:
        self._node = node
        self._entities = entities
        self._fill_now = fill_now
        self.features = offer(node, control, srv, self._offers())

    def _offers(self) -> tuple[Offer, ...]:
        features = (Feature.ENTITY_TAGS, Feature.ENTITY_CATEGORIES, Feature.ENTITY_BOUNDS_BOX)
        spawned = (Feature.SPAWNING, Feature.SPAWNING_RESOURCE_STRING)
        return (
            Offer("GetEntities", self._get_entities, features),
            Offer("GetEntitiesStates", self._get_states, (Feature.ENTITY_STATE_GETTING,)),
            Offer("GetEntityState", self._get_state),
            Offer("SetEntityState", self._set_state, (Feature.ENTITY_STATE_SETTING,)),
            Offer("GetEntityInfo", self._get_info, (Feature.ENTITY_INFO_GETTING,)),
            Offer("SetEntityInfo", self._set_info, (Feature.ENTITY_INFO_SETTING,)),
            Offer("GetEntityBounds", self._get_bounds, (Feature.ENTITY_BOUNDS,)),
            Offer("GetSpawnables", self._get_spawnables, (Feature.SPAWNABLES,)),
            Offer("SpawnEntity", self._spawn_entity, spawned),
            Offer("SpawnEntities", self._spawn_all, (Feature.SPAWNING_ENTITIES,)),
            Offer("DeleteEntity", self._delete, (Feature.DELETING,)),
        )

    # ---- looked at -----------------------------------------------------------------------

    def _get_entities(self, request: Any, response: Any) -> None:
        response.entities = self._matching_names(request.filters)

    def _get_states(self, request: Any, response: Any) -> None:
        response.entities = self._matching_names(request.filters)
        response.states = [self._state(name) for name in response.entities]

    def _get_state(self, request: Any, response: Any) -> None:
        with _Refusing(_CODES):
            response.state = self._state(request.entity)

    def _get_info(self, request: Any, response: Any) -> None:
        with _Refusing(_CODES):
            info = self._entities.info(request.entity)
        response.info.category.category = int(info.category)
        response.info.description, response.info.tags = info.description, list(info.tags)

    def _get_bounds(self, request: Any, response: Any) -> None:
        with _Refusing(_CODES):
            corners = self._entities.bounds(request.entity)
        entity_messages.fill_box(response.bounds, Vector3, corners)

    def _get_spawnables(self, request: Any, response: Any) -> None:
        for name, kind in SPAWNABLES.items():
            spawnable = msg.Spawnable(uri=name, description=kind.description)
            made = read_spawnable(name, "").obstacle(name, Pose2D(0.0, 0.0, 0.0))
            length, width, height = made.size
            corners = (-length / 2, -width / 2, 0.0), (length / 2, width / 2, height)
            entity_messages.fill_box(spawnable.spawn_bounds, Vector3, corners)
            response.spawnables.append(spawnable)
        if request.sources:
            text = f"not known as sources: {', '.join(map(quoted, request.sources[:10]))}"
            fill_result(response.result, Code.OK, text)

    # ---- changed -------------------------------------------------------------------------

    def _set_state(self, request: Any, _: Any) -> None:
        with _Refusing(_CODES):
            self._entities.state(request.entity)  # an unknown name is reported first
            state, frame = request.state, request.state.header.frame_id
            pose = self._entities.in_map(frame, entity_messages.read_pose(state.pose))
            direction = self._entities.in_map(frame, Pose2D(0.0, 0.0, 0.0)).yaw
            velocity = entity_messages.read_velocity(state.twist)
            turned = entity_messages.rotated(velocity, direction)
            self._entities.move(request.entity, EntityState(pose, turned))

    def _set_info(self, request: Any, _: Any) -> None:
        info, category = request.info, request.info.category.category
        if category not in set(errors.Category):
            names = ", ".join(f"{known.value} ({known.name.lower()})" for known in errors.Category)
            raise RefusedError(Code.OPERATION_FAILED, f"expected a category of {names}")
        if len(info.tags) > MOST_TAGS or max(map(len, (info.description, *info.tags))) > 1000:
            text = f"expected at most {MOST_TAGS} tags, and texts of at most 1000 characters"
            raise RefusedError(Code.OPERATION_FAILED, text)
        known_now = EntityInfo(category, info.description, tuple(info.tags))
        with _Refusing(_CODES):
            self._entities.set_info(request.entity, known_now)

    def _delete(self, request: Any, _: Any) -> None:
        with _Refusing(_CODES):
            self._entities.delete(request.entity)
        log_of(self._node).info(f"'{request.entity}' deleted")

    def _spawn_entity(self, request: Any, response: Any) -> None:
        response.entity_name = self._spawn(request, request.uri, request.resource_string)

    def _spawn_all(self, request: Any, response: Any) -> None:
        if len(request.spawn_requests) > MOST_SPAWNED:
            text = f"expected at most {MOST_SPAWNED} requests, got {len(request.spawn_requests)}"
            raise RefusedError(Code.OPERATION_FAILED, text)
        failed = 0
        for spawn in request.spawn_requests:
            result, resource = msg.SpawnResult(), spawn.entity_resource
            response.results.append(result)
            try:
                result.entity_name = self._spawn(spawn, resource.uri, resource.resource_string)
                fill_result(result.result, Code.OK)
            except BtMissionError as error:
                failed += 1
                code = (
                    error.result_code if isinstance(error, RefusedError) else Code.OPERATION_FAILED
                )
                fill_result(result.result, code, str(error))
        if failed:
            text = f"{failed} of {len(request.spawn_requests)} were not spawned; see results"
            fill_result(response.result, SpawnCode.ENTITIES_SPAWN_FAILED, text)

    def _spawn(self, request: Any, uri: str, text: str) -> str:
        with _Refusing(_SPAWN_CODES):
            _check_namespace(request.entity_namespace)
            made: Spawnable = read_spawnable(uri, text)
            initial = request.initial_pose
            pose = entity_messages.read_pose(initial.pose)
            pose = self._entities.in_map(initial.header.frame_id, pose)
            name = self._entities.spawn(request.name, made, pose, may_rename=request.allow_renaming)
        log_of(self._node).info(f"'{name}' spawned at ({pose.x:g}, {pose.y:g})")
        return name

    # ---- inside --------------------------------------------------------------------------

    def _state(self, name: str) -> Any:
        entity_state = msg.EntityState()
        self._fill_now(entity_state.header.stamp)
        return entity_messages.fill_state(entity_state, self._entities.state(name))

    def _matching_names(self, filters: Any) -> list[str]:
        """Return the names that pass all filters."""
        entities, names = self._entities, self._entities.names
        if filters.filter:
            try:
                names = matching(filters.filter, names)
            except PatternError as error:
                raise RefusedError(Code.OPERATION_FAILED, f"filter: {error}") from error
        wanted = {category.category for category in filters.categories}
        if wanted:
            names = [name for name in names if entities.info(name).category in wanted]
        if filters.tags.tags:
            names = [
                name
                for name in names
                if entity_messages.passes(filters.tags, entities.info(name).tags)
            ]
        if filters.bounds.type == entity_messages.EMPTY:
            return names
        if filters.bounds.type not in {entity_messages.BOX, entity_messages.SPHERE}:
            text = "expected bounds of type 1 (box) or 3 (sphere) to filter by"
            raise RefusedError(Code.FEATURE_UNSUPPORTED, text)
        try:
            return [
                name
                for name in names
                if entity_messages.overlaps(
                    entity_messages.around(entities.state(name), entities.bounds(name)),
                    filters.bounds,
                )
            ]
        except ValueError as error:
            raise RefusedError(Code.OPERATION_FAILED, f"bounds: {error}") from error


class _Refusing:
    """Turns errors into refusals with the codes of a service."""

    def __init__(self, codes: tuple[tuple[type[BtMissionError], int], ...]) -> None:
        self._codes = codes

    def __enter__(self) -> None:
        pass

    def __exit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        for kind, code in self._codes:
            if isinstance(error, kind):
                text = error.on_one_line if isinstance(error, InputError) else str(error)
                raise RefusedError(code, text) from error


def _check_namespace(namespace: str) -> None:
    """Raise RefusedError for an invalid namespace; entities have no topics, so it has no effect."""
    if namespace:
        try:
            validate_namespace(namespace if namespace.startswith("/") else f"/{namespace}")
        except InvalidNamespaceException as error:
            text = f"expected a namespace such as /shelf, got {quoted(namespace)}"
            raise RefusedError(SpawnCode.NAMESPACE_INVALID, text) from error
