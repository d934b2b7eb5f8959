"""Maneuvers that drive or turn the base, and those that wait or measure beside them."""
