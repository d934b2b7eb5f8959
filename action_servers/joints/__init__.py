"""Arms and grippers: the actions of ros2_control over positions of joints."""
