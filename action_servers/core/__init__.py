"""What maneuvers are made of: observations, limits, clearance, the pilot. Pure: no ROS."""
