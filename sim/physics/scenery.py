"""The obstacles of a world and their appearance, as MuJoCo geoms."""

from __future__ import annotations

import math

import mujoco

from sim.physics.names import (
    FLOOR,
    FLOOR_BIT,
    FLOOR_CONTACTS,
    LOOSE_BIT,
    LOOSE_PREFIX,
    MARKS,
    MOVER_PREFIX,
    OBSTACLE_BIT,
    OBSTACLE_PREFIX,
    OBSTACLES,
    SLIDE,
    SOLID,
    SOLIMP,
    SOLREF,
)
from sim.world.shapes import Obstacle, rgba
from sim.world.world import LooseBox, SlipperyPatch, World, Zone

TON = 1000.0
"""kg, and kg m^2."""


def add_world(spec: mujoco.MjSpec, world: World) -> None:
    """Add floor, obstacles and zones, sky and light."""
    _add_sky_and_light(spec)
    _add_floor(spec, world.size, grip=0.0 if world.slippery else 1.0)
    _add_obstacles(spec, world.obstacles)
    for loose in world.objects:
        _add_loose(spec, loose)
    marks: tuple[Zone | SlipperyPatch, ...] = (*world.slippery, *world.zones)
    for mark in marks:
        _add_mark(spec, mark)


def yaw_quaternion(yaw: float) -> list[float]:
    """Return a turn about z by `yaw` rad, as w, x, y, z."""
    return [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]


def _add_sky_and_light(spec: mujoco.MjSpec) -> None:
    visual = spec.visual
    visual.headlight.ambient = [0.5, 0.5, 0.5]
    visual.headlight.diffuse = [0.15, 0.15, 0.15]
    visual.headlight.specular = [0.0, 0.0, 0.0]
    visual.quality.offsamples = 0  # smooth edges cost three times the rest of an image
    visual.quality.shadowsize = 0  # no map for the shadows that nothing casts: 64 MB
    visual.map.znear = 0.002  # of the world's extent: a wall at the lens is still drawn
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.72, 0.82, 0.92],
        rgb2=[0.95, 0.97, 0.98],
        width=128,
        height=128,
    )
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[0, 0, 4],
        dir=[0.3, 0.45, -1],
        diffuse=[0.4, 0.4, 0.4],
        specular=[0, 0, 0],
        castshadow=False,  # shadows cost ten times the rest of an image
    )


def _add_floor(spec: mujoco.MjSpec, size: tuple[float, float], grip: float) -> None:
    spec.add_texture(
        name="tiles",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.52, 0.55, 0.58],
        rgb2=[0.59, 0.62, 0.65],
        width=128,
        height=128,
    )
    tiles = spec.add_material(name="tiles", texrepeat=[1, 1], texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    length, width = size
    spec.worldbody.add_geom(
        name=FLOOR,
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[length / 2, width / 2, 0.05],
        material="tiles",
        contype=FLOOR_BIT,
        conaffinity=0,
        group=SOLID,
        # The larger friction of two bodies counts: with none here, the wheels' friction applies.
        friction=[grip, 0.005, 0.0001],
        solref=SOLREF,
        solimp=SOLIMP,
    )
    spec.add_sensor(
        name=FLOOR_CONTACTS,
        type=mujoco.mjtSensor.mjSENS_CONTACT,
        objtype=mujoco.mjtObj.mjOBJ_GEOM,
        objname=FLOOR,
        intprm=[1, 0, 1],  # only the number of contacts, not reduced, in one slot
    )


def _add_obstacles(spec: mujoco.MjSpec, obstacles: tuple[Obstacle, ...]) -> None:
    """Add all obstacles to one static body; each moving one is a separate body below it."""
    static = spec.worldbody.add_body(name=OBSTACLES)
    for obstacle in obstacles:
        length, width, height = obstacle.size
        cylinder = obstacle.kind == "cylinder"
        body = static
        if obstacle.motion is not None:
            at = (obstacle.x, obstacle.y, height / 2)
            body = add_sliding_body(static, MOVER_PREFIX + obstacle.name, at)
        body.add_geom(
            name=OBSTACLE_PREFIX + obstacle.name,
            type=mujoco.mjtGeom.mjGEOM_CYLINDER if cylinder else mujoco.mjtGeom.mjGEOM_BOX,
            size=[length / 2, height / 2, 0] if cylinder else [length / 2, width / 2, height / 2],
            pos=[obstacle.x, obstacle.y, height / 2] if body is static else [0, 0, 0],
            quat=yaw_quaternion(obstacle.yaw),
            rgba=obstacle.rgba,
            contype=OBSTACLE_BIT,
            conaffinity=0,
            friction=SLIDE,
            group=SOLID,
        )


def _add_loose(spec: mujoco.MjSpec, loose: LooseBox) -> None:
    """Add a box that robots can push and grip; its contacts do not let it slide in a gripper."""
    x, y, z = loose.size
    body = spec.worldbody.add_body(
        name=LOOSE_PREFIX + loose.name,
        pos=[loose.x, loose.y, loose.z + z / 2],
        quat=yaw_quaternion(math.radians(loose.yaw)),
    )
    body.add_freejoint(name=LOOSE_PREFIX + loose.name)
    body.add_geom(
        name=LOOSE_PREFIX + loose.name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=[x / 2, y / 2, z / 2],
        mass=loose.mass,
        rgba=rgba(loose.colour),
        contype=LOOSE_BIT,
        conaffinity=FLOOR_BIT | OBSTACLE_BIT | LOOSE_BIT,
        condim=4,
        friction=[loose.friction, 0.01, 0.0001],
        group=SOLID,
    )


def add_sliding_body(parent: mujoco.MjsBody, name: str, at: tuple[float, ...]) -> mujoco.MjsBody:
    """Add a body of a ton that slides along x and y, on joints of its name."""
    body = parent.add_body(
        name=name,
        pos=at,
        mass=TON,
        inertia=[TON, TON, TON],
        ipos=[0, 0, 0],
        explicitinertial=True,
    )
    for axis, letter in enumerate("xy"):
        body.add_joint(
            name=f"{name}/{letter}",
            type=mujoco.mjtJoint.mjJNT_SLIDE,
            axis=[1 - axis, axis, 0],
        )
    return body


def _add_mark(spec: mujoco.MjSpec, zone: Zone | SlipperyPatch) -> None:
    """Add a zone or a slippery place, a millimetre thick."""
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_CYLINDER,
        size=[zone.radius, 0.0005, 0],
        pos=[zone.x, zone.y, 0.0005],
        rgba=rgba(zone.colour),
        contype=0,
        conaffinity=0,
        group=MARKS,
    )
