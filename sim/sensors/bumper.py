"""Bumpers: contacts with a part of the hull."""

from __future__ import annotations

from typing import Any

import numpy as np
from typing_extensions import override

from sim.physics.contacts import Contacts
from sim.physics.names import BASE
from sim.sensors import topics
from sim.sensors.lidar import sector
from sim.sensors.sensor import Mount, Sensor


class BumperSensor(Sensor):
    """Whether a part of the hull touches anything but the floor.

    It is published at its rate: silence means that it has failed.
    """

    name = "bumper"
    table = "bumpers"
    topic = topics.BUMPER
    message = "std_msgs/msg/Bool"
    is_latched = True

    def __init__(self, mount: Mount) -> None:
        super().__init__(mount)
        physics = mount.physics
        self._contacts = Contacts(physics.model, physics.names, mount.prefix)
        self._base = physics.model.body(mount.prefix + BASE).id

    @override
    def fill(self, message: Any, index: int) -> bool:
        """Write whether it is pressed."""
        message.data = self.is_pressed()
        return True

    def is_pressed(self) -> bool:
        """Return whether a contact is in its sector."""
        if not self.mount.physics.is_touching:
            return False
        data = self.mount.physics.data
        places = self._contacts.places(data) - data.xpos[self._base, :2]
        forward, left = (places @ data.xmat[self._base].reshape(3, 3)[:2, :2]).T
        x, y, _ = self.mount.robot.body.centre
        bearings = np.degrees(np.arctan2(left - y, forward - x))
        return bool(sector(bearings, *self.spec.sector).any())
