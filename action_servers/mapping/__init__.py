"""A map of what the lidar has seen: built, measured, saved, and explored to its edges."""
