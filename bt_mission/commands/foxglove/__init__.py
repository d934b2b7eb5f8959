"""The topics of a graph for Foxglove and Lichtblick, live."""

from pathlib import Path

LAYOUT = Path(__file__).with_name("layout.json")
"""Panels for a mission, to import in the application."""
