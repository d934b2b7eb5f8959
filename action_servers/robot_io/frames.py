"""The poses of frames on the map, from the transforms of ROS."""

from __future__ import annotations

from collections import deque
from typing import Any

from action_servers.core.maneuver import Refusal
from action_servers.robot_io.messages import planar_pose, transform_of
from bt_mission.base.geometry import Pose2D, composed
from bt_mission.cdr.decoder import DecodingError, decoder_of
from bt_mission.cdr.picker import Picker, Texts

KEPT = 100
"""The number of kept messages of moving frames: one or two seconds of a TurtleBot3's."""

_LEAST_UPRIGHT = 0.99
"""Cosine of the tilt up to which a frame counts as level, 8 degrees."""

_TRANSFORMS = "tf2_msgs/msg/TFMessage"


class Frames:
    """Finds a frame's pose on the map, as of now, from messages of `tf` and `tf_static`.

    Messages are kept as they arrive, and decoded only for a request.
    """

    def __init__(self, map_frame: str) -> None:
        self._map_frame = map_frame
        self.fixed: deque[bytes] = deque(maxlen=KEPT)
        """Serialized messages of `tf_static`."""
        self.moving: deque[bytes] = deque(maxlen=KEPT)
        """Serialized messages of `tf`."""

    def on_map(self, frame: str) -> Pose2D | Refusal:
        """Return the place of a frame on the map, or why it is not known."""
        links = self._links()
        pose, at = Pose2D(0.0, 0.0, 0.0), frame
        for _ in range(len(links) + 1):
            if at == self._map_frame:
                return pose
            if at not in links:
                break
            parent, transform = links[at]
            placed = transform_of(transform)
            if placed is None:
                return Refusal(f"the transform from '{parent}' to '{at}' holds no finite numbers")
            if _upright(transform.rotation) < _LEAST_UPRIGHT:
                return Refusal(f"the frame '{frame}' is tilted, at the transform to '{at}'")
            pose, at = composed(placed, pose), parent
        known = ", ".join(sorted({self._map_frame, *links})) or "none"
        return Refusal(
            f"the frame '{frame}' has no transform to '{self._map_frame}' (known frames: {known})"
        )

    def _links(self) -> dict[str, tuple[str, Any]]:
        """Return parent and transform of each frame, the newest of each."""
        return {
            stamped.child_frame_id: (stamped.header.frame_id, stamped.transform)
            for data in (*self.fixed, *self.moving)
            for stamped in transforms_of(data)
        }


class PlaceOnMap:
    """The pose of one frame on the map, from messages that contain it directly."""

    def __init__(self, map_frame: str) -> None:
        self._map_frame = map_frame
        self._frame = ""
        self._picker = Picker(decoder_of(_TRANSFORMS), self._newest)

    def place(self, data: bytes, frame: str) -> Pose2D | None:
        """Return the frame's pose in a serialized message of `tf`.

        None if the message lacks it, is of another type, or contains numbers that are not finite.
        """
        if frame != self._frame:
            self._frame = frame
            self._picker = Picker(decoder_of(_TRANSFORMS), self._newest)
        try:
            numbers = self._picker.pick(data).numbers
        except DecodingError:
            return None
        return planar_pose(*numbers) if numbers else None

    def _newest(self, texts: Texts) -> list[str]:
        """Return the paths of the last transform from the map to the frame, if there is one."""
        paths: list[str] = []
        for path, text in texts.items():
            transform = path.removesuffix(".child_frame_id")
            if transform == path or text != self._frame:
                continue
            if texts[f"{transform}.header.frame_id"] == self._map_frame:
                paths = [
                    *(f"{transform}.transform.translation.{axis}" for axis in "xy"),
                    *(f"{transform}.transform.rotation.{axis}" for axis in "xyzw"),
                ]
        return paths


def transforms_of(data: bytes) -> list[Any]:
    """Return the transforms of a serialized message; none where it is of another type."""
    try:
        return list(decoder_of(_TRANSFORMS).decode(data).transforms)
    except DecodingError:
        return []


def _upright(rotation: Any) -> float:
    """Return the cosine of the angle between a frame's z axis and its parent's."""
    return float(1.0 - 2.0 * (rotation.x**2 + rotation.y**2))
