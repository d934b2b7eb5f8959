"""Waypoint navigation with Nav2's interfaces: plan on the map, follow, look, plan again."""
