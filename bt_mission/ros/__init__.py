"""The executive's only way to ROS: node, clients, publishers, services; the graph around it."""
