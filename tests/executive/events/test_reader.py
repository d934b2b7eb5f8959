"""Messages as plain data; anything with their fields will do."""

from __future__ import annotations

import math

from bt_mission_interfaces.msg import (
    GoalRecord,
    MissionDetails,
    NodeProgress,
    NodeStatus,
    StatusChanges,
    Tree,
    TreeNode,
    Variable,
)
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, TransformStamped
from nav_msgs.msg import OccupancyGrid
from sensor_msgs.msg import LaserScan
from std_msgs.msg import ColorRGBA
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from bt_mission.executive.events import events, messages, reader
from bt_mission.executive.goals.poses import NamedPose


def test_a_parent_that_comes_later_is_taken_for_the_root():
    """Whatever an executive sends, no walk to the root goes round in circles."""
    nodes = [TreeNode(name="a", parent=0), TreeNode(name="b", parent=2), TreeNode(name="c")]
    (tree,) = reader.tree(Tree(nodes=nodes)).events
    assert isinstance(tree, events.RunStarted)
    assert [node.parent for node in tree.nodes] == [0, 0, 0]


def test_the_codes_of_statuses_are_those_of_the_interface():
    """A code that is none counts as not run."""
    codes = [NodeStatus.INVALID, NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE, 77]
    message = StatusChanges(changes=[NodeStatus(node=i, status=c) for i, c in enumerate(codes)])
    changes = reader.changes(message).events
    names = [change.status.name for change in changes if isinstance(change, events.NodeChanged)]
    assert names == ["INVALID", "RUNNING", "SUCCESS", "FAILURE", "INVALID"]


def test_details_keep_times_and_places():
    """Every field has its counterpart."""
    message = MissionDetails(
        stamp=Time(sec=3, nanosec=5),
        run="r",
        ticks=7,
        goals_sent=2,
        running=[NodeProgress(node=1, since=Time(sec=1), label="s", value=2.0, limit=30.0)],
        goals=[GoalRecord(goal_id="ab", state="active", targets=[Point(x=1.0, y=-2.0)])],
        variables=[Variable(name="legs", value="6")],
        breakpoints=["0.1"],
    )
    at_ns, place = 3_000_000_005, NamedPose(1.0, -2.0, 0.0, "map")
    assert reader.details(message) == messages.Batch(
        "r",
        (
            events.CountsChanged(at_ns, 7, 2),
            events.BreakpointsChanged(at_ns, ("0.1",)),
            events.NodeProgressed(at_ns, 1, 1_000_000_000, "", "s", 2.0, 30.0),
            events.GoalChanged(0, "ab", "", "", 0, "active", targets=(place,)),
            events.VariableChanged(at_ns, "legs", "6"),
        ),
    )


def test_a_reset_follows_the_changes_of_its_tick():
    """Nodes that had ended are reset to INVALID after that."""
    message = StatusChanges(stamp=Time(sec=1), run="r", sequence=3, reset=[4, 5])
    assert reader.changes(message) == messages.Batch(
        "r", (events.NodesReset(1_000_000_000, (4, 5)),), 3
    )


def test_frames_are_seen_from_above():
    """A quarter turn about the vertical axis; leading slashes of old names go."""
    message = TransformStamped()
    message.header.frame_id, message.child_frame_id = "/odom", "base_footprint"
    message.transform.translation.x = 1.5
    message.transform.rotation.z = message.transform.rotation.w = math.sqrt(0.5)
    (transform,) = reader.transforms(TFMessage(transforms=[message]))
    assert (transform.parent, transform.child) == ("odom", "base_footprint")
    assert (transform.x, transform.y) == (1.5, 0.0)
    assert math.isclose(transform.yaw, math.pi / 2)


def test_cells_of_a_map_are_signed_bytes():
    """-1 is unknown."""
    message = OccupancyGrid(data=[0, 100, -1])
    message.info.width, message.info.height, message.info.resolution = 3, 1, 0.5
    grid = reader.grid(message)
    assert (grid.cells, grid.width, grid.resolution) == (bytes([0, 100, 255]), 3, 0.5)


def test_a_scan_keeps_its_rays():
    """As they are, infinite ones too."""
    scan = reader.scan(LaserScan(ranges=[1.0, math.inf], angle_min=0.5, range_max=3.5))
    assert (scan.ranges, scan.angle_min, scan.range_max) == ((1.0, math.inf), 0.5, 3.5)


def test_zones_are_discs_with_the_text_of_their_number():
    """What is no disc, or has no size or place, is left out; a colour that is none is black."""

    def marker(number: int, kind: int, x: float, diameter: float = 1.0, **more: str) -> Marker:
        made = Marker(id=number, type=kind, color=ColorRGBA(r=1.0, g=0.5, b=math.nan), **more)
        made.pose.position.x, made.scale.x = x, diameter
        return made

    result = reader.zones(
        MarkerArray(
            markers=[
                marker(0, Marker.CYLINDER, 1.5),
                marker(0, Marker.TEXT_VIEW_FACING, 1.5, text="dock"),
                marker(1, Marker.CYLINDER, math.nan),
                marker(2, Marker.CYLINDER, 1.0, 0.0),
                marker(3, Marker.ARROW, 1.0),
                marker(4, Marker.CYLINDER, 2.0, 3.0),
            ]
        )
    )
    dock = messages.ZoneDisc("dock", 1.5, 0.0, 0.5, "#ff8000")
    other = messages.ZoneDisc("", 2.0, 0.0, 1.5, "#ff8000")
    assert result == messages.Zones((dock, other))


def test_not_more_zones_are_kept_than_a_map_can_show():
    """Whatever a publisher sends."""
    discs = [Marker(id=number, type=Marker.CYLINDER) for number in range(reader.MOST_ZONES + 1)]
    for disc in discs:
        disc.scale.x = 1.0
    assert len(reader.zones(MarkerArray(markers=discs)).zones) == reader.MOST_ZONES
