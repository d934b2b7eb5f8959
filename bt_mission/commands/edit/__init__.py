"""Missions edited as text: patches of nodes, an outline for drawings, completion and hover."""
