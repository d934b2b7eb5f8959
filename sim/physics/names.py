"""The names of the parts of the MuJoCo model, how they touch, and what sees them."""

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
LOOSE_PREFIX = "object/"
MODEL_PREFIX = "model/"
"""Of the names in a robot's own model."""
WHEELS = ("wheel_left", "wheel_right")
SERVOS = ("servo_ahead", "servo_left", "servo_turn")
FLOOR_CONTACTS = "floor contacts"
ACCELEROMETER = "accelerometer"
CAMERA = "camera"

# Geom groups. MuJoCo draws 0 to 2 by default; the lidar sees solid geoms, and the screens of other
# robots. Nothing sees hidden geoms.
SOLID, MARKS, LOOKS, ROBOT, SCREENS, NOWHERE = 0, 1, 2, 3, 4, 5

# Bits of contype and conaffinity: the robot touches floor and obstacles; these do not touch each
# other. Several robots touch each other, too. Nothing touches a screen, but a geom without any bit
# is left out of its body's bounds, and rays that pass beside these miss it.
# Loose objects touch everything solid.
FLOOR_BIT, OBSTACLE_BIT, ROBOT_BIT, SCREEN_BIT, LOOSE_BIT = 1, 2, 4, 8, 16

JOINT_GROUP = 30
"""The actuators of arms and grippers: power of the motors of wheels does not act on them."""

# Stiffer than MuJoCo's defaults (0.02; 0.9, 0.95): a wheel rolls on the radius that remains where
# it sinks in, and odometry is wrong by that amount.
SOLREF = (0.01, 1.0)
SOLIMP = (0.95, 0.99, 0.001, 0.5, 2.0)

# Friction: sliding, torsional, rolling. MuJoCo takes the larger of the two that touch.
GRIP = (1.0, 0.005, 0.0001)  # rubber on a clean floor
SLIDE = (0.4, 0.005, 0.0001)  # plastic along a wall

PUSH = 0.75
"""The part of the wheels' grip that the motors can push with.

A robot that drives against a wall then stalls and stands. With enough strength to slip, its wheels
grip and slip in turns, and it trembles by 6 mm.
"""

GEARS = 0.4
"""The part of its weight with which the gears of a planar base brake it without power: that of a
TurtleBot3."""

GEAR_FRICTION = 0.1
"""N m: the torque with which a motor's gear brakes a wheel without power (frictionloss of the
joints in ROBOTIS's MuJoCo models).
"""
