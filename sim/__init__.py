"""A TurtleBot3 in MuJoCo: worlds, robot and sensors (pure), and one ROS node over them."""

import os

# MuJoCo imports the renderer that this names, and fails where it cannot; we choose our own.
os.environ.pop("MUJOCO_GL", None)
