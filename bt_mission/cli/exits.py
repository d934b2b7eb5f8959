"""Exit codes of the command line."""

SUCCESS = 0
MISSION_FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130
"""128 + SIGINT, as shells report it."""
