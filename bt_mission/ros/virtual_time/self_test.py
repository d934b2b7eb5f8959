"""The proof that "nothing ready" is the truth on this machine and with this middleware."""

from __future__ import annotations

from functools import cache

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.task import Future
from rclpy.utilities import get_rmw_implementation_identifier
from std_msgs.msg import String
from std_srvs.srv import Trigger

from bt_mission.base.errors import BtMissionError
from bt_mission.ros.virtual_time.executor import VirtualTimeExecutor

ROUNDS = 25


class NoVirtualTimeError(BtMissionError):
    """Messages within this process arrive late, so virtual time cannot be trusted."""

    code = "BT-902"


@cache
def self_test() -> None:
    """Send messages and service calls within this process; each must arrive at once.

    A process runs the test once.

    Raises:
        NoVirtualTimeError: A message is late or lost.
    """
    context = Context()
    rclpy.init(context=context)
    try:
        _exchange(context)
    finally:
        context.shutdown()


def _exchange(context: Context) -> None:
    names = {"reliable": QoSProfile(depth=10)}
    names["best_effort"] = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    names["latched"] = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    sender, receiver = (
        Node(name, context=context, enable_rosout=False, start_parameter_services=False)
        for name in ("lockstep_test_sender", "lockstep_test_receiver")
    )
    executor = VirtualTimeExecutor(context=context)
    executor.add_node(sender)
    executor.add_node(receiver)
    got: list[str] = []
    publishers = []
    for name, qos in names.items():
        receiver.create_subscription(
            String, f"lockstep_test/{name}", lambda m: got.append(m.data), qos
        )
        publishers.append(sender.create_publisher(String, f"lockstep_test/{name}", qos))

    def answer(_: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = True
        return response

    receiver.create_service(Trigger, "lockstep_test/call", answer)
    client = sender.create_client(Trigger, "lockstep_test/call")
    executor.run_until_quiet()
    late = 0
    for number in range(ROUNDS):
        for publisher in publishers:
            publisher.publish(String(data=str(number)))
        call: Future = client.call_async(Trigger.Request())
        executor.run_until_quiet()
        late += got.count(str(number)) != len(publishers)
        late += not call.done()
    for node in (sender, receiver):
        executor.remove_node(node)
        node.destroy_node()
    executor.shutdown()
    if late:
        raise NoVirtualTimeError(
            f"{late} of {2 * ROUNDS} exchanges within this process were late with "
            f"{get_rmw_implementation_identifier()}; virtual time needs synchronous delivery: "
            "set RMW_IMPLEMENTATION=rmw_fastrtps_cpp and unset FASTRTPS_DEFAULT_PROFILES_FILE"
        )
