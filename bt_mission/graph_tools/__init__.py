"""Actions, topics and services by hand: what a person at a terminal does with any ROS graph."""
