"""The robot's camera: what it sees, as a picture."""

from __future__ import annotations

import mujoco
import numpy as np

from bt_mission.core.robot.parts import CameraModel as CameraSpec
from sim.physics.names import BASE, CAMERA, LOOKS, ROBOT, SCREENS
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
