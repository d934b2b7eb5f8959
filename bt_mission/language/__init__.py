"""The mission language: YAML in, frozen and checked steps out. No ROS."""
