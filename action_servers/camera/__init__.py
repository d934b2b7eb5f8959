"""Maneuvers that take pictures."""
