"""The servers on a bench, as fixtures."""

from tests.support.bench_fixtures import bench, goal_, pose_, robot_node, silent_bench

__all__ = ["bench", "goal_", "pose_", "robot_node", "silent_bench"]
