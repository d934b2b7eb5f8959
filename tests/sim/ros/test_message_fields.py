"""Readings in messages: every field that is filled, on plain stand-ins for the messages."""

import math
from types import SimpleNamespace

import pytest

from sim.frames import FramePose
from sim.physics.contacts import Collision
from sim.ros import message_fields


class Message(SimpleNamespace):
    """Takes any field; an unknown one is another message."""

    def __getattr__(self, name: str) -> "Message":
        if name.startswith("__"):
            raise AttributeError(name)
        inner = Message()
        setattr(self, name, inner)
        return inner


def test_header_shares_the_stamp():
    """One stamp, changed once, dates all messages."""
    stamp, message = Message(), Message()
    assert message_fields.header(message, stamp, "odom", "base_footprint") is message
    assert message.header.stamp is stamp
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_footprint")


def test_fixed_transform():
    """Parent, child, place and rotation."""
    frame = FramePose("base_link", "base_scan", (-0.064, 0.0, 0.122))
    message = message_fields.transform(Message(), frame, Message())
    at = message.transform
    assert (message.header.frame_id, message.child_frame_id) == ("base_link", "base_scan")
    assert (at.translation.x, at.translation.y, at.translation.z) == (-0.064, 0.0, 0.122)
    assert (at.rotation.x, at.rotation.y, at.rotation.z, at.rotation.w) == (0, 0, 0, 1)


def test_a_place_on_the_floor():
    """Yaw as a turn about z."""
    x, y, z, w = message_fields.planar(1.0, 2.0, math.pi / 2)
    assert (x, y) == (1, 2)
    assert (z, w) == pytest.approx((math.sqrt(0.5),) * 2)


def test_collision_has_the_time_of_its_onset():
    """In the map frame, with name, place and force."""
    message = Message()
    message_fields.collision(message, Collision(2_500_000_000, "pillar", (1.0, 2.0, 0.1), 7.5))
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (2, 500_000_000)
    assert (message.header.frame_id, message.obstacle, message.force) == ("map", "pillar", 7.5)
    assert (message.point.x, message.point.y, message.point.z) == (1, 2, 0.1)
