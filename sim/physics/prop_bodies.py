"""Spare bodies in a model: what makes obstacles that come and go possible in MuJoCo.

A compiled model keeps its bodies, so a number of them is compiled in, and lies below the floor
where nothing touches or sees it. Showing one gives it the shape, size, direction and colour of an
obstacle, and puts it on the floor. Like every obstacle that moves (`sim.physics.physics.Movers`) it
slides on two joints and weighs a ton.

A model with spare bodies moves its robots as one without, bit for bit, until one is shown: they
come last, weigh nothing on each other, and what the solver and the renderer take from the model
as a whole is taken from the model without them.

The number, shapes and sizes of props.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np

from bt_mission.base.errors import BtMissionError
from sim.physics.contacts import geom_names
from sim.physics.names import NOWHERE, OBSTACLE_BIT, PROP_PREFIX, PROPS, SLIDE, SOLID
from sim.physics.scenery import add_sliding_body, yaw_quaternion
from sim.world.shapes import Obstacle
from sim.world.world import FARTHEST, SHORTEST

MOST = 64
"""Props in one simulation."""


class PropError(BtMissionError):
    """A prop that cannot be placed, or cannot move as requested."""

    code = "BT-807"


def check_count(count: int) -> None:
    """Raise PropError for a number of props that cannot be."""
    if not 0 <= count <= MOST:
        raise PropError(f"expected 0 to {MOST} props in a simulation, got {count}")


def shape(
    name: str,
    place: tuple[float, float, float],
    size: tuple[float, float, float] | None,
    radius: float | None,
    height: float,
    colour: str,
) -> Obstacle:
    """Return a box, or a cylinder, at x, y (m) and yaw (deg). Raises PropError."""
    x, y, yaw_deg = place
    if (size is None) == (radius is None):
        raise PropError(
            f"prop '{name}': expected size=(length, width, height) for a box, or radius= (and"
            f" height=) for a cylinder; got {'neither' if size is None else 'both'}"
        )
    edges = (radius or 0.0, height) if size is None else tuple(size)
    if size is not None and len(edges) != 3:
        raise PropError(f"prop '{name}': expected size=(length, width, height), got {size}")
    if not all(SHORTEST <= edge <= FARTHEST for edge in edges):
        raise PropError(
            f"prop '{name}': expected {'radius and height' if size is None else 'edges'} from"
            f" {SHORTEST:g} m to {FARTHEST:g} m, got ({', '.join(f'{edge:g}' for edge in edges)})"
        )
    if not abs(yaw_deg) <= 360:
        raise PropError(f"prop '{name}': expected a yaw from -360 to 360 deg, got {yaw_deg:g}")
    try:
        if size is None:
            return Obstacle.cylinder(name, x, y, radius=edges[0], height=height, colour=colour)
        return Obstacle.box(name, x, y, yaw=math.radians(yaw_deg), size=size, colour=colour)
    except ValueError as error:
        raise PropError(f"prop '{name}': {error}") from error


_SIZE = 0.01
_BELOW = -1.0
"""Metres: half an edge of a spare body, and where it lies."""


def add_bodies(spec: mujoco.MjSpec, count: int) -> None:
    """Add spare bodies."""
    static = spec.worldbody.add_body(name=PROPS)
    for index in range(count):
        name = f"{PROP_PREFIX}{index}"
        add_sliding_body(static, name, (0.0, 0.0, 0.0)).add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[_SIZE] * 3,
            # What touches nothing when it is compiled has no bounds for rays.
            contype=OBSTACLE_BIT,
            conaffinity=0,
            friction=SLIDE,
            group=NOWHERE,
        )


def keep_figures(model: mujoco.MjModel, without: mujoco.MjModel) -> None:
    """Give a model with spare bodies what the solver and the renderer know of one without.

    The solver ends where what it could still gain, divided by the number of joints' axes and
    their mean inertia, is small; the renderer's planes lie at shares of the world's extent.
    """
    figures, model_nv = without.stat, model.nv
    for field in ("extent", "meanmass", "meansize"):
        setattr(model.stat, field, getattr(figures, field))
    model.stat.center[:] = figures.center
    model.stat.meaninertia = _share(figures.meaninertia * without.nv, model_nv)
    model.opt.jacobian = (
        mujoco.mjtJacobian.mjJAC_SPARSE
        if mujoco.mj_isSparse(without)
        else mujoco.mjtJacobian.mjJAC_DENSE
    )


class PropBodies:
    """The spare bodies of one model. Only shows and hides obstacles.

    `names` are the reported names of geoms (`contacts.geom_names`); it is kept up to date.
    """

    def __init__(self, model: mujoco.MjModel, names: list[str]) -> None:
        self._model = model
        self._names = names
        self.geoms = tuple(
            geom for geom in range(model.ngeom) if model.geom(geom).name.startswith(PROP_PREFIX)
        )
        bodies = [int(model.geom_bodyid[geom]) for geom in self.geoms]
        joints = [int(model.body_jntadr[body]) for body in bodies]
        self._bodies = bodies
        self.addresses = tuple(
            (int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])) for joint in joints
        )
        """The address of x in qpos, and of its rate in qvel, for each; y is next."""
        self.shown: list[Obstacle | None] = [None] * len(bodies)
        for index in range(len(bodies)):
            self.hide(index)

    def show(self, index: int, obstacle: Obstacle) -> None:
        """Make one look and collide like an obstacle. Its place on the floor is in qpos."""
        length, width, height = (edge / 2 for edge in obstacle.size)
        self._place(
            index,
            kind=mujoco.mjtGeom.mjGEOM_CYLINDER
            if obstacle.kind == "cylinder"
            else mujoco.mjtGeom.mjGEOM_BOX,
            halves=(length, width, height),
            yaw=obstacle.yaw,
        )
        geom, body = self.geoms[index], self._bodies[index]
        self._model.geom_rgba[geom] = obstacle.rgba
        self._model.geom_group[geom] = SOLID
        self._model.geom_contype[geom] = self._model.body_contype[body] = OBSTACLE_BIT
        self._model.body_pos[body, 2] = height
        self._names[geom] = obstacle.name
        self.shown[index] = obstacle

    def hide(self, index: int) -> None:
        """Hide a body."""
        self._place(index, kind=mujoco.mjtGeom.mjGEOM_BOX, halves=(_SIZE,) * 3, yaw=0.0)
        geom, body = self.geoms[index], self._bodies[index]
        self._model.geom_group[geom] = NOWHERE
        self._model.geom_contype[geom] = self._model.body_contype[body] = 0
        self._model.body_pos[body, 2] = _BELOW
        self._names[geom] = ""
        self.shown[index] = None

    def match(self, shown: Sequence[Obstacle | None]) -> None:
        """Show and hide what it takes."""
        for index, obstacle in enumerate(shown):
            if obstacle is not self.shown[index]:
                if obstacle is None:
                    self.hide(index)
                else:
                    self.show(index, obstacle)

    def _place(
        self, index: int, *, kind: mujoco.mjtGeom, halves: tuple[float, ...], yaw: float
    ) -> None:
        """Set all that MuJoCo keeps of a shape: for contacts, for rays and for pictures."""
        model, geom, body = self._model, self.geoms[index], self._bodies[index]
        length, width, height = halves
        cylinder = kind == mujoco.mjtGeom.mjGEOM_CYLINDER
        model.geom_type[geom] = kind
        model.geom_size[geom] = (length, height, 0.0) if cylinder else halves
        model.geom_rbound[geom] = math.hypot(length, 0.0 if cylinder else width, height)
        model.geom_aabb[geom] = (0.0, 0.0, 0.0, *halves)
        model.geom_quat[geom] = yaw_quaternion(yaw)
        model.geom_sameframe[geom] = mujoco.mjtSameFrame.mjSAMEFRAME_NONE
        cos, sin = abs(math.cos(yaw)), abs(math.sin(yaw))
        model.bvh_aabb[model.body_bvhadr[body]] = (
            *(0.0, 0.0, 0.0),
            *(cos * length + sin * width, sin * length + cos * width, height),
        )


def bodies_of(model: mujoco.MjModel) -> tuple[list[str], PropBodies]:
    """Return what the geoms of a model are reported as, and its spare bodies."""
    names = geom_names(model)
    return names, PropBodies(model, names)


def _share(total: float, count: int) -> float:
    """Return what `count` times is `total`, to the last bit where there is such a number."""
    share = total / count
    for candidate in (share, np.nextafter(share, 0.0), np.nextafter(share, math.inf)):
        if candidate * count == total:
            return float(candidate)
    return share
