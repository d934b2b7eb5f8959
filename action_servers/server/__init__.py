"""The node of the action servers: one adapter between an action and a maneuver."""
