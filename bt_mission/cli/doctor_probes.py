"""What `bt-mission doctor` tries, each in a process of its own that a crash may end.

`python -m bt_mission.cli.doctor_probes NAME [ARGUMENT]` prints what it found and exits with 0, or
says on standard error why it could not, in the last line. Everything is imported inside the probes:
on a machine where something is missing, the others still run.
"""

from __future__ import annotations

import importlib
import importlib.metadata
import os
import sys
from collections.abc import Callable
from pathlib import Path

ANSWER_LIMIT_S = 15.0
"""How long one process listens for another, in seconds of the wall clock."""

LOOK_S = 4.0
"""How long it looks around: Fast DDS announces each participant every 3 s."""

TYPES = (
    "bt_mission_interfaces.action.CameraSweep",
    "bt_mission_interfaces.action.ExploreForward",
    "bt_mission_interfaces.action.Turn",
    "bt_mission_interfaces.msg.Collision",
    "nav2_msgs.action.FollowWaypoints",
    "nav2_msgs.action.NavigateThroughPoses",
    "nav2_msgs.action.NavigateToPose",
    "tf2_msgs.msg.TFMessage",
)


def ros() -> str:
    """Which ROS this Python finds: the wheels in its environment, or an installed one."""
    import rclpy

    place = Path(rclpy.__file__).resolve()
    if place.is_relative_to(Path(sys.prefix).resolve()):
        return f"Jazzy wheels, rclpy {importlib.metadata.version('ros-rclpy')}"
    return (
        f"{os.environ.get('ROS_DISTRO', 'unknown distribution')}, installed in {place.parents[4]}"
    )


def rmw() -> str:
    """Which middleware rclpy loads."""
    import rclpy

    return str(rclpy.get_rmw_implementation_identifier())


def types() -> str:
    """Loads the C libraries behind every type that is not part of the ROS wheels."""
    from rclpy.type_support import check_for_type_support

    for name in TYPES:
        module, _, member = name.rpartition(".")
        check_for_type_support(getattr(importlib.import_module(module), member))
    return f"{len(TYPES)} types load"


def plugins() -> str:
    """Imports the actions of other packages; the first that cannot be used fails."""
    from bt_mission.language.action_names import BROKEN, plugged

    usable = plugged()
    if BROKEN:
        name, why = next(iter(BROKEN.items()))
        sys.exit(f"{name}: {why}")
    return f"{len(usable)} actions of other packages"


def render() -> str:
    """Renders one small image off-screen."""
    os.environ["MUJOCO_GL"] = "egl"
    import mujoco

    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><light pos='0 0 2'/><geom size='.3'/></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    renderer = mujoco.Renderer(model, height=48, width=64)
    renderer.update_scene(data)
    image = renderer.render()
    renderer.close()
    if not image.any():
        raise RuntimeError("the image is black")
    return "an off-screen image is rendered"


def talk(topic: str) -> str:
    """Says "hello" on a topic ten times a second, until ended or the limit has passed twice."""
    import rclpy
    from std_msgs.msg import String

    rclpy.init()
    node = rclpy.create_node("bt_mission_doctor_talker")
    publisher = node.create_publisher(String, topic, 10)
    node.create_timer(0.1, lambda: publisher.publish(String(data="hello")))
    rclpy.spin_until_future_complete(node, rclpy.Future(), timeout_sec=2 * ANSWER_LIMIT_S)
    node.destroy_node()
    rclpy.shutdown()
    return "said hello"


def listen(topic: str) -> str:
    """Waits for the first word on a topic."""
    import rclpy
    from std_msgs.msg import String

    rclpy.init()
    node = rclpy.create_node("bt_mission_doctor_listener")
    received = rclpy.Future()
    node.create_subscription(String, topic, received.set_result, 10)
    rclpy.spin_until_future_complete(node, received, timeout_sec=ANSWER_LIMIT_S)
    node.destroy_node()
    rclpy.shutdown()
    if not received.done():
        raise TimeoutError(f"no message from another process within {ANSWER_LIMIT_S:.0f} s")
    return "two processes communicate"


def types_agree() -> str:
    """Looks for topics of the running graph whose publishers and subscribers differ in type."""
    import rclpy

    from bt_mission.base.dds.endpoints import type_conflict

    rclpy.init()
    node = rclpy.create_node("_bt_mission_doctor_types")
    rclpy.spin_until_future_complete(node, rclpy.Future(), timeout_sec=LOOK_S)
    topics = [name for name, _ in node.get_topic_names_and_types()]
    conflict_texts = [
        type_conflict(
            topic,
            node.get_publishers_info_by_topic(topic),
            node.get_subscriptions_info_by_topic(topic),
        )
        for topic in topics
    ]
    node.destroy_node()
    rclpy.shutdown()
    conflicts = [text for text in conflict_texts if text is not None]
    if conflicts:
        raise SystemExit("; ".join(conflicts))
    return f"agree on all {len(topics)} topics of the running graph"


def lockstep() -> str:
    """Proves that virtual time can be trusted with this middleware on this machine."""
    from bt_mission.ros.virtual_time import self_test

    self_test()
    return "messages arrive before time advances"


PROBES: dict[str, Callable[..., str]] = {
    probe.__name__: probe
    for probe in (ros, rmw, types, plugins, render, talk, listen, types_agree, lockstep)
}

if __name__ == "__main__":
    print(PROBES[sys.argv[1]](*sys.argv[2:]))
