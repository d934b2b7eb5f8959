"""The parts of maneuvers: observations, limits, clearance, the pilot. Pure: no ROS."""
