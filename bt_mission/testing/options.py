"""What the modules of the plugin share that every session of pytest imports."""

MARKER = "scenario"

MOST_RUNS = 5
"""Of a test with more runs only the last are told of and kept: hypothesis ends with the smallest
example."""
