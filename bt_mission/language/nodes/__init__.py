"""The kinds of node of the mission language."""
