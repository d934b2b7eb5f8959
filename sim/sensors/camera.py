"""The robot's camera images; also on a machine without EGL."""

from __future__ import annotations

import array
import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import mujoco
import numpy as np
import numpy.typing as npt
from typing_extensions import override

from bt_mission.robots.model import CameraModel as CameraSpec
from bt_mission.robots.model import DepthCameraModel as DepthCameraSpec
from bt_mission.robots.model import RobotModel
from sim.faults import SensorFaults, within
from sim.frames import BASE_LINK, FramePose, Quaternion
from sim.physics.names import BASE, CAMERA, FLOOR, LOOKS, MARKS, ROBOT, SCREENS, SOLID
from sim.sensors import topics
from sim.sensors.canvas import Canvas, Image, NoCameraError
from sim.sensors.sensor import Mount, PictureNoise, Sensor

LINK = "camera_link"
FRAME = "camera_rgb_frame"
OPTICAL_FRAME = "camera_rgb_optical_frame"

# REP 103: z into the picture, x to its right, y down.
OPTICAL: Quaternion = (-0.5, 0.5, -0.5, 0.5)


class CameraFaults(SensorFaults):
    """A camera that shows something else, or nothing: neither pictures nor camera_info."""

    noise: Annotated[float, within(0, 1, "of full scale")] = 0.0
    """1 sigma for each channel of each pixel, as a share of full scale."""
    black: bool = False
    frozen: bool = False
    """It repeats its last picture, with fresh stamps."""


NO_CAMERA_FAULTS = CameraFaults()


class Camera:
    """Renders the images of the robot's camera: 8-bit RGB, `height` x `width` x 3, top row first.

    Raises NoCameraError without EGL.
    """

    def __init__(self, model: mujoco.MjModel, spec: CameraSpec, prefix: str = "") -> None:
        self._model = model
        own = model.geom_bodyid == model.body(prefix + BASE).id
        self._own_screen = np.flatnonzero(own & (model.geom_group == SCREENS))
        self._canvas = Canvas(model)
        options, view = self._canvas.options, self._canvas.view
        options.geomgroup[[LOOKS, ROBOT]] = 0  # a camera does not see its own robot
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
    """Renders the images of the robot's camera without EGL, with one ray for each pixel.

    It is slower than the renderer (about 15 ms for 320 x 240 pixels, against 2 ms) and without
    textures except the floor's tiles. Objects and colours are the same.
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


class PictureDistortion:
    """Changes a camera's pictures as its faults have it."""

    def __init__(self, seed: int, prefix: str) -> None:
        self._noise = PictureNoise(seed, f"{prefix}camera fault")

    def apply(self, faults: CameraFaults, pixels: npt.NDArray[np.uint8], index: int) -> None:
        """Change picture `index` in place."""
        if faults.black:
            pixels[:] = 0
        if faults.noise:
            self._noise.add(pixels, index, faults.noise)


class CameraInfoSensor(Sensor):
    """The calibration of a camera: a pinhole without distortion, square pixels."""

    name = "camera"
    topic = topics.CAMERA_INFO
    message = "sensor_msgs/msg/CameraInfo"
    frame = FRAME
    is_camera = True
    breaks: ClassVar[SensorFaults] = NO_CAMERA_FAULTS

    @classmethod
    @override
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        return []

    @override
    def constants(self) -> Mapping[str, Any]:
        spec = self.spec
        focal = spec.width / (2 * math.tan(spec.hfov / 2))
        cx, cy = spec.width / 2, spec.height / 2
        return {
            "width": spec.width,
            "height": spec.height,
            "distortion_model": "plumb_bob",
            "d": [0.0] * 5,
            "k": [focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0],
            "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
            "p": [focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        }


def image(spec: CameraSpec | DepthCameraSpec, encoding: str, pixel_bytes: int) -> Mapping[str, Any]:
    """Return the form of a camera's images, and room for their pixels."""
    row = pixel_bytes * spec.width
    return {
        "width": spec.width,
        "height": spec.height,
        "encoding": encoding,
        "step": row,
        "data": array.array("B", bytes(row * spec.height)),
    }


class CameraSensor(Sensor):
    """A robot's camera. Images are rendered only with a subscription: they cost the most."""

    name = "camera"
    topic = topics.CAMERA_IMAGE
    message = "sensor_msgs/msg/Image"
    frame = FRAME
    is_camera = True
    breaks = NO_CAMERA_FAULTS

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        prefix = mount.prefix
        self._camera: Camera | RaycastCamera | None = None
        noisy = mount.robot.sensors.camera.noise
        self._noise = PictureNoise(mount.seed, f"{prefix}camera") if noisy else None
        self._distortion = PictureDistortion(mount.seed, prefix)
        self.restart()

    @classmethod
    @override
    def frames(cls, robot: RobotModel) -> list[FramePose]:
        spec = cls.figures(robot)
        x, y, z = spec.link
        return [
            FramePose(BASE_LINK, LINK, spec.link),
            FramePose(LINK, FRAME, (spec.x - x, spec.y - y, spec.z - z)),
            FramePose(FRAME, OPTICAL_FRAME, (0.0, 0.0, 0.0), OPTICAL),
        ]

    @override
    def restart(self) -> None:
        self._has_drawn = False

    @override
    def constants(self) -> Mapping[str, Any]:
        return image(self.spec, "rgb8", 3)

    @override
    def fill(self, message: Any, index: int) -> bool:
        """Render into the message, in place; a frozen one keeps its image."""
        faults, spec = self.faults, self.spec
        if faults.frozen and self._has_drawn:
            return True
        self._camera = self._camera or self._open()
        pixels = np.frombuffer(message.data, np.uint8).reshape(spec.height, spec.width, 3)
        self._camera.draw(self.mount.physics.data, pixels)
        if self._noise is not None:
            self._noise.add(pixels, index)
        if faults is not NO_CAMERA_FAULTS:
            self._distortion.apply(faults, pixels, index)
        self._has_drawn = True
        return True

    @override
    def close(self) -> None:
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def _open(self) -> Camera | RaycastCamera:
        model, prefix = self.mount.physics.model, self.mount.prefix
        try:
            return Camera(model, self.spec, prefix)
        except NoCameraError as error:
            self.notice = f"{error}; until then pictures are drawn ray by ray, more slowly"
            return RaycastCamera(model, self.spec, prefix)
