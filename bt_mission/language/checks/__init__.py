"""Checks of a mission before anything moves."""
