"""Action servers of the robot: pure maneuvers, the pilot that owns the base, one adapter to ROS."""
