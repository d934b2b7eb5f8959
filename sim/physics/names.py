"""What the parts of the MuJoCo model are called, how they touch, and who sees them."""

from __future__ import annotations

STEP_NS = 5_000_000
"""One physics step, ns."""

BASE = "base"
FLOOR = "floor"
OBSTACLES = "obstacles"
OBSTACLE_PREFIX = "obstacle/"
MOVER_PREFIX = "mover/"
PROPS = "props"
PROP_PREFIX = "prop/"
WHEELS = ("wheel_left", "wheel_right")
FLOOR_CONTACTS = "floor contacts"
ACCELEROMETER = "accelerometer"
CAMERA = "camera"

# Geom groups. MuJoCo draws 0 to 2 unless told otherwise; the lidar sees what is
# solid, and the screens of other robots. Nothing sees what is nowhere.
SOLID, MARKS, LOOKS, ROBOT, SCREENS, NOWHERE = 0, 1, 2, 3, 4, 5

# Bits of contype and conaffinity: the robot touches floor and obstacles, these not each other.
# Several robots touch each other, too. Nothing touches a screen, but what has no bit at all is
# left out of its body's bounds, and rays that pass beside these are not looked at.
FLOOR_BIT, OBSTACLE_BIT, ROBOT_BIT, SCREEN_BIT = 1, 2, 4, 8

# Stiffer than MuJoCo's defaults (0.02; 0.9, 0.95): a wheel rolls on the radius that is left of it
# where it sinks in, and odometry goes wrong by as much.
SOLREF = (0.01, 1.0)
SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)

# Friction: sliding, torsional, rolling. MuJoCo takes the larger of the two that touch.
GRIP = (1.0, 0.005, 0.0001)  # rubber on a clean floor
SLIDE = (0.4, 0.005, 0.0001)  # plastic along a wall

GEAR_FRICTION = 0.1
"""N m: what a motor's gear holds a wheel back with when there is no power (frictionloss of the
joints in ROBOTIS's own MuJoCo models)."""
