"""Facts about waiting for one picture."""

from __future__ import annotations

import numpy as np

from action_servers.camera.camera import Snapshot
from action_servers.core.error_codes import ErrorCode
from action_servers.core.maneuver import Finished, Image, Observation


class Switch:
    """Notes what was asked of the camera."""

    def __init__(self):
        self.calls = []

    def on(self):
        self.calls.append("on")

    def off(self):
        self.calls.append("off")


def at(time_s, image=None):
    """An observation."""
    return Observation(time_s, image=image)


def picture(stamp_s):
    """A picture of one pixel."""
    return Image(stamp_s, 1, 1, np.zeros((1, 1, 3), dtype=np.uint8))


def test_a_picture_counts_once_and_only_if_taken_after_it_was_asked_for():
    """The camera is on meanwhile."""
    switch = Switch()
    snapshot = Snapshot(switch, 2.0)
    old, new = picture(9.9), picture(10.0)
    assert snapshot.take(at(10.0, new)) is None
    snapshot.ask(at(10.0))
    assert snapshot.is_asked_for
    assert snapshot.take(at(10.1, old)) is None
    assert snapshot.take(at(10.2, new)) is new
    assert (snapshot.is_asked_for, switch.calls) == (False, ["on", "off"])
    snapshot.ask(at(10.0))
    assert snapshot.take(at(10.3, new)) is None


def test_patience_ends():
    """With a code and a reason."""
    snapshot = Snapshot(Switch(), 2.0)
    snapshot.ask(at(10.0))
    assert snapshot.take(at(11.95)) is None
    assert snapshot.take(at(12.0)) == Finished(
        "aborted", ErrorCode.NO_IMAGE, "no image from the camera within 2 s"
    )
