"""Waypoint navigation in the words of Nav2: plan on the map, follow, look, plan again."""
