"""A map from the scans of the lidar: built, measured, saved, and explored to its edges."""
