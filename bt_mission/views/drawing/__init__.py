"""A mission's tree as text and as drawings, without ROS."""
