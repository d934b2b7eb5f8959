"""The executive's ROS side: node, clients, publishers, services, and the graph around it."""
