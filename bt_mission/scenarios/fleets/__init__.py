"""Fleets: several robots in one world, each with its mission, and the reports of their runs.

- ``file``: the form of a fleet file, and its JSON Schema
- ``plan``: what a fleet file says
- ``loader``: from a file to a plan, or every error in it
- ``report``: the outcome of a run
- ``run``: runs a fleet
"""
