"""The extent of single geoms of a compiled MuJoCo model."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

_DIRECTIONS = 64


def radius_of(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, centre: Floats, axis: Floats
) -> float:
    """Return how far a geom reaches from an axis through `centre`, m: the radius of a wheel."""
    aside = np.cross(axis, (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0))
    aside /= np.linalg.norm(aside)
    upwards = np.cross(axis, aside)
    at = data.geom_xpos[geom] - centre
    angles = np.arange(_DIRECTIONS) * math.tau / _DIRECTIONS
    return max(
        float(way @ at) + reach(model, data, geom, way)
        for way in np.outer(np.cos(angles), aside) + np.outer(np.sin(angles), upwards)
    )


def reach(model: mujoco.MjModel, data: mujoco.MjData, geom: int, direction: Floats) -> float:
    """Return how far a geom reaches from its middle in a direction of the world, m."""
    x, y, z = way = data.geom_xmat[geom].reshape(3, 3).T @ direction
    size = model.geom_size[geom]
    kind, kinds = int(model.geom_type[geom]), mujoco.mjtGeom
    if kind == kinds.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first = int(model.mesh_vertadr[mesh])
        vertices = model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])]
        return float((vertices @ way).max())
    if kind == kinds.mjGEOM_BOX:
        return float(size @ np.abs(way))
    if kind == kinds.mjGEOM_ELLIPSOID:
        return float(np.linalg.norm(size * way))
    if kind == kinds.mjGEOM_CYLINDER:
        return float(size[0] * math.hypot(x, y) + size[1] * abs(z))
    return float(size[0] + (size[1] * abs(z) if kind == kinds.mjGEOM_CAPSULE else 0.0))
