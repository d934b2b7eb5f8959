"""Missions as behaviour trees over ROS 2 actions: language, tree, executive, command line."""
