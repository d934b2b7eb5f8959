"""The journal of a mission on disk, and resuming a mission after the death of its process."""
