"""The generated types: exact fields, codes and hashes, which are what goes over the wire."""

import pytest
from bt_mission_interfaces.action import (
    CameraSweep,
    ExecuteMission,
    ExploreForward,
    ExploreFrontiers,
    FindColour,
    Move,
    RecordDistance,
    TakePictures,
    Turn,
)
from bt_mission_interfaces.msg import (
    Collision,
    Coverage,
    MissionState,
    NodeStatus,
    Requirement,
    Requirements,
    StatusChanges,
    Tree,
    TreeNode,
)
from bt_mission_interfaces.srv import GetStatuses, PauseMission, ReviseMission, SetBreakpoint
from example_interfaces.action import Fibonacci
from example_interfaces.srv import AddTwoInts
from rclpy.type_support import check_for_type_support
from tf2_msgs.msg import TFMessage

from action_servers.core.error_codes import ErrorCode
from action_servers.server.actions import generated_type
from tests.support.served import SERVED

FIELDS = [
    (ExploreForward.Goal, "float fwd_velocity, float stopping_distance"),
    (
        ExploreForward.Result,
        (
            "float total_distance_travelled, float closest_obstacle, "
            "float closest_obstacle_angle, uint16 error_code, string error_msg"
        ),
    ),
    (ExploreForward.Feedback, "float current_distance_travelled, float closest_obstacle"),
    (Turn.Goal, "float angle, float angular_velocity"),
    (Turn.Result, "float angle_turned, uint16 error_code, string error_msg"),
    (Turn.Feedback, "float current_angle, float remaining_angle"),
    (CameraSweep.Goal, "float sweep_angle, int32 image_count"),
    (
        CameraSweep.Result,
        "string image_path, sequence<string> image_paths, uint16 error_code, string error_msg",
    ),
    (CameraSweep.Feedback, "int32 current_image, float current_angle"),
    (Move.Goal, "int32 secs, float linear_velocity, float angular_velocity"),
    (Move.Result, "string status, uint16 error_code, string error_msg"),
    (Move.Feedback, "string feedback"),
    (RecordDistance.Goal, "int32 seconds"),
    (
        RecordDistance.Result,
        "boolean status, double total_dist, uint16 error_code, string error_msg",
    ),
    (RecordDistance.Feedback, "double current_dist"),
    (TakePictures.Goal, "int32 nseconds"),
    (
        TakePictures.Result,
        ("sequence<sensor_msgs/CompressedImage> all_pictures, uint16 error_code, string error_msg"),
    ),
    (TakePictures.Feedback, "sensor_msgs/CompressedImage last_image"),
    (FindColour.Goal, "string colour, float min_share"),
    (FindColour.Result, "float angle, float share, uint16 error_code, string error_msg"),
    (FindColour.Feedback, "float angle, float share"),
    (ExploreFrontiers.Goal, "float max_duration, float min_frontier"),
    (
        ExploreFrontiers.Result,
        "int32 frontiers_visited, float area_mapped, uint16 error_code, string error_msg",
    ),
    (ExploreFrontiers.Feedback, "int32 frontiers_left, float area_mapped"),
    (ExecuteMission.Goal, "string path, string text, sequence<string> inputs, int64 seed"),
    (
        ExecuteMission.Result,
        (
            "string status, string summary, double duration, uint32 ticks, uint32 goals_sent, "
            "uint32 goals_left_behind, uint16 error_code, string error_msg"
        ),
    ),
    (
        ExecuteMission.Feedback,
        (
            "string status, string tip, sequence<string> running, sequence<string> doing, "
            "double elapsed"
        ),
    ),
    (
        TreeNode,
        "string name, string kind, string path, uint32 parent, sequence<string> details",
    ),
    (
        Tree,
        (
            "builtin_interfaces/Time stamp, string run, string mission, "
            "sequence<bt_mission_interfaces/TreeNode> nodes, uint32 revision, "
            "builtin_interfaces/Time revised, sequence<int32> kept, string summary, "
            "string file, string sha256"
        ),
    ),
    (NodeStatus, "uint32 node, uint8 status, string message"),
    (
        StatusChanges,
        (
            "builtin_interfaces/Time stamp, string run, uint32 sequence, uint32 revision, "
            "sequence<bt_mission_interfaces/NodeStatus> changes, sequence<uint32> reset"
        ),
    ),
    (
        Requirement,
        (
            "string name, string requirement, string verdict, string outcome, double margin, "
            "string unit, double at, double violated_at, string on_violation, "
            "sequence<string> sources, string why"
        ),
    ),
    (
        Requirements,
        (
            "builtin_interfaces/Time stamp, string run, "
            "sequence<bt_mission_interfaces/Requirement> requirements"
        ),
    ),
    (
        MissionState,
        ("builtin_interfaces/Time stamp, string run, string mission, string status, string reason"),
    ),
    (PauseMission.Request, "boolean keep_goals"),
    (PauseMission.Response, "boolean success, string message"),
    (
        ReviseMission.Request,
        (
            "string file, string text, sequence<string> include_names, "
            "sequence<string> include_texts, boolean dry_run, boolean keep_goals"
        ),
    ),
    (ReviseMission.Response, "boolean success, string message, string revision"),
    (SetBreakpoint.Request, "string node, boolean remove"),
    (SetBreakpoint.Response, "boolean success, string message, sequence<string> breakpoints"),
    (
        GetStatuses.Response,
        (
            "string run, uint32 sequence, uint32 revision, "
            "sequence<bt_mission_interfaces/NodeStatus> statuses"
        ),
    ),
    (
        Coverage,
        "std_msgs/Header header, float area, float fraction, int32 zones_visited, int32 zones",
    ),
    (
        Collision,
        "std_msgs/Header header, string obstacle, geometry_msgs/Point point, double force",
    ),
    (Fibonacci.Goal, "int32 order"),
    (Fibonacci.Result, "sequence<int32> sequence"),
    (Fibonacci.Feedback, "sequence<int32> sequence"),
    (AddTwoInts.Request, "int64 a, int64 b"),
    (AddTwoInts.Response, "int64 sum"),
    (TFMessage, "sequence<geometry_msgs/TransformStamped> transforms"),
]


