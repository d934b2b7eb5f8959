"""What people see of a simulation: its world from above, and what lies ahead of a robot.

    views = WorldViews(robot, above=(720, 720), ahead=(560, 420))
    ...                                     # while it runs, as often as wanted:
    views.look()
    picture = views.still.copy()
    for patch in views.moving():
        patch.paint(picture)

What is drawn is a record, on a model and a state of the views' own: the simulation does not notice.
"""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from sim.physics.history import ModelCopy, SimulationState, pose_of
from sim.physics.names import BASE, CAMERA, LOOKS, ROBOT
from sim.robot.robot import SimulatedRobot
from sim.sensors.canvas import Canvas, Image
from sim.sensors.lidar import Lidar, spec_angles
from sim.views.overview import Overview, OverviewPatch

_FOVY = 45.0
"""Degrees, of the view from behind."""


class WorldViews:
    """Images of a robot in its world; `above` and `ahead` are widths and heights in pixels.

    Raises NoCameraError without EGL.
    """

    def __init__(
        self, robot: SimulatedRobot, *, above: tuple[int, int], ahead: tuple[int, int]
    ) -> None:
        self._simulated = robot
        self._copy = ModelCopy(robot.physics.model)
        self._model = model = self._copy.model
        self._data = self._copy.data
        self._robot = robot.robot
        self._q = int(model.joint(robot.prefix + BASE).qposadr[0])
        self._lidar = Lidar(model, robot.robot, robot.seed, robot.prefix)
        self._measured = 0
        model.light_castshadow[:] = True
        self.look()
        self._overview = Overview(model, self._data, robot.physics.world, *above)
        self.still: Image = self._overview.still
        """The world from above, without anything that can move."""
        self.scale = self._overview.scale
        """Pixels per metre, from above."""
        self._ahead: Image = np.empty((ahead[1], ahead[0], 3), dtype=np.uint8)
        model.vis.quality.offsamples = 0
        model.vis.global_.offwidth, model.vis.global_.offheight = ahead
        self._canvas = self._canvas_ahead()

    def look(self) -> None:
        """Have the next pictures be those of the present instant."""
        self.show(self._simulated.record())

    def show(self, state: SimulationState) -> None:
        """Have the next pictures be those of a recorded state."""
        self._copy.show(state)
        mujoco.mj_camlight(self._model, self._data)

    @property
    def pose(self) -> tuple[float, float, float]:
        """Pose of `base_footprint` in the map: x m, y m, yaw rad."""
        return pose_of(self._data.qpos[self._q :])

    def pixel(self, x: Any, y: Any) -> tuple[Any, Any]:
        """Return the pixels of points of the map from above: from the left and from the top."""
        return self._overview.pixel(x, y)

    def moving(self) -> list[OverviewPatch]:
        """Return what can move, from above."""
        return self._overview.moving()

    def ahead(self) -> Image:
        """Return the image of the robot's camera; without one, the robot from behind."""
        if self._robot.camera is None:
            x, y, yaw = self.pose
            view = self._canvas.view
            view.azimuth = math.degrees(yaw)
            view.lookat[:] = x, y, 0.1
            self._model.vis.global_.fovy = _FOVY
        self._canvas.draw(self._data, self._ahead)
        return self._ahead

    def seen(self) -> npt.NDArray[np.float64]:
        """Return where the lidar's rays end, in the map: n x 2, m."""
        ranges = self._lidar.measure(self._data, self._measured)
        self._measured += 1
        x, y, yaw = self.pose
        spec = self._robot.lidar
        x += spec.x * math.cos(yaw) - spec.y * math.sin(yaw)
        y += spec.x * math.sin(yaw) + spec.y * math.cos(yaw)
        first, step = spec_angles(spec, len(ranges))
        bearings = yaw + math.radians(spec.yaw) + first + step * np.arange(len(ranges))
        points = np.stack([x + ranges * np.cos(bearings), y + ranges * np.sin(bearings)], axis=1)
        points_seen: npt.NDArray[np.float64] = points[np.isfinite(ranges) & (ranges > 0)]
        return points_seen

    def close(self) -> None:
        """Give the renderers back. Nothing can be drawn afterwards."""
        self._overview.close()
        self._canvas.close()

    def _canvas_ahead(self) -> Canvas:
        canvas = Canvas(self._model)
        if self._robot.camera is not None:
            canvas.options.geomgroup[[LOOKS, ROBOT]] = 0  # a camera does not see its own robot
            canvas.view.type = mujoco.mjtCamera.mjCAMERA_FIXED
            canvas.view.fixedcamid = self._model.camera(self._simulated.prefix + CAMERA).id
        else:
            canvas.view.type = mujoco.mjtCamera.mjCAMERA_FREE
            canvas.view.elevation, canvas.view.distance = -35.0, 1.1
        return canvas
