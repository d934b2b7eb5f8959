"""Exit codes of the command line."""

SUCCESS = 0
MISSION_FAILED = 1
BAD_INPUT = 2
NOTHING_FOUND = 1
"""No page of the documentation has the words."""
UNKNOWN = 3
"""Of requirements: a recording does not tell."""
INTERRUPTED = 130
"""128 + SIGINT, as shells report it."""

# Of actions and services by hand.
ABORTED = 1
"""The goal was aborted; a service answered that it had no success."""
REJECTED = 3
CANCELED = 4
NO_SERVER = 5
"""Nobody in the graph offers it."""
LOST = 6
"""The server has gone, or does not answer: nobody knows what became of it."""
