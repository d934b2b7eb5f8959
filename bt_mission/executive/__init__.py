"""The executive: ticks a mission's tree, and records what happens (docs/reference/trace.md)."""
