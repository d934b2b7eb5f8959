"""The robot's camera: what it sees, as a picture; also on a machine without EGL."""

from __future__ import annotations

import math

import mujoco
import numpy as np
import numpy.typing as npt

from bt_mission.core.robot.parts import CameraModel as CameraSpec
from sim.physics.names import BASE, CAMERA, FLOOR, LOOKS, MARKS, ROBOT, SCREENS, SOLID
from sim.sensors.canvas import Canvas, Image


class Camera:
    """Draws what the robot's camera sees: 8-bit RGB, `height` x `width` x 3, top row first.

    Raises NoCameraError where there is no EGL.
    """

    def __init__(self, model: mujoco.MjModel, spec: CameraSpec, prefix: str = "") -> None:
        self._model = model
        own = model.geom_bodyid == model.body(prefix + BASE).id
        self._own_screen = np.flatnonzero(own & (model.geom_group == SCREENS))
        self._canvas = Canvas(model)
        options, view = self._canvas.options, self._canvas.view
        options.geomgroup[[LOOKS, ROBOT]] = 0  # a camera does not see what carries it
        options.geomgroup[SCREENS] = 1
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = model.camera(prefix + CAMERA).id
        self._pixels = np.empty((spec.height, spec.width, 3), dtype=np.uint8)

    def draw(self, data: mujoco.MjData, out: Image) -> None:
        """Draw into `out`; positions in `data` must be current."""
        self._model.geom_group[self._own_screen] = ROBOT
        self._canvas.draw(data, self._pixels)
        self._model.geom_group[self._own_screen] = SCREENS
        out[:] = self._pixels

    def close(self) -> None:
        """Give the renderer back. Nothing can be drawn afterwards."""
        self._canvas.close()


Floats = npt.NDArray[np.float64]

SKY_TOP = np.array([0.62, 0.76, 0.90])
SKY_HORIZON = np.array([0.85, 0.90, 0.95])
TILES = np.array([[0.52, 0.55, 0.58], [0.59, 0.62, 0.65]])
TILE = 0.5
"""Edge of a tile of the floor, m."""

AMBIENT = 0.65
"""Share of the light that comes from everywhere; the rest comes from the camera."""


class RaycastCamera:
    """Draws what the robot's camera sees without EGL: one ray for each pixel, and a plain light.

    Slower than the renderer (about 15 ms for 320 x 240 pixels, against 2 ms) and without textures
    but the floor's tiles. What stands where, and in which colour, is the same.
    """

    def __init__(self, model: mujoco.MjModel, spec: CameraSpec, prefix: str = "") -> None:
        self._model = model
        self._base = model.body(prefix + BASE).id
        self._camera = model.camera(prefix + CAMERA).id
        self._floor = model.geom(FLOOR).id
        half_height = math.tan(math.radians(float(model.cam_fovy[self._camera])) / 2)
        pixel = 2 * half_height / spec.height
        columns = (np.arange(spec.width) + 0.5 - spec.width / 2) * pixel
        rows = (spec.height / 2 - np.arange(spec.height) - 0.5) * pixel
        across, up = np.meshgrid(columns, rows)
        rays = np.stack((across, up, -np.ones_like(across)), axis=-1).reshape(-1, 3)
        self._rays: Floats = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        count = len(self._rays)
        self._vectors = np.empty_like(self._rays)
        self._flat = self._vectors.reshape(-1)
        self._hit = np.empty(count, dtype=np.int32)
        self._distances = np.empty(count)
        self._normals = np.empty(3 * count)
        self._groups = np.zeros(mujoco.mjNGROUP, dtype=np.uint8)
        self._groups[[SOLID, MARKS, SCREENS]] = 1

    def draw(self, data: mujoco.MjData, out: Image) -> None:
        """Draw into `out`; positions in `data` must be current."""
        place = data.cam_xpos[self._camera]
        rotation = data.cam_xmat[self._camera].reshape(3, 3)
        np.matmul(self._rays, rotation.T, out=self._vectors)
        mujoco.mj_multiRay(
            self._model,
            data,
            place,
            self._flat,
            self._groups,
            1,  # static geoms too
            self._base,  # not its own screen; its other geoms are in groups left out
            self._hit,
            self._distances,
            self._normals,
            len(self._hit),
            mujoco.mjMAXVAL,
        )
        colours = self._model.geom_rgba[self._hit, :3]
        floor = self._hit == self._floor
        points = place[:2] + self._vectors[floor, :2] * self._distances[floor, None]
        tiles = np.floor(points / TILE).astype(np.int64).sum(axis=1) % 2
        colours[floor] = TILES[tiles]
        lit = np.abs(np.einsum("ij,ij->i", self._normals.reshape(-1, 3), self._vectors))
        lit[floor] = 1.0  # seen from above, whatever the angle
        colours *= (AMBIENT + (1 - AMBIENT) * lit)[:, None]
        missed = self._hit < 0
        height = np.clip(self._vectors[missed, 2:3] * 2, 0.0, 1.0)
        colours[missed] = SKY_HORIZON + (SKY_TOP - SKY_HORIZON) * height
        out[:] = np.round(255 * colours).astype(np.uint8).reshape(out.shape)

    def close(self) -> None:
        """Nothing to give back."""
