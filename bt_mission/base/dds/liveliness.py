"""How servers notice that the executive of a mission has died, if both are processes.

The executive has a topic without messages. DDS, on its own thread, announces to the readers that
its writer is alive; a killed process stops doing that.
"""

from __future__ import annotations

TOPIC = "bt_mission_executive"
"""Relative to the namespace of the robot."""

ASSURED_S = 0.1
"""The writer's promise, s of the wall clock: DDS announces every two thirds of that, so that one
announcement within a lease may be lost, or late.
"""

LEASE_S = 0.2
"""Seconds of the wall clock without an announcement after which the servers hold the base, by
default: with the 0.26 s of braking from full speed, it stands within 0.5 s.
"""

TIMEOUT_S = 2.0
"""Seconds of the wall clock without assurance after which the executive counts as dead, by
default, and its goals are aborted."""

EXECUTIVE_LOST = 911
"""`error_code` of the result of a goal that was aborted because its executive counted as dead."""

RECORDER = "bt_mission_recorder"
"""Name of the node of a recorder. It subscribes to everything, and moves no robot: it does not
count as a subscription.
"""
