from action_servers.core.maneuver import Pose2D
from action_servers.navigation.progress import ProgressChecker


def test_time_counts_from_the_last_move_that_matters():
    """Trembling by a centimetre is none, 0.06 m is, and so is a turn by 0.3 rad."""
    progress = ProgressChecker()
    times = [
        (10.0, Pose2D(0.0, 0.0, 0.0), 0.0),
        (11.0, Pose2D(0.01, 0.0, 0.0), 1.0),
        (12.0, Pose2D(0.06, 0.0, 0.0), 0.0),
        (13.0, Pose2D(0.06, 0.0, 0.1), 1.0),
        (14.0, Pose2D(0.06, 0.0, 0.3), 0.0),
    ]
    for time_s, pose, standing_s in times:
        assert progress.standing_s(pose, time_s) == standing_s


def test_restarting_counts_from_now():
    """Waiting on purpose is not being stuck."""
    progress = ProgressChecker()
    progress.standing_s(Pose2D(0.0, 0.0, 0.0), 10.0)
    progress.restart()
    assert progress.standing_s(Pose2D(0.0, 0.0, 0.0), 15.0) == 0.0
