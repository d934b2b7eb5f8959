"""Load, check and run missions: on the stage, attached to a graph, or served as an action."""
