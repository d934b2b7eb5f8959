"""The simulator in AMCL's place, for programs that wait for it."""

import math

import pytest
from geometry_msgs.msg import PoseWithCovarianceStamped
from lifecycle_msgs.srv import GetState
from rclpy.qos import DurabilityPolicy, QoSProfile

from sim.world.world import World

WORLD = World.model_validate(
    {"name": "open", "size": [4, 4], "spawn": {"x": -0.5, "y": 0.25, "yaw": 90}}
)


def test_programs_for_nav2_find_the_robot_localised(make_stage):
    """They ask AMCL for its state, and wait for a pose of its."""
    here = make_stage(WORLD, lean=False)
    asked = here.ear.create_client(GetState, "amcl/get_state").call_async(GetState.Request())
    poses: list[PoseWithCovarianceStamped] = []
    qos = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    here.ear.create_subscription(PoseWithCovarianceStamped, "amcl_pose", poses.append, qos)
    here.run(1_100_000_000)
    assert asked.result().current_state.label == "active"
    place = poses[0].pose.pose
    assert (place.position.x, place.position.y) == pytest.approx((-0.5, 0.25), abs=0.01)
    assert place.orientation.z == pytest.approx(math.sin(math.pi / 4), abs=0.01)


def test_amcl_is_left_to_others_with_the_map(make_stage):
    """Two answers to one question would come, and one of them be wrong."""
    node = make_stage(WORLD, lean=False, with_map=False, localises=False).sim
    names = {name for name, _ in node.get_service_names_and_types()}
    assert not {name for name in names if "amcl" in name}
