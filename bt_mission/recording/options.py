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
    """

    camera: Camera = "none"
