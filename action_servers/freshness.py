"""Whether an observation is recent enough to drive by."""

from __future__ import annotations

from action_servers.maneuver import ErrorCode, Finished, Observation

STALE_AFTER_S = 1.0
"""Age in seconds at which a scan or odometry is no longer trusted: five turns of the slowest
lidar of a TurtleBot3 (LDS-01, 5 Hz), twenty messages of its odometry."""


def stale(now: Observation) -> Finished | None:
    """Return how a goal ends that drives without fresh scan and odometry, or None if both are.

    A stamp from the future is as bad as one from the past: both come from clocks that differ.
    """
    odometry_stamp = None if now.odom is None else now.odom_stamp_s
    scan_stamp = None if now.scan is None else now.scan.stamp_s
    reason = _fault("odometry", odometry_stamp, now.time_s)
    if reason is not None:
        return Finished("aborted", ErrorCode.NO_ODOMETRY, reason)
    reason = _fault("scan", scan_stamp, now.time_s)
    if reason is not None:
        return Finished("aborted", ErrorCode.NO_SCAN, reason)
    return None


def _fault(what: str, stamp_s: float | None, time_s: float) -> str | None:
    if stamp_s is None:
        return f"no {what} has arrived yet; is the robot running?"
    age = time_s - stamp_s
    if age > STALE_AFTER_S:
        return f"the last {what} is {age:.2f} s old, more than {STALE_AFTER_S:g} s"
    if age < -STALE_AFTER_S:
        return f"the last {what} is stamped {-age:.2f} s in the future; do the clocks agree?"
    return None