@pytest.mark.parametrize(
    ("message", "fields"), [pytest.param(*row, id=row[0].__name__) for row in FIELDS]
)
def test_fields_are_exactly_these(message, fields):
    """Name, type and order of each field: all three are part of the type's hash."""
    results = message.get_fields_and_field_types().items()
    assert ", ".join(f"{kind} {name}" for name, kind in results) == fields


CODES = {
    "base": {"BLOCKED", "MOTORS_OFF"},
    "scan": {"NO_SCAN"},
    "odometry": {"NO_ODOMETRY"},
    "map": {"NO_MAP"},
    "camera": {"NO_IMAGE"},
}
"""The error codes that come with what an action needs."""

OURS = [served.action for served in SERVED.values() if served.action.type.startswith("bt_mission_")]


@pytest.mark.parametrize("action", OURS, ids=lambda action: action.name)
def test_one_error_code_means_the_same_in_every_action(action):
    """The codes of the maneuvers, from 900 up, apart from Nav2's, follow from what it needs."""
    result = generated_type(action.type).Result
    shared = {code.name: int(code) for code in ErrorCode}
    codes = {name: getattr(result, name) for name in shared if hasattr(result, name)}
    assert codes.items() <= shared.items()
    needed = set().union(*(CODES[need] for need in action.needs))
    storage = {"STORAGE"} if action.name == "camera_sweep" else set()
    assert codes.keys() == {"NONE", "UNKNOWN", "STOPPED"} | needed | storage
    assert all(code == 0 or code >= 900 for code in codes.values())


@pytest.mark.parametrize("action", [*(served.type for served in SERVED.values()), Fibonacci])
def test_every_action_has_type_support(action):
    """The C libraries behind each action load: goals can be served and sent."""
    for part in (action.Goal, action.Result, action.Feedback, action.Impl.FeedbackMessage):
        check_for_type_support(part)
        assert part.__class__._TYPE_SUPPORT is not None


def test_tf_message_goes_out_under_the_type_hash_of_jazzy(rig):
    """The hash that DDS announces for /tf is the one recorded in bags of a real Jazzy."""
    node = rig.node("test_types")
    node.create_publisher(TFMessage, "tf", 1)
    (info,) = node.get_publishers_info_by_topic("tf")
    assert str(info.topic_type_hash) == (
        "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"
    )
