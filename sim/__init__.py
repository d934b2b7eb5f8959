"""A TurtleBot3 in MuJoCo: worlds, robot and sensors (pure), and one ROS node over them."""
