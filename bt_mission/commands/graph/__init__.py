"""Actions, topics and services of any ROS graph, from a terminal."""
