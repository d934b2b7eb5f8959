"""Actions, topics and services by session: what a person at a terminal does with any ROS graph."""
