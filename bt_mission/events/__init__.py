"""The state of a mission in another process, and how it is shown: pure, from plain data."""
