"""What is recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Camera = Literal["none", "compressed", "raw"]


@dataclass(frozen=True)
class RecordingOptions:
    """What to record besides everything that is always recorded.

    Args:
        camera: Pictures: none, each as a JPEG, or as they are. A simulated camera draws only while
            somebody wants its pictures, so with them a run takes far longer.
        raw_actions: Keep the type names that rosidl makes of actions and services, such as
            ``Turn_FeedbackMessage`` and ``CancelGoal_Event``. The messages are the same;
            mcap-ros2-support and rosbags refuse such names.
    """

    camera: Camera = "none"
    raw_actions: bool = False
