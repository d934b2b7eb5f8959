"""Scenarios as data: a mission, its place, what goes wrong, and the expected result.

- ``scenario``: :class:`Scenario`, and the outcome of a run of it
- ``file``: the form of a scenario file
- ``faults``: its faults and obstacles, as text or as mappings
- ``servers``: its scripted action servers
- ``loader``: from a file to a scenario, or every error in it
- ``run``: runs a scenario
- ``schema``: the JSON Schema for editors
- ``writer``: the scenario of a run that a test has made
"""
