"""Shared constants of the plugin's modules that every session of pytest imports."""

MARKER = "scenario"

MOST_RUNS = 5
"""Of a test with more runs only the last are reported and saved: hypothesis ends with the smallest
example."""
