"""How servers notice that the executive of a mission has died, when both are processes.

The executive owns a topic on which it never says anything. DDS itself, on a thread of its own,
assures the readers that its writer is alive; a process that is killed no longer does.
"""

from __future__ import annotations

TOPIC = "bt_mission_executive"
"""Relative to the namespace of the robot."""

ASSURED_S = 0.1
"""What the writer promises, s of the wall clock: DDS assures it every two thirds of that, so that
of the assurances within a lease one may be lost, or late."""

LEASE_S = 0.2
"""Seconds of the wall clock without assurance after which the servers hold the base, by default:
with the 0.26 s that braking from full speed takes, it stands within 0.5 s."""

TIMEOUT_S = 2.0
"""Seconds of the wall clock without assurance after which the executive counts as dead, by
default, and its goals are aborted."""

EXECUTIVE_LOST = 911
"""`error_code` of the result of a goal that was aborted because its executive counted as dead."""

RECORDER = "bt_mission_recorder"
"""Name of the node of a recorder. It listens to everything, and moves no robot: where somebody has
to be there to listen, it does not count."""
