"""The camera's topics: pictures are drawn only while somebody wants them, as they cost the most."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, Image

from bt_mission.core.robot.parts import CameraModel as CameraSpec
from bt_mission.core.ros_log import log_of
from sim.faults import NO_CAMERA_FAULTS
from sim.robot import frames
from sim.robot.robot import SimulatedRobot
from sim.ros import message_fields
from sim.ros.schedule import Schedule
from sim.ros.topics import RELIABLE
from sim.sensors.camera import Camera, RaycastCamera
from sim.sensors.canvas import NoCameraError
from sim.sensors.noise import PictureDistortion, PictureNoise


class CameraTopics:
    """The topics of one robot's camera. `stamp` is shared by all messages."""

    def __init__(
        self, node: Node, schedule: Schedule, stamp: Any, robot: SimulatedRobot, spec: CameraSpec
    ) -> None:
        self._node = node
        self._robot = robot
        self._spec = spec
        self._camera: Camera | RaycastCamera | None = None
        self._has_drawn = False
        noisy = robot.robot.sensors.camera.noise
        noise = PictureNoise(robot.seed, f"{robot.prefix}camera") if noisy else None
        message, info = message_fields.header(Image(), stamp, frames.CAMERA_FRAME), CameraInfo()
        pixels = message_fields.image_format(message, spec)
        message_fields.camera_info(message_fields.header(info, stamp, frames.CAMERA_FRAME), spec)
        images = node.create_publisher(Image, f"{robot.prefix}camera/image_raw", RELIABLE)
        infos = node.create_publisher(CameraInfo, f"{robot.prefix}camera/camera_info", RELIABLE)

        distortion = PictureDistortion(robot.seed, robot.prefix)

        def draw(index: int) -> None:
            self._camera = self._camera or self._open()
            self._camera.draw(robot.physics.data, pixels)
            if noise is not None:
                noise.add(pixels, index)
            if robot.faults.camera is not NO_CAMERA_FAULTS:
                distortion.apply(robot.faults.camera, pixels, index)
            self._has_drawn = True

        def publish(index: int) -> None:
            if index == 0:  # the start, or a reset
                self._has_drawn = False
            faults = robot.faults.camera
            if infos.get_subscription_count() and not faults.dead:
                infos.publish(info)
            if images.get_subscription_count() and not faults.dead:
                if not (faults.frozen and self._has_drawn):
                    draw(index)
                images.publish(message)

        schedule.every(spec.rate, "camera.rate", publish)

    def _open(self) -> Camera | RaycastCamera:
        model, prefix = self._robot.physics.model, self._robot.prefix
        try:
            return Camera(model, self._spec, prefix)
        except NoCameraError as error:
            log_of(self._node).warning(
                f"{error}; until then pictures are drawn ray by ray, more slowly"
            )
            return RaycastCamera(model, self._spec, prefix)

    def close(self) -> None:
        """Give back the renderer."""
        if self._camera is not None:
            self._camera.close()
            self._camera = None
