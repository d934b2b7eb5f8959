"""Figures of the robot models: hull, limits, sensors."""
