"""The ROS node of the simulation: topics, services, time."""
