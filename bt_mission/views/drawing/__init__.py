"""A mission's tree as text and as pictures; nothing of ROS is needed."""
