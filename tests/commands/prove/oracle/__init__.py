"""Random missions, and random runs of them that share no code with `bt_mission.commands.prove`."""
