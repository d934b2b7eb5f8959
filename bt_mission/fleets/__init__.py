"""Fleets: several robots in one world, each with its mission, and what a run of them came to.

- ``file``: what stands in a fleet file, and its JSON Schema
- ``plan``: what a fleet file says
- ``loader``: from a file to a plan, or every error in it
- ``report``: what a run came to
- ``run``: carries a fleet out
"""
