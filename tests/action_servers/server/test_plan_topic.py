"""The path that is being driven."""

from pathlib import Path as File

from nav_msgs.msg import Path

from bt_mission.sessions.load import load
from bt_mission.sessions.stage import Stage

MISSION = """\
mission: there
world: empty_arena
tree: {navigate_to_pose: {pose: [0.5, 0.5, 0]}, timeout: 30}
"""


def run(folder: File, *, listens: bool) -> tuple[list[Path], str]:
    """The paths that somebody hears during a mission, and its trace."""
    paths: list[Path] = []
    with Stage(load(MISSION), image_folder=folder) as stage:
        if listens:
            node = stage.make_node("listener")
            node.create_subscription(Path, "plan", paths.append, 1)
        while not stage.is_done:
            stage.step()
        return paths, stage.trace.sha256


def test_a_path_leads_from_the_robot_to_the_goal(tmp_path: File) -> None:
    """In the map, with the time at which it was planned; and nothing else changes by it."""
    received, trace = run(tmp_path, listens=True)
    first = received[0]
    begin, end = first.poses[0].pose.position, first.poses[-1].pose.position
    assert (first.header.frame_id, first.header.stamp.sec) == ("map", 1)
    assert abs(begin.x) + abs(begin.y) < 0.1
    assert abs(end.x - 0.5) + abs(end.y - 0.5) < 0.1
    assert run(tmp_path, listens=False) == ([], trace)
