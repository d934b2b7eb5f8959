"""``bt-mission new``: a project with a mission, a world, a test and editor settings."""
