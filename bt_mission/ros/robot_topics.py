"""A robot and its surroundings, as a viewer's node receives them.

Subscriptions are with best effort and short queues, so that a slow viewer costs nothing elsewhere.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import Any

from nav_msgs.msg import OccupancyGrid
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription
from sensor_msgs.msg import BatteryState, Image, LaserScan
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from bt_mission.executive.events import messages, reader
from bt_mission.ros.graph import LATCHED

NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
FRAMES = QoSProfile(depth=20, reliability=ReliabilityPolicy.BEST_EFFORT)
STATIC_FRAMES = QoSProfile(depth=20, durability=DurabilityPolicy.TRANSIENT_LOCAL)

READINGS: dict[str, tuple[Any, Callable[[Any], messages.Robot]]] = {
    "scan": (LaserScan, reader.scan),
    "battery_state": (BatteryState, reader.battery),
}
"""The topics of a robot with many messages a second, apart from its frames."""

SURROUNDINGS: dict[str, tuple[Any, Callable[[Any], messages.Robot]]] = {
    "map": (OccupancyGrid, reader.grid),
    "zones": (MarkerArray, reader.zones),
}
"""Topics on the robot's surroundings, which are published once."""


class RobotTopics:
    """The messages of one robot since the last look: its frames, of all else the newest one.

    Args:
        node: Owns the subscriptions. An executor may serve it; :meth:`take` also works without one.
        namespace: That of the robot; its map, zones and camera are there.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        self._node, self._namespace = node, namespace
        self._newest: dict[str, tuple[Callable[[Any], messages.Robot], Any]] = {}
        self._frames: deque[Any] = deque(maxlen=100)
        self._image: Any = None
        self._surroundings = [
            *(
                self._subscribe(
                    kind, f"{namespace}/{name}", partial(self._keep, name, read), LATCHED
                )
                for name, (kind, read) in SURROUNDINGS.items()
            ),
            self._subscribe(TFMessage, f"{namespace}/tf_static", self._keep_frames, STATIC_FRAMES),
        ]
        self._readings: list[Subscription] = []
        self._prefix: str | None = None
        self._camera: Subscription | None = None

    def follow(self, prefix: str) -> None:
        """Receive the robot itself: its scan, battery and frames, from topics with this prefix."""
        if prefix == self._prefix:
            return
        self._prefix = prefix
        self._destroy(self._readings)
        self._readings = [
            *(
                self._subscribe(kind, f"{prefix}/{name}", partial(self._keep, name, read), NEWEST)
                for name, (kind, read) in READINGS.items()
            ),
            self._subscribe(TFMessage, f"{prefix}/tf", self._keep_frames, FRAMES),
        ]

    def watch_camera(self, *, is_on: bool) -> None:
        """Receive the images of the camera, or no longer."""
        if is_on and self._camera is None:
            topic = f"{self._namespace}/camera/image_raw"
            self._camera = self._subscribe(Image, topic, self._keep_image, NEWEST)
        elif not is_on and self._camera is not None:
            self._destroy([self._camera])
            self._camera = self._image = None

    def take(self) -> tuple[tuple[messages.Robot, ...], messages.CameraImage | None]:
        """Return what was received since the last call, and the newest image."""
        cameras = [] if self._camera is None else [self._camera]
        for subscription in (*self._surroundings, *self._readings, *cameras):
            with (handle := subscription.handle):
                while (taken := handle.take_message(subscription.msg_type, False)) is not None:
                    subscription.callback(taken[0])
        readings: list[messages.Robot] = [reader.transforms(frame) for frame in self._frames]
        readings += [read(message) for read, message in self._newest.values()]
        image = None if self._image is None else reader.image(self._image)
        self._frames.clear()
        self._newest.clear()
        self._image = None
        return tuple(readings), image

    def close(self) -> None:
        """Destroy the subscriptions."""
        self.watch_camera(is_on=False)
        self._destroy([*self._surroundings, *self._readings])

    # ---- inside: callbacks only keep messages, so that none of them can raise ----------------

    def _subscribe(
        self, kind: Any, topic: str, keep: Callable[[Any], Any], qos: QoSProfile
    ) -> Subscription:
        events = SubscriptionEventCallbacks(use_default_callbacks=False)
        return self._node.create_subscription(kind, topic, keep, qos, event_callbacks=events)

    def _destroy(self, subscriptions: list[Subscription]) -> None:
        for subscription in subscriptions:
            self._node.destroy_subscription(subscription)

    def _keep(self, name: str, read: Callable[[Any], messages.Robot], message: Any) -> None:
        self._newest[name] = (read, message)

    def _keep_frames(self, message: Any) -> None:
        self._frames.append(message)

    def _keep_image(self, message: Any) -> None:
        self._image = message
