"""The topics of a robot's sensors, as they declare them."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from operator import attrgetter
from typing import Any

from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.serialization import serialize_message

from bt_mission.base.ros_log import log_of
from bt_mission.cdr.writer import MessageTemplate
from sim.robot.robot import SimulatedRobot
from sim.ros.schedule import Schedule
from sim.sensors.sensor import Sensor

RELIABLE = QoSProfile(depth=10)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SENSOR_DATA = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def publish_sensor(
    node: Node, schedule: Schedule, stamp: Any, robot: SimulatedRobot, sensor: Sensor
) -> None:
    """Publish a sensor's measurements, at its rate and while somebody subscribes, or latched.

    The message is made once, and gets new numbers for each measurement. `stamp` is shared.
    """
    message = empty_message(sensor, stamp)
    qos = LATCHED if sensor.is_latched else RELIABLE if sensor.is_reliable else SENSOR_DATA
    publisher = node.create_publisher(type(message), robot.prefix + sensor.topic, qos)
    make = _packed if sensor.fields else _filled
    schedule.every(
        sensor.rate, f"{sensor.name}.rate", make(node, publisher, sensor, message, stamp)
    )


def message_type(sensor: Sensor | type[Sensor]) -> Any:
    """Return the class of a sensor's messages."""
    package, folder, name = sensor.message.split("/")
    return getattr(import_module(f"{package}.{folder}"), name)


def empty_message(sensor: Sensor, stamp: Any) -> Any:
    """Return a message of a sensor with all that never changes."""
    message = message_type(sensor)()
    if hasattr(message, "header"):
        message.header.stamp, message.header.frame_id = stamp, sensor.frame
    for name, value in sensor.constants().items():
        path, _, last = name.rpartition(".")
        setattr(attrgetter(path)(message) if path else message, last, value)
    return message


def _packed(
    _: Node, publisher: Publisher, sensor: Sensor, message: Any, stamp: Any
) -> Callable[[int], None]:
    packed = MessageTemplate(message, stamp, [(message, sensor.fields)], serialize_message).packed
    parts, name = sensor.mount.faults.now, sensor.name

    def publish(index: int) -> None:
        if publisher.get_subscription_count() and not parts[name].dead:
            publisher.publish(packed(*sensor.numbers(index)))

    return publish


def _filled(
    node: Node, publisher: Publisher, sensor: Sensor, message: Any, _: Any
) -> Callable[[int], None]:
    parts, name = sensor.mount.faults.now, sensor.name

    def publish(index: int) -> None:
        is_wanted = sensor.is_latched or publisher.get_subscription_count()
        if is_wanted and not parts[name].dead and sensor.fill(message, index):
            if sensor.notice:
                log_of(node).warning(sensor.notice)
                sensor.notice = ""
            publisher.publish(message)

    return publish
